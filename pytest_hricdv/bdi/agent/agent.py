"""`Agent`: an agent of a run, with its reasoning cycle.

Each round, the run calls `Agent.cycle`: perceive, read a message, select a plan for an event, execute a statement.
"""

from __future__ import annotations

import sys

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.failures import end_deadlines, fail, no_applicable_plan
from pytest_hricdv.bdi.agent.intentions import (
    ActionTable,
    Event,
    IntendedMeans,
    Intention,
    PendingQuestion,
    RunServices,
    SpeechAct,
)
from pytest_hricdv.bdi.agent.messages import receive
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.agent.statements import EXECUTE
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import LimitError
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, ListTerm, Structure
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.conditions import ask
from pytest_hricdv.bdi.logic.inference import first
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import unify


class Agent(AgentState):
    """An agent in a run; its arguments are those of `AgentState`."""

    def __init__(
        self,
        name: str,
        run: RunServices,
        actions: ActionTable,
        beliefs: BeliefBase,
        library: PlanLibrary,
        events: list[tuple[str, Structure]],
    ) -> None:
        super().__init__(name, run, actions, beliefs, library, events)
        self.busy_waiting = False
        """Whether its last cycle only selected a plan that pursues its own goal again, as ``+!w : not x <- !w``."""
        self.perceived: tuple[Structure, ...] = ()
        """The percepts when it last perceived."""
        self.seen_percepts = 0
        """The version of its percepts when it last perceived."""
        self._percepts = run.percepts_of(name)
        self._checked_version = -1
        """The version of the beliefs when waits for conditions were last checked."""
        self._busy_wait_tick = -1
        """The last tick in which it selected a plan that pursues its own goal again."""
        self.awake = self.has_work()

    def cycle(self) -> None:
        """Do a reasoning cycle: perceive, read a message, react to an event, take an action's outcome, do a statement.

        Raises:
            BdiError: the agent cannot continue.
        """
        # In Jason's order: sense, read a message, deliberate on an event, act.
        self.busy_waiting = False
        if self.woken:
            woken, self.woken = self.woken, []
            for intention in woken:
                self.resume(intention)
        if self._percepts.version != self.seen_percepts:
            self.perceive()
        if self.mailbox:
            self.receive(self.mailbox.popleft())
        if self.atomic is None:
            while self.events and not self.react(self.events.popleft()):
                pass
        else:
            self._react_atomically()
        if self.feedback:
            self._take_outcome()
        if self.intentions:
            ready = self.intentions.popleft() if self.atomic is None else self._atomic_intention()
            if ready is not None:
                self.execute(ready)
        if self.waits and self.beliefs.version != self._checked_version:
            self._checked_version = self.beliefs.version
            self._wake_by_conditions()
        self.awake = True if self.intentions or self.events else self.has_news()

    def has_work(self) -> bool:
        """Whether a reasoning cycle would do anything."""
        return bool(self.events) or self.has_news()

    def has_news(self) -> bool:
        """Whether a cycle would do anything besides reacting to an event."""
        return bool(
            self.intentions
            or self.mailbox
            or self.feedback
            or self.woken
            or self.seen_percepts != self._percepts.version
        )

    def may_change(self) -> bool:
        """Whether it may do anything but wait busily, even if nothing more comes to it."""
        if self.waits or self.questions or self.deadlines:
            return True
        return self.has_news() if self.busy_waiting else self.awake

    def note_restored(self) -> None:
        """Note that its state was set after it perceived the environment's percepts."""
        self.seen_percepts = self._percepts.version
        self._checked_version = self.beliefs.version
        self.awake = self.has_work()

    def warn_of_standstill(self) -> None:
        """At the end of a run, warn if an atomic plan still waits, and keeps the agent from everything else."""
        atomic, others = self.atomic, len(self.events) + len(self.intentions)
        if atomic is None or not atomic.stack or atomic in self.intentions or not others:
            return
        plan = atomic.top.plan
        place = plan.location if atomic.top.is_finished else atomic.top.statement.location
        self.run.warn(
            f"{self.name}: {place}: the run ended while the atomic intention waited here, in plan @{plan.label}; until "
            f"it goes on, the agent does nothing else, and {others} of its events and intentions are left"
        )

    def receive(self, message: SpeechAct) -> None:
        """Process a message."""
        receive(self, message)

    # --- waits

    def _wake_by_conditions(self) -> None:
        """Resume the intentions whose condition holds now, in the next cycle."""
        for wait in list(self.waits):
            if wait.condition is None:
                continue
            means = wait.intention.top
            self.current = wait.intention
            solution = first(self, wait.condition, means.unifier)
            self.current = None
            if solution is not None:
                means.unifier = solution
                self.end_wait(wait)
                self.woken.append(wait.intention)

    def end_waits(self, now: int) -> None:
        """Resume or fail the intentions whose wait is over at a tick of the virtual clock, the earliest first."""
        if self.deadlines:
            end_deadlines(self, now)
        over = [wait for wait in self.waits if wait.deadline is not None and wait.deadline <= now]
        over.sort(key=lambda wait: wait.deadline or 0)
        for wait in over:
            waits_for_something = wait.trigger is not None or wait.condition is not None
            if waits_for_something and wait.elapsed is None:
                self.waits.remove(wait)
                fail(self, wait.intention, "wait_timeout", "timeout in .wait")
            else:
                self.end_wait(wait)
                self.resume(wait.intention)
        for name, question in list(self.questions.items()):
            # A question to several agents has several names: all are removed with the first.
            if name in self.questions and question.deadline is not None and question.deadline <= now:
                self._end_question(question)

    def _end_question(self, question: PendingQuestion) -> None:
        """Resume an intention whose question has not been answered in time."""
        self.questions = {name: other for name, other in self.questions.items() if other is not question}
        answer = Structure("timeout") if question.asked is None else ListTerm(tuple(question.answers))
        unify(question.answer, answer, question.intention.top.unifier, [])
        self.resume(question.intention)

    # --- perception

    def perceive(self) -> None:
        """Update the beliefs from the percepts, which have changed.

        Otherwise it is not called: a percept that the agent itself has deleted stays deleted until then.
        """
        self.seen_percepts = self._percepts.version
        self.run.progress += 1
        percepts = tuple(self._percepts.literals())
        before, self.perceived = self.perceived, percepts
        believed = [belief.without_annotations() for belief in self.beliefs.with_annotation(SOURCE_PERCEPT)]
        if believed:
            self._forget(believed, before, percepts)
        for percept in percepts:
            self.believe(percept)

    def _forget(
        self, believed: list[Structure], before: tuple[Structure, ...], percepts: tuple[Structure, ...]
    ) -> None:
        """Delete beliefs that are not perceived any more.

        In the order in which they were listed before; last what the agent itself has added as a percept.
        """
        still_perceived = {percept.without_annotations() for percept in percepts}
        place_before = {percept.without_annotations(): place for place, percept in enumerate(before)}
        for plain in sorted(believed, key=lambda plain: place_before.get(plain, len(place_before))):
            if plain not in still_perceived:
                self.disbelieve(Structure(plain.functor, plain.args, (SOURCE_PERCEPT,), plain.negated))

    # --- events

    def _react_atomically(self) -> None:
        """React to the event of the intention that must not be interleaved with others.

        To none if it is ready, or waits for an answer, an action or time: nothing may come between.
        """
        for event in self.events:
            if event[2] is self.atomic:
                self.events.remove(event)
                self.react(event)
                break

    def react(self, event: Event) -> IntendedMeans | bool:
        """Select a plan for an event, and add it to the intention that waits for the event, or to a new one.

        Returns:
            The plan; without one, whether the event was all for this cycle: if not, another one is selected at once.
        """
        sign, literal, intention = event
        for plan, match, condition in self.library.options[sign][literal.key]:
            self.considered = plan
            unifier: Bindings | None = {} if match is None else match(literal)
            if unifier is None:
                continue
            if condition is not None:
                try:
                    applicable = condition(self, unifier)
                    if applicable is None:
                        applicable = ask(self, plan.context, unifier)  # type: ignore[arg-type]
                except (EvaluationError, ArithmeticError, ValueError) as error:
                    # The context counts as false: a mistake in one does not keep the other plans from being tried.
                    self.run.warn(f"{self.name}: context of plan @{plan.label} ({plan.location}): {error}")
                    continue
                if not applicable:
                    continue
            return self._intend(IntendedMeans(plan, sign, literal, unifier), intention)
        if intention is None or len(sign) > 1:
            return no_applicable_plan(self, event)
        # The belief update that the event is about is done: it needs no plan.
        self.resume(intention)
        return True

    def _intend(self, means: IntendedMeans, intention: Intention | None) -> IntendedMeans:
        if intention is None:
            intention = self.new_intention()
        elif intention.stack and intention.stack[-1].literal.key is means.literal.key:  # equal keys are one object
            intention.optimize_tail_recursion(means.sign)
        intention.stack.append(means)
        self.intentions.append(intention)
        plan = means.plan
        if not plan.builtin:
            self.executed.append(plan.label)
        if plan.is_busy_wait:
            self._busy_wait_tick = self.run.ticks
        if plan.atomic:
            self.atomic = intention
        return means

    # --- intentions

    def _take_outcome(self) -> None:
        """Resume or fail the intention whose action the environment has executed."""
        intention, success = self.feedback.popleft()
        if success:
            self.go_on(intention)
        else:
            fail(self, intention, "action_failed", "the action failed in the environment")

    def execute(self, intention: Intention) -> None:
        """Execute the next statement of an intention, or end its plan if it has none left."""
        means = intention.stack[-1]
        body, pc = means.body, means.pc
        if pc >= len(body):
            if intention.branch_of is not None and len(intention.stack) == intention.branch_of.depth:
                self.join(intention, intention.branch_of)
            else:
                self.end_plans(intention)
            return
        self.current = intention
        try:
            statement = body[pc]
            EXECUTE[type(statement)](self, intention, means, statement)
            if means.plan.is_busy_wait and self._only_waits_busily(means):
                self.busy_waiting = self.run.busy_waiting = True
        except (EvaluationError, ArithmeticError, ValueError) as error:
            fail(self, intention, getattr(error, "kind", "unknown"), str(error))
        # Keep it after an error that ends the run: the message says what the agent is doing.
        self.current = None

    def _atomic_intention(self) -> Intention | None:
        """The intention that must not be interleaved with others.

        None if it waits for its own event or for time to pass: nothing may come between.
        """
        atomic = self.atomic
        if atomic is None or atomic not in self.intentions:
            return None
        self.intentions.remove(atomic)
        return atomic

    def _only_waits_busily(self, means: IntendedMeans) -> bool:
        """Whether the goal that a plan has posted again is all there is to do, until something comes from outside."""
        if len(self.events) > 1 or self.suspending or self.has_news():
            return False
        # The awaited event may have come after the plan was selected.
        selected_now = self._busy_wait_tick == self.run.ticks
        # A rule may draw a random number or read the clock: then waiting may end without anything from outside.
        return selected_now and not self.beliefs.open and self.library.depends_on_beliefs_only(means.literal.key)


def limit_text(error: Exception, agent: Agent) -> str:
    """The action of an agent that reached a limit, with its rule and its plan."""
    if isinstance(error, LimitError):
        return f"{error.rule}{agent.activity()}: {error}"
    if isinstance(error, MemoryError):
        return f"{agent.activity()}: takes more memory than there is"
    return f"terms nested too deeply for Python's stack of {sys.getrecursionlimit()} frames: {agent.activity()}"


def count_waiting(agent: Agent) -> int:
    return (
        len(agent.mailbox)
        + len(agent.events)
        + len(agent.intentions)
        + len(agent.waits)
        + len(agent.suspended)
        + len(agent.held_events)
    )
