"""One agent: its mental state and its reasoning cycle."""

from __future__ import annotations

from collections.abc import Iterator

from . import communication, failure, perception, waiting
from .actions import Invocation, call_action, function_value
from .calling import hand_back, optimize_tail_recursion
from .conditions import ask
from .errors import BdiError, EvaluationError
from .execution import step_of
from .formulas import Formula
from .inference import MAX_NESTED_QUERIES
from .intentions import Event, Frame, Intention, Message
from .mind import Mind
from .spinning import take_up
from .substitution import Bindings, substitute
from .syntax import Plan
from .terms import Call, Structure, Term, Variable
from .unify import Trail


class Agent(Mind):
    """An agent in a run, interpreted: a mind, and the reasoning cycle on it."""

    takes_letters = False

    # --- the reasoning cycle

    def cycle(self) -> None:
        """Perceive, read one message, react to one event, take one action's outcome, do one statement."""
        self.work(1)

    def reason(self) -> None:
        """The part of a cycle after perceiving and reading."""
        self.work(1, begun=True)

    def work(self, rounds: int, begun: bool = False) -> int:
        """Do cycles while every other agent is idle, as long as nothing else can happen.

        All but the last are entered in the run's books here: what an agent does may depend on the time.

        Args:
            rounds: how many at most.
            begun: whether it has perceived and read already in the first cycle.

        Returns:
            The number of cycles done that are not yet in the run's books.
        """
        run = self.run
        while True:
            if not begun:
                if self.spin is not None:
                    take_up(self)
                if self._percept_versions.get(self.name, 0) != self._seen_percepts or self.woken:
                    self._look_around()
                if self.mailbox:
                    self.receive(self.mailbox.popleft())
            while self.events:
                event = self.events.popleft() if self._atomic is None else self._atomic_event()
                if event is None or self._react(event):
                    break
            if self.feedback:
                self._take_outcome()
            self.act()
            # Another agent has something to do, a wait is over, or the run ends.
            if rounds == 1 or not self.awake or self.spin is not None or run.something_else_can_happen():
                return 1
            begun = False
            rounds -= 1
            run.rounds += 1

    def _look_around(self) -> None:
        """What was waited for has come, or percepts have changed."""
        woken, self.woken = self.woken, []
        for intention in woken:
            self.resume(intention)
        version = self._percept_versions.get(self.name, 0)
        if version != self._seen_percepts:
            self._seen_percepts = version
            perception.perceive(self)

    def _take_outcome(self) -> None:
        """Let the intention go on, or fail, whose action the environment has executed."""
        intention, success = self.feedback.popleft()
        if success:
            self.go_on(intention)
        else:
            failure.fail(self, intention, "action_failed", "the action failed in the environment")

    def act(self) -> None:
        """The last part of a cycle: one statement."""
        if self.intentions:
            intention = self.intentions.popleft() if self._atomic is None else self._atomic_intention()
            if intention is not None:
                frame = intention.frames[-1]
                body, pc = frame.body, frame.pc
                if pc >= len(body):
                    self.clear(intention)
                else:
                    self.current = intention
                    try:
                        (body[pc].step or step_of(body[pc], frame.plan))(self, intention, frame)
                    except (EvaluationError, ArithmeticError, ValueError) as error:
                        failure.fail(self, intention, getattr(error, "kind", "unknown"), str(error))
                    finally:
                        self.current = None
        if self.waits and self.beliefs.version != self._condition_version:
            self._condition_version = self.beliefs.version
            waiting.wake_by_conditions(self)
        if not self.intentions and not self.events:
            self.awake = self.has_work()

    def end_waits(self, now: int) -> None:
        """Let the intentions go on, or fail, whose wait is over at a tick of the virtual clock."""
        waiting.end_waits(self, now)

    def interpreted(self) -> Agent:
        """This agent: it is in the form that the interpreter runs."""
        return self

    def receive(self, message: Message) -> None:
        """Act on one message."""
        communication.receive(self, message)

    def _atomic_event(self) -> Event | None:
        """The event of the intention that must not be interleaved with others.

        None if it is ready, or waits for an answer, an action or time: nothing may come between.
        """
        for event in self.events:
            if event.intention is self._atomic:
                self.events.remove(event)
                return event
        return None

    def _react(self, event: Event) -> bool:
        """Find a plan for an event; False for a belief event without one: another event is selected at once."""
        literal, beliefs = event.literal, self.beliefs
        held = beliefs.held
        for plan, needed, match, condition in self.library.options[event.sign][literal.key]:
            if not needed <= held and not beliefs.open:
                continue
            self._considered = plan
            unifier: Bindings | None = {} if match is None else match(literal)
            if unifier is None:
                continue
            if condition is not None:
                try:
                    applicable = condition(self, unifier)
                    if applicable is None:
                        applicable = ask(self, plan.context, unifier)  # type: ignore[arg-type]
                except (EvaluationError, ArithmeticError, ValueError) as error:
                    self.run.warn(f"{self.name}: context of plan @{plan.label} ({plan.location}): {error}")
                    continue
                if not applicable:
                    continue
            self._intend(event, plan, unifier)
            return True
        intention = event.intention
        if intention is None or len(event.sign) > 1:
            return failure.no_applicable_plan(self, event)
        # The belief update that the event is about is done: it needs no plan.
        self.resume(intention)
        return True

    def _intend(self, event: Event, plan: Plan, unifier: Bindings) -> None:
        """Add a plan for an event to the intention that waits for it, or to a new one."""
        if not plan.builtin:
            self.executed.append(plan.label)
        intention = event.intention
        if intention is None:
            intention = self.new_intention()
        elif intention.frames and intention.frames[-1].literal.key == event.literal.key:
            optimize_tail_recursion(intention, event)
        intention.frames.append(Frame(plan, event.sign, event.literal, unifier))
        if plan.atomic:
            self._atomic = intention
        self.intentions.append(intention)

    def _atomic_intention(self) -> Intention | None:
        """The intention that must not be interleaved with others.

        None if it waits for its own event or for time to pass: nothing may come between.
        """
        atomic = self._atomic
        if atomic is None or atomic not in self.intentions:
            return None
        self.intentions.remove(atomic)
        return atomic

    def only_spins(self, goal: Structure) -> bool:
        """Whether the event of a goal is all that it has, and nothing but what comes from outside changes that."""
        if len(self.events) > 1 or self.suspending or self.has_news():
            return False
        return not self.beliefs.open and self.library.is_steady(goal.key)

    # --- intentions

    def go_on(self, intention: Intention) -> None:
        """The statement an intention was at is done: make it ready for the next one."""
        frames = intention.frames
        if not frames:
            self.note_end(intention)
            return
        frame = frames[-1]
        frame.pc += 1
        if frame.pc >= len(frame.body):
            frame.leave_blocks()
            if frame.pc >= len(frame.body):
                self.clear(intention)
                return
        if self.suspending:
            self.ready(intention)
        else:
            self.intentions.append(intention)

    def clear(self, intention: Intention) -> None:
        """Take finished plans off an intention; it goes on where they were called, or ends."""
        frames, run = intention.frames, self.run
        goals_matter = not run.plain
        while frames and (done := frames[-1]).pc >= len(done.body):
            frames.pop()
            if goals_matter and done.sign == "+!":
                run.note_achieved(self.name, done.literal)
            if frames:
                caller = frames[-1]
                if not done.literal.ground:
                    hand_back(self, done, caller)
                caller.pc += 1
                if caller.blocks:
                    caller.leave_blocks()
        if self._atomic is intention and not intention.atomic:
            self._atomic = None
        if frames:
            self.ready(intention)

    # --- events

    def post(self, sign: str, literal: Structure, intention: Intention | None) -> None:
        """Add an event; an external one that no plan is for is only shown to those who wait for it."""
        if self.waits:
            waiting.wake_by_event(self, sign, literal)
        if intention is not None or self.library.options[sign][literal.key]:
            self.events.append(Event(sign, literal, intention))

    def post_goal(self, goal: Structure) -> None:
        """Add a goal to be pursued as an intention of its own."""
        if self.waits:
            waiting.wake_by_event(self, "+!", goal)
        self.events.append(Event("+!", goal, None))

    def believe(self, belief: Structure, intention: Intention | None = None) -> bool:
        """Add a belief and post its event; False if that changes nothing."""
        new = self.beliefs.add(belief)
        if new is None:
            return False
        self.run.progress += 1
        self.post("+", new, intention)
        return True

    def disbelieve(self, belief: Structure, intention: Intention | None = None) -> bool:
        """Remove a belief's annotations and post its event; False if that changes nothing."""
        if not self.beliefs.remove(belief):
            return False
        self.run.progress += 1
        self.post("-", belief, intention)
        return True

    # --- evaluation

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        return self.run.fresh()

    def value(self, term: Term, bindings: Bindings) -> Term:
        """The term with variables replaced and expressions evaluated."""
        if type(term) is Structure and term.ground:
            return term
        return substitute(term, bindings, self.function)

    def function(self, call: Call, bindings: Bindings) -> Term:
        """The value of a function in an expression."""
        return function_value(self, call, bindings)

    def call(self, call: Call, bindings: Bindings, trail: Trail) -> bool | Iterator[object]:
        """The outcome of an internal action as a condition."""
        return call_action(Invocation(self, call, bindings, trail, None))

    def enter_query(self, formula: Formula) -> None:
        """Count a query within queries.

        Raises:
            BdiError: too many of them: rules that call each other through ``not`` for ever.
        """
        self._queries += 1
        if self._queries > MAX_NESTED_QUERIES:
            raise BdiError(f"{self.name}: runaway recursion while looking for {formula}: {self.doing()}")

    def leave_query(self) -> None:
        """The end of a query."""
        self._queries -= 1

    def doing(self) -> str:
        """Where the agent is, for error messages."""
        if self.current is not None and self.current.frames:
            frame = self.current.frames[-1]
            place = frame.plan.location if frame.finished else frame.statement.location
            return f"in plan @{frame.plan.label} ({place})"
        if self._considered is not None:
            return f"in the context of plan @{self._considered.label} ({self._considered.location})"
        return "before any plan"
