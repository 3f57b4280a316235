// robot: the robot's code as an agent, a plan for each thing that it does.
//
// A second is a millisecond for the agents; how long things take are the beliefs below. Orders that come while it is at
// work are kept in queue(L), in their order.
//
// Each run of the real code can be compared with this agent, too (MODEL in the reports). Its external actions are for
// that: what the robot is seen to do. enter(S) is the state that it says it is in.

travel_time(20).    // s, from one place of the flat to the next one
detour_time(10).    // s, around somebody on the way
grip_time(3).       // s, to close the gripper or to open it
idle_after(30).     // s without an order, after which it goes to its charger
patience(90).       // s, for which somebody may be in its way, at most
queue_limit(5).     // orders that wait, at most

task(fridge).
task(sink).
task(feed).
task(clean).
task(ended).

queue([]).

!begin.

+!begin
   <- enter("Ready");
      !following.

// --- orders are answered at once, whatever it is at

// What it cannot do.
@refuses +order(Kind)[source(person)] : not task(Kind)
   <- -order(Kind)[source(person)];
      refuse(Kind);
      .send(person, tell, refused(Kind)).

// An order after the last one.
+order(Kind)[source(person)] : not Kind == ended & queue(Waiting) & .member(ended, Waiting)
   <- -order(Kind)[source(person)];
      refuse(Kind);
      .send(person, tell, refused(Kind)).

@full +order(Kind)[source(person)] : not Kind == ended & queue(Waiting) & .length(Waiting, Count)
                                   & queue_limit(Limit) & Count >= Limit
   <- -order(Kind)[source(person)];
      refuse(Kind);
      .send(person, tell, refused(Kind)).

// At work: it is done later.
@queues +order(Kind)[source(person)] : at_work
   <- !accept(Kind).

// On its way to the charger, which ends there.
@turns_back +order(Kind)[source(person)] : going_home(Place)
   <- !accept(Kind);
      .drop_intention(go_home);
      -going_home(Place);
      .send(sensors, untell, driving(Place));
      enter("Ready");
      !following.

@takes +order(Kind)[source(person)]
   <- !accept(Kind);
      +wanted.

@accepts +!accept(Kind)
   <- -order(Kind)[source(person)];
      accept(Kind);
      !keep(Kind);
      .send(person, tell, accepted(Kind)).

// In one go, so that no order is lost that comes meanwhile.
@keeps[atomic] +!keep(Kind) : queue(Waiting)
   <- .concat(Waiting, [Kind], Longer);
      -+queue(Longer).

// --- one order after the other

@next[atomic] +!following : queue([Kind | Waiting])
   <- -+queue(Waiting);
      -wanted;
      +at_work;
      !!carry_out(Kind).

// Nobody wants anything: after a while it is idle.
@waits +!following
   <- -at_work;
      ?idle_after(Limit);
      .wait(wanted, Limit, _);
      !idle.

@wanted +!idle : wanted
   <- !following.

@idle +!idle
   <- report_idle;
      .send(person, tell, idle);
      +going_home(charger);
      !!go_home.

// --- to the charger

@home +!go_home
   <- !rest;
      -going_home(charger);
      !stay.

@docks +!rest
   <- !drive("Recharge", charger);
      dock;
      enter("Ready").

@kept_from_charger -!rest
   <- enter("Ready").

// Only when tests are generated, when the person has left the flat: a run of the model has to end.
@stays +!stay : left & queue([]).

// Idle again after a while, and again.
@listens +!stay
   <- !following.

// --- what is ordered

@fridge +!carry_out(fridge)
   <- !drive("Fridge", fridge);
      !done(fridge).

@sink +!carry_out(sink)
   <- !drive("Sink", sink);
      !done(sink).

@feed +!carry_out(feed)
   <- !drive("Fridge", fridge);
      !close;
      !drive("Human", table);
      !open;
      !done(feed).

@clean +!carry_out(clean)
   <- !drive("Human", table);
      !close;
      !drive("Sink", sink);
      !open;
      !done(clean).

// No more orders: the program ends.
@ended +!carry_out(ended)
   <- enter("Off").

// Somebody is in the way for too long: it says so, and does not do it. What it holds it takes to the sink, or keeps it.
@gives_up -!carry_out(Kind)
   <- refuse(Kind);
      .send(person, tell, given_up(Kind));
      enter("Ready");
      !put_down;
      !return.

@done +!done(Kind)
   <- complete(Kind);
      .send(person, tell, completed(Kind));
      enter("Ready");
      !return.

@goes_on +!return : not queue([])
   <- !following.

@returns[atomic] +!return
   <- -at_work;
      +going_home(charger);
      !!go_home.

@puts_down +!put_down : holds
   <- !drive("Sink", sink);
      !open;
      enter("Ready").

+!put_down.

-!put_down
   <- enter("Ready").

// --- driving

// Through the living room it comes by the dog.
@drives_to_table +!drive(State, table)
   <- enter(State);
      .send(dog, tell, passing);
      !go(table).

@drives +!drive(State, Place)
   <- enter(State);
      !go(Place).

+!go(Place)
   <- .send(sensors, tell, driving(Place));
      ?travel_time(Time);
      .wait(Time);
      !arrive(Place).

// Somebody is in the way: it stands still, and waits.
@held_up +!arrive(Place) : blocked
   <- .send(person, tell, held_up);
      ?patience(Limit);
      .wait(not blocked, Limit, _);
      !resume(Place).

@detours +!arrive(Place) : obstructed
   <- ?detour_time(Time);
      .wait(Time);
      .send(sensors, untell, driving(Place)).

@arrives +!arrive(Place)
   <- .send(sensors, untell, driving(Place)).

@resumes +!resume(Place) : not blocked
   <- .send(sensors, untell, driving(Place)).

@despairs +!resume(Place)
   <- .send(sensors, untell, driving(Place));
      .fail.

// --- gripping

@closes +!close
   <- enter("Grab");
      ?grip_time(Time);
      .wait(Time);
      food(1);
      +holds.

@opens +!open
   <- enter("Drop");
      ?grip_time(Time);
      .wait(Time);
      food(0);
      -holds.
