"""Traced runs and their agents: the steps of a run and their causes are noted."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.agent_state import ActionTable
from pytest_hricdv.bdi.agent.intentions import Event, IntendedMeans, Intention, Message
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.errors import BdiError, Location
from pytest_hricdv.bdi.language.syntax import And, ExternalAction, Formula, Plan
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.run.environment import Environment
from pytest_hricdv.bdi.run.jitter import JitteredRun
from pytest_hricdv.bdi.run.result import Step


class TracedRun(JitteredRun):
    """A run whose steps are noted; it takes what a run with jitter takes."""

    def __init__(self, environment: Environment, seed: int, goal: tuple[str, Structure] | None, jitter: int) -> None:
        self.steps: list[Step] = []
        self.messages: dict[str, int] = {}
        """The steps that messages were sent by, by the messages' numbers."""
        self.acting: TracedAgent | None = None
        super().__init__(environment, seed, goal, jitter)

    def note(self, agent: str, kind: str, text: str, cause: Step | None = None, **details: object) -> Step:
        """Add a step; its cause says which plan did it, unless the details do."""
        plan = cause.plan if cause is not None and cause.kind == "plan" else ""
        at = self.rounds + 1 if self.acting is not None else 0
        number = len(self.steps) + 1
        fields = {"plan": plan, **details, "cause": None if cause is None else cause.number}
        step = Step(number, at, agent, kind, text, **fields)  # type: ignore[arg-type]
        self.steps.append(step)
        return step

    @property
    def _cause(self) -> Step | None:
        return None if self.acting is None else self.acting.cause

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """Note an action and execute it."""
        self.note(agent, "action", str(action), self._cause)
        return super().act(agent, action, plan, statement)

    def print(self, agent: str, text: str) -> None:
        """Note a print."""
        self.note(agent, "print", text, self._cause)
        super().print(agent, text)

    def warn(self, text: str) -> None:
        """Note a warning."""
        if self.acting is not None:
            self.note(self.acting.name, "warning", text, self._cause)
        super().warn(text)

    def deliver(self, receiver: str, message: Message) -> None:
        """Note a message when it is sent."""
        if message.number not in self.messages:
            sender = receiver if message.sender == "self" else message.sender
            step = self.note(sender, "message", f"{message.force} {message.content} to {receiver}", self._cause)
            self.messages[message.number] = step.number
        super().deliver(receiver, message)


class TracedAgent(Agent):
    """An agent in a traced run; it takes what an agent takes."""

    def __init__(
        self,
        name: str,
        run: TracedRun,
        actions: ActionTable,
        beliefs: BeliefBase,
        library: PlanLibrary,
        events: list[tuple[str, Structure]],
    ) -> None:
        super().__init__(name, run, actions, beliefs, library, events)
        self.notes = run
        self.cause: Step | None = None
        """The cause of what happens now: what is being reacted to, or the selection of the plan being executed."""
        # Events, intended means and intentions are known by their identity while they are in use.
        self._events = {id(event): self._note_event(event.sign, event.literal, None) for event in self.events}
        self._means: dict[int, Step] = {}
        self._intentions: dict[int, Step] = {}

    def _note_event(self, sign: str, literal: Structure, cause: Step | None) -> Step:
        kind = "failure" if sign in ("-!", "-?") else "goal" if len(sign) == 2 else "belief"
        if kind == "belief" and SOURCE_PERCEPT in literal.annots:
            kind = "percept"
        return self.notes.note(self.name, kind, f"{sign}{literal}", cause)

    def cycle(self) -> None:
        """Do a reasoning cycle; all steps noted meanwhile are this agent's."""
        self.notes.acting, self.cause = self, None
        super().cycle()

    def receive(self, message: Message) -> None:
        """Process a message; its effects are caused by its being sent."""
        self.cause = self.notes.steps[self.notes.messages[message.number] - 1]
        super().receive(message)
        self.cause = None

    def post(self, sign: str, literal: Structure, intention: Intention | None) -> None:
        """Note an event and add it."""
        cause = self.cause
        if cause is None and intention is not None:
            cause = self._intentions.get(id(intention))
        step = self._note_event(sign, literal, cause)
        before = len(self.events)
        super().post(sign, literal, intention)
        if len(self.events) > before:
            self._events[id(self.events[-1])] = step

    def post_goal(self, goal: Structure) -> None:
        """Note a goal and add it."""
        step = self._note_event("+!", goal, self.cause)
        super().post_goal(goal)
        self._events[id(self.events[-1])] = step

    def react(self, event: Event) -> IntendedMeans | bool:
        """Note the choice of a plan."""
        self.cause = self._events.pop(id(event), None)
        reacted = super().react(event)
        if isinstance(reacted, IntendedMeans):
            step = self._note_plan(reacted.plan, reacted.unifier)
            self._means[id(reacted)] = self._intentions[id(self.intentions[-1])] = step
        self.cause = None
        return reacted

    def execute(self, intention: Intention) -> None:
        """Execute a statement; what it causes is caused by the choice of its plan."""
        self.cause = self._means.get(id(intention.top))
        super().execute(intention)
        self.cause = None

    def _note_plan(self, plan: Plan, bindings: Bindings) -> Step:
        text = f"@{plan.label} {plan.trigger}" if plan.has_label else str(plan.trigger)
        beliefs = () if plan.context is None else self._found(plan.context, bindings)
        return self.notes.note(
            self.name, "plan", text, self.cause, plan=plan.label, place=_place(plan.location), beliefs=beliefs
        )

    def _found(self, context: Formula, bindings: Bindings) -> tuple[str, ...]:
        """The beliefs that made a context true, as far as they are written in it as literals."""
        found: list[str] = []
        for part in context.parts if isinstance(context, And) else (context,):
            try:
                value = self.value(part, bindings) if isinstance(part, Structure) else None
            except BdiError:
                continue
            if isinstance(value, Structure) and value.key != (False, "true", 0):
                held = self.beliefs.bucket(value.key).get(value.args)
                found.append(str(held if isinstance(held, Structure) else value))
        return tuple(found)


def _place(location: Location) -> str:
    return f"{Path(location.file).name}:{location.line}"
