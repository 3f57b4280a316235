"""One agent: its mental state and its reasoning cycle."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.terms import Call, Structure, Term
from pytest_hricdv.bdi.logic.substitution import Bindings, substitute
from pytest_hricdv.bdi.logic.unify import Trail

from . import communication, failure, perception, waiting
from .actions import Invocation, call_action, function_value
from .calling import hand_back, optimize_tail_recursion
from .conditions import ask
from .execution import step_of
from .intentions import Event, Frame, Intention, Message
from .mind import Mind
from .spinning import take_up


class Agent(Mind):
    """An agent in a run, interpreted: a mind, and the reasoning cycle on it."""

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
        self.left = rounds
        self.disturbed = not begun
        while True:
            if self.disturbed:
                self.disturbed = False
                if self.spin is not None:
                    take_up(self)
                if self._percept_versions.get(self.name, 0) != self._seen_percepts or self.woken:
                    self._look_around()
                if self.mailbox:
                    self.receive(self.mailbox.popleft())
                    if self.mailbox:
                        self.disturbed = True
            while self.events:
                event = self.events.popleft() if self._atomic is None else self._atomic_event()
                if event is None or self._react(event):
                    break
            if self.feedback:
                self._take_outcome()
            self.act()
            if self.left == 1 or not self.awake:
                return 1
            # Another agent has something to do, a wait is over, or the run ends.
            if (self.disturbed or self.waits or self.questions) and (
                self.spin is not None or run.something_else_can_happen()
            ):
                return 1
            self.left -= 1
            run.rounds += 1

    def _look_around(self) -> None:
        """What was waited for has come, or percepts have changed."""
        woken, self.woken = self.woken, []
        for intention in woken:
            self.resume(intention)
        # Looking may be what makes the world change.
        self.disturbed = True
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
        """The last part of a cycle: one statement.

        The next statements of the plan follow, one a cycle, while nothing can come between.
        """
        if self.intentions:
            intention = self.intentions.popleft() if self._atomic is None else self._atomic_intention()
            if intention is not None:
                frame = intention.frames[-1]
                if frame.pc >= len(frame.body):
                    self.clear(intention)
                else:
                    self.attend(intention)
                    try:
                        statement = frame.body[frame.pc]
                        while done := (statement.step or step_of(statement, frame.plan))(self, intention, frame):
                            frame.pc += 1
                            if frame.pc >= len(frame.body) or self.suspending:
                                self._go_on_after(intention, frame)
                                break
                            if (
                                self.disturbed
                                or self.left == 1
                                or self.intentions
                                or self.feedback
                                or self.events
                                or self.waits
                                or self.questions
                            ):
                                self.intentions.append(intention)
                                break
                            self.left -= 1
                            self.run.rounds += 1
                            statement = frame.body[frame.pc]
                        if done is None:
                            self.disturbed = True
                    except (EvaluationError, ArithmeticError, ValueError) as error:
                        self.disturbed = True
                        failure.fail(self, intention, getattr(error, "kind", "unknown"), str(error))
                    finally:
                        self.attend(None)
        if self.waits and self.beliefs.version != self._condition_version:
            self._condition_version = self.beliefs.version
            waiting.wake_by_conditions(self)
        if not (self.intentions or self.events or self.feedback):
            seen = self._percept_versions.get(self.name, 0) == self._seen_percepts
            self.awake = not seen or bool(self.mailbox or self.woken)

    def end_waits(self, now: int) -> None:
        """Let the intentions go on, or fail, whose wait is over, the earliest first."""
        waiting.end_waits(self, now)

    def receive(self, message: Message) -> None:
        """Act on a message."""
        communication.receive(self, message)

    def interpreted(self) -> Agent:
        """This agent: it is in the form that the interpreter runs."""
        return self

    def _react(self, event: Event) -> Frame | bool:
        """Find a plan for an event, and add it to the intention that waits for it, or to a new one.

        Returns:
            The plan; without one, whether that was all: if not, another event is selected at once.
        """
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
            intention = event.intention
            if intention is None:
                intention = self.new_intention()
            elif intention.frames and intention.frames[-1].literal.key == literal.key:
                optimize_tail_recursion(intention, event)
            frame = Frame(plan, event.sign, literal, unifier)
            intention.frames.append(frame)
            self.intentions.append(intention)
            if not plan.builtin:
                self.executed.append(plan.label)
            if plan.is_busy_wait:
                self.looked = self.run.rounds
            if plan.atomic:
                self._atomic = intention
            return frame
        intention = event.intention
        if intention is None or len(event.sign) > 1:
            return failure.no_applicable_plan(self, event)
        # The belief update that the event is about is done: it needs no plan.
        self.resume(intention)
        return True

    # --- intentions

    def go_on(self, intention: Intention) -> None:
        """The statement an intention was at is done: make it ready for the next one."""
        frames = intention.frames
        if not frames:
            self.note_end(intention)
            return
        frame = frames[-1]
        frame.pc += 1
        if frame.pc >= len(frame.body) or self.suspending:
            self._go_on_after(intention, frame)
        else:
            self.intentions.append(intention)

    def _go_on_after(self, intention: Intention, frame: Frame) -> None:
        """Make an intention ready for the statement it is at now, or end the plan if it has none left."""
        if frame.blocks:
            frame.leave_blocks()
        if frame.pc < len(frame.body):
            self.ready(intention)
        else:
            self.clear(intention)

    def clear(self, intention: Intention) -> None:
        """Take finished plans off an intention; it goes on where they were called, or ends."""
        frames, goals_matter = intention.frames, not self.run.plain
        if goals_matter:
            self.disturbed = True
        while frames and (done := frames[-1]).pc >= len(done.body):
            frames.pop()
            if goals_matter and done.sign == "+!":
                self.run.note_achieved(self.name, done.literal)
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
        if intention is not None:
            event = intention.event
            event.sign = sign
            event.literal = literal
            self.events.append(event)
        elif self.library.options[sign][literal.key]:
            self.events.append(Event(sign, literal, None))

    def has_updated(
        self, sign: str, literal: Structure, intention: Intention, frame: Frame, lost: Structure | None = None
    ) -> bool:
        """Post the event of a belief update that is an intention's statement.

        Args:
            sign: of the event.
            literal: what it is about.
            intention: whose statement it is.
            frame: the plan that it is a statement of.
            lost: the belief whose place another has taken.

        Returns:
            Whether the intention can go on at once. It can when no plan is for the event, and it would be selected and
            passed over in the next cycle, which will follow for certain.
        """
        if self.left > 1 and not (self.disturbed or self.events or self.waits or self.questions):
            options, key = self.library.options, literal.key
            noticed = options[sign][key] or (lost is not None and options["-"][key])
            if not noticed and frame.pc + 1 < len(frame.body):
                return True
        if lost is not None:
            self.post("-", lost, None)
        self.post(sign, literal, intention)
        return False

    def post_goal(self, goal: Structure) -> None:
        """Add a goal to be pursued as an intention of its own."""
        if self.waits:
            waiting.wake_by_event(self, "+!", goal)
        self.events.append(Event("+!", goal, None))

    def believe(self, belief: Structure) -> None:
        """Add a belief and post its event, if that changes anything."""
        new = self.beliefs.add(belief)
        if new is not None:
            self.run.progress += 1
            self.post("+", new, None)

    def disbelieve(self, belief: Structure) -> None:
        """Remove a belief's annotations and post its event, if that changes anything."""
        if self.beliefs.remove(belief):
            self.run.progress += 1
            self.post("-", belief, None)

    # --- evaluation

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
        self.disturbed = True
        return call_action(Invocation(self, call, bindings, trail, None))
