// person: whom the robot helps, and whose actions are the abstract test.
//
// Beliefs that meta chooses from:
//   first_K, second_K, third_K   what is ordered: K is fridge, sink, feed, clean or unknown
//   says_W                       what an unknown order is: W is chase, opendoor or recharge; without any it is whatever
//   the manner                   impatient, insistent, fickle, meddling, obstinate, restless or lingering; without any
//                                an order is given only when the one before should be done
//   dog_follows                  the dog goes with the robot, and has to be called
//   leaves                       says that there are no more orders, and waits for nothing
// fridge, sink, ... are orders after which the person waits for as long as the robot needs for them. ask(K) is an order
// after which the person goes on at once. A second is a millisecond for the agents.

time_for(fridge, 105).      // s: the middle of the ranges of the published experiment
time_for(sink, 105).
time_for(feed, 135).
time_for(clean, 155).
time_for(whatever, 15).
time_for(chase, 15).
time_for(opendoor, 15).
time_for(recharge, 15).
long_enough(155).           // s, for any order
a_moment(5).                // s
a_rest(80).                 // s, longer than the robot does without an order

on_way(fridge, kitchen).    // where the robot comes by
on_way(sink, kitchen).
on_way(feed, doorway).
on_way(clean, doorway).
on_way(whatever, charger).
on_way(chase, charger).
on_way(opendoor, charger).
on_way(recharge, charger).

goal_of(fridge, fridge).    // where it has to come to
goal_of(sink, sink).
goal_of(feed, table).
goal_of(clean, sink).
goal_of(whatever, charger).
goal_of(chase, charger).
goal_of(opendoor, charger).
goal_of(recharge, charger).

+!live
   <- !first;
      !second;
      !third;
      !end;
      .send(robot, tell, left).

// --- what is ordered

@first_fridge  +!first : first_fridge  <- !want(fridge).
@first_sink    +!first : first_sink    <- !want(sink).
@first_feed    +!first : first_feed    <- !want(feed).
@first_clean   +!first : first_clean   <- !want(clean).
@first_unknown +!first : first_unknown <- !want_unknown.
+!first.

@second_fridge  +!second : second_fridge  <- !want(fridge).
@second_sink    +!second : second_sink    <- !want(sink).
@second_feed    +!second : second_feed    <- !want(feed).
@second_clean   +!second : second_clean   <- !want(clean).
@second_unknown +!second : second_unknown <- !want_unknown.
+!second.

@third_fridge  +!third : third_fridge  <- !want(fridge).
@third_sink    +!third : third_sink    <- !want(sink).
@third_feed    +!third : third_feed    <- !want(feed).
@third_clean   +!third : third_clean   <- !want(clean).
@third_unknown +!third : third_unknown <- !want_unknown.
+!third.

// What the robot cannot do.
@chase    +!want_unknown : says_chase    <- !want(chase).
@opendoor +!want_unknown : says_opendoor <- !want(opendoor).
@recharge +!want_unknown : says_recharge <- !want(recharge).
@whatever +!want_unknown                 <- !want(whatever).

// --- how it is ordered

// One order after the other, whatever the robot is at.
@impatient +!want(Kind) : impatient
   <- !ask(Kind);
      +owed.

// Three times, a moment apart, and once more for the next one: the robot has more to do than it can keep in mind.
@insistent +!want(Kind) : insistent
   <- !ask(Kind);
      !moment;
      !ask(Kind);
      !moment;
      !ask(Kind);
      +owed.

// Wants something else soon, and walks away meanwhile. The next order is meant.
@fickle +!want(Kind) : fickle & not settled
   <- +settled;
      !ask(Kind);
      walk(tv);
      !moment;
      +owed.

@settled +!want(Kind) : fickle
   <- sit;
      -owed;
      !ask(Kind);
      !wait_long.

// Stands where the robot comes by.
@meddling +!want(Kind) : meddling
   <- !ask(Kind);
      !moment;
      ?on_way(Kind, Place);
      !stand_at(Place);
      !wait_long;
      !sit_down.

// Stands where the robot has to come to, and stays there unless asked to go.
@obstinate +!want(Kind) : obstinate
   <- !ask(Kind);
      !moment;
      ?goal_of(Kind, Place);
      !stand_at(Place);
      !wait_long;
      !sit_down.

// Walks about while the robot drives.
@restless +!want(Kind) : restless
   <- !ask(Kind);
      walk(tv);
      !moment;
      walk(kitchen);
      !moment;
      sit;
      !wait_long.

// Rests afterwards, for longer than the robot does without an order.
@lingering +!want(Kind) : lingering
   <- !ask(Kind);
      !wait_long;
      rest;
      ?a_rest(Time);
      .wait(Time).

// As in the published experiment.
@patient_fridge   +!want(fridge)   <- fridge;   !order(fridge);   !wait_for(fridge).
@patient_sink     +!want(sink)     <- sink;     !order(sink);     !wait_for(sink).
@patient_feed     +!want(feed)     <- feed;     !order(feed);     !wait_for(feed).
@patient_clean    +!want(clean)    <- clean;    !order(clean);    !wait_for(clean).
@patient_whatever +!want(whatever) <- whatever; !order(whatever); !wait_for(whatever).
@patient_chase    +!want(chase)    <- chase;    !order(chase);    !wait_for(chase).
@patient_opendoor +!want(opendoor) <- opendoor; !order(opendoor); !wait_for(opendoor).
@patient_recharge +!want(recharge) <- recharge; !order(recharge); !wait_for(recharge).

+!ask(Kind)
   <- ask(Kind);
      !order(Kind).

+!order(Kind)
   <- .send(robot, tell, order(Kind)).

+!wait_for(Kind)
   <- ?time_for(Kind, Time);
      .wait(Time).

+!wait_long
   <- wait;
      ?long_enough(Time);
      .wait(Time).

+!moment
   <- ?a_moment(Time);
      .wait(Time).

// --- in the way, and out of it

@stands_in_way +!stand_at(Place)
   <- walk(Place);
      +standing_at(Place);
      .send(sensors, tell, person_at(Place)).

@sits_down +!sit_down : standing_at(Place)
   <- sit;
      -standing_at(Place);
      .send(sensors, untell, person_at(Place)).

+!sit_down.

// --- what the person sees of the robot, and hears

// It stands still, because of the person: who only meddles goes.
@lets_pass +held_up[source(robot)] : meddling & standing_at(_)
   <- -held_up[source(robot)];
      !sit_down.

@stays +held_up[source(robot)] : standing_at(_)
   <- -held_up[source(robot)].

// It stands still, because of the dog.
@calls_dog +held_up[source(robot)] : dog_follows
   <- -held_up[source(robot)];
      call_dog;
      .send(dog, tell, called).

// It has given up because of the person, who now goes, and asks once more.
@asks_again +given_up(Kind)[source(robot)] : standing_at(_)
   <- -given_up(Kind)[source(robot)];
      !sit_down;
      !ask(Kind).

// It refuses: who insists wants something that it can do.
@something_else +refused(_)[source(robot)] : insistent & not content
   <- +content;
      !ask(fridge).

// It goes to its charger: who rests takes a walk, past there, and sits down again.
@takes_walk +idle[source(robot)] : lingering & not walked
   <- +walked;
      walk(charger);
      !moment;
      sit.

// --- the end

@leaves +!end : leaves
   <- ended;
      !order(ended).

// Who did not wait for one order waits for all of them.
@waits_at_last +!end : owed
   <- !wait_long;
      !wait_long.

+!end.
