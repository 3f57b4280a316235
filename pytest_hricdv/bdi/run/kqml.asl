// What agents do with the messages that are not acted on at once. An agent's own plans
// for kqml_received come first, so a model can change any of this.

+!kqml_received(Sender, tell, Content, _)
   : .literal(Content) & .ground(Content) & .add_nested_source(Content, Sender, Told)
   <- +Told.
+!kqml_received(Sender, tell, Content, _) : .list(Content)
   <- !kqml_tell_each(Sender, Content).
+!kqml_tell_each(_, []).
+!kqml_tell_each(Sender, [First|Others])
   <- .add_nested_source(First, Sender, Told); +Told; !kqml_tell_each(Sender, Others).

+!kqml_received(Sender, untell, Content, _)
   <- .add_nested_source(Content, Sender, Told); -Told.

+!kqml_received(Sender, achieve, Content, _)
   : not .list(Content) & .add_nested_source(Content, Sender, Goal)
   <- !!Goal.
+!kqml_received(Sender, achieve, Content, _) : .list(Content)
   <- for (.member(Each, Content)) { .add_nested_source(Each, Sender, Goal); !!Goal }.

@kqml_unachieve[atomic]
+!kqml_received(_, unachieve, Content, _)
   <- .drop_desire(Content).

+!kqml_received(Sender, askOne, Content, Number)
   <- ?Content; .send(Sender, tell, Content, Number).
-!kqml_received(Sender, askOne, Content, Number)
   <- .send(Sender, untell, Content, Number).

+!kqml_received(Sender, askAll, Content, Number)
   <- .findall(Content, Content, Answers); .send(Sender, tell, Answers, Number).

+!kqml_received(Sender, askHow, Trigger, Number)
   <- .relevant_plans(Trigger, Plans); .send(Sender, tellHow, Plans, Number).

+!kqml_received(Sender, tellHow, Plan, _)
   <- .add_plan(Plan, Sender).

-!kqml_received(_, _, _, _)[error(Error), error_msg(Message)]
   <- .print("Communication error -- ", Error, ": ", Message).

+!kqml_received(Sender, untellHow, Label, _)
   <- .remove_plan(Label, Sender).
