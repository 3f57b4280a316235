"""Traces of runs (`hricdv model trace`): which event led to which plan of which agent, and to which action.

A `TracedRun` records a :class:`Step` for each percept or belief gained or lost, goal, selected plan, action, message
and print. Each step names the step that caused it, across agents, so an action can be traced back to the belief behind
it. `MultiAgentSystem.run(trace=True)` makes such a run and returns its `Trace`; plain runs have no overhead.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import ActionTable, Event, IntendedMeans, Intention, SpeechAct
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.errors import BdiError, Location
from pytest_hricdv.bdi.language.syntax import And, ExternalAction, Formula, Plan
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.run.jitter import JitteredRun
from pytest_hricdv.bdi.run.system_run import SystemRun


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a traced run.

    Args:
        number: its index in the trace, from 1.
        round: the round, from 1; 0 before the first.
        agent: the agent in which it happened.
        kind: "percept", "belief", "goal" or "failure" (events), "plan", "action", "message", "print", "warning".
        text: the step in AgentSpeak, or the printed text; for a plan its label and trigger.
        cause: the number of the step that caused it; None if the cause is outside of the agents.
        plan: the label of the selected plan, or of the plan that made the step; else empty.
        place: for a plan, its location in the sources, as ``file:line``.
        beliefs: for a plan, the beliefs that made its context true, with their sources.
    """

    number: int
    round: int
    agent: str
    kind: str
    text: str
    cause: int | None = None
    plan: str = ""
    place: str = ""
    beliefs: tuple[str, ...] = ()

    def __str__(self) -> str:
        text = f"{self.kind} {self.text}"
        if self.beliefs:
            text += f" because of {', '.join(self.beliefs)}"
        if self.place:
            text += f" ({self.place})"
        return text


@dataclass(frozen=True, slots=True)
class Trace:
    """The steps of a run in the order in which they happened."""

    steps: tuple[Step, ...]

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    def __len__(self) -> int:
        return len(self.steps)

    def of(self, agent: str, kind: str | None = None) -> tuple[Step, ...]:
        """The steps of an agent, of all kinds or of one."""
        return tuple(step for step in self.steps if step.agent == agent and kind in (None, step.kind))

    def why(self, step: Step) -> tuple[Step, ...]:
        """The chain of causes of a step, from the first to the step itself."""
        chain = [step]
        while chain[-1].cause is not None:
            chain.append(self.steps[chain[-1].cause - 1])
        return tuple(reversed(chain))

    def text(self, agent: str | None = None) -> str:
        """The trace, or one agent's part of it, as lines of number, round, agent, step, and cause."""
        shown = [step for step in self.steps if agent in (None, step.agent)]
        width = max((len(step.agent) for step in shown), default=0)
        return "\n".join(_line(step, width) for step in shown)

    def chain_text(self, step: Step) -> str:
        """The chain of causes as text, each step indented more than its cause."""
        chain = enumerate(self.why(step))
        return "\n".join(f"{'  ' * depth}[round {link.round}] {link.agent}: {link}" for depth, link in chain)

    def to_json(self) -> str:
        """The steps as a JSON list of objects."""
        return json.dumps([asdict(step) for step in self.steps], ensure_ascii=False)


def _line(step: Step, width: int) -> str:
    cause = f"  <- {step.cause}" if step.cause is not None else ""
    return f"{step.number:>4}  round {step.round:<4} {step.agent:<{width}}  {step}{cause}"


class StepRecorder(SystemRun):
    """A mixin that records the steps of any kind of run; it takes the arguments of that kind."""

    def __init__(self, *arguments: Any) -> None:
        self.steps: list[Step] = []
        self.sending_steps: dict[int, int] = {}
        """Number of a message -> number of the step that sent it."""
        self.active_agent: TracedAgent | None = None
        super().__init__(*arguments)

    def record(self, agent: str, kind: str, text: str, cause: Step | None = None, **details: object) -> Step:
        """Record a step. Its `plan` is that of the cause, unless the details have one."""
        plan = cause.plan if cause is not None and cause.kind == "plan" else ""
        at = self.rounds + 1 if self.active_agent is not None else 0
        number = len(self.steps) + 1
        fields = {"plan": plan, **details, "cause": None if cause is None else cause.number}
        step = Step(number, at, agent, kind, text, **fields)  # type: ignore[arg-type]
        self.steps.append(step)
        return step

    @property
    def _cause(self) -> Step | None:
        return None if self.active_agent is None else self.active_agent.cause

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """Record an action and execute it."""
        self.record(agent, "action", str(action), self._cause)
        return super().act(agent, action, plan, statement)

    def print(self, agent: str, text: str) -> None:
        """Record a print."""
        self.record(agent, "print", text, self._cause)
        super().print(agent, text)

    def warn(self, text: str) -> None:
        """Record a warning."""
        if self.active_agent is not None:
            self.record(self.active_agent.name, "warning", text, self._cause)
        super().warn(text)

    def deliver(self, receiver: str, message: SpeechAct) -> None:
        """Record a message when it is sent, once for all its receivers."""
        if message.number not in self.sending_steps:
            sender = receiver if message.sender == "self" else message.sender
            step = self.record(sender, "message", f"{message.force} {message.content} to {receiver}", self._cause)
            self.sending_steps[message.number] = step.number
        super().deliver(receiver, message)


class TracedRun(StepRecorder, JitteredRun):
    """A traced run; its arguments are those of `JitteredRun`."""


class TracedAgent(Agent):
    """An agent of a traced run; its arguments are those of `Agent`."""

    def __init__(
        self,
        name: str,
        run: StepRecorder,
        actions: ActionTable,
        beliefs: BeliefBase,
        library: PlanLibrary,
        events: list[tuple[str, Structure]],
    ) -> None:
        super().__init__(name, run, actions, beliefs, library, events)
        self.recorder = run
        self.cause: Step | None = None
        """The cause of the next steps: the event being handled, or the selection of the plan being executed."""
        # Keys are the ids of events, intended means and intentions, which exist as long as they are in use.
        self._events = {id(event): self._record_event(event[0], event[1], None) for event in self.events}
        self._means: dict[int, Step] = {}
        self._intentions: dict[int, Step] = {}

    def _record_event(self, sign: str, literal: Structure, cause: Step | None) -> Step:
        kind = "failure" if sign in ("-!", "-?") else "goal" if len(sign) == 2 else "belief"
        if kind == "belief" and SOURCE_PERCEPT in literal.annots:
            kind = "percept"
        return self.recorder.record(self.name, kind, f"{sign}{literal}", cause)

    def cycle(self) -> None:
        """Do a reasoning cycle, whose steps are this agent's."""
        self.recorder.active_agent, self.cause = self, None
        super().cycle()

    def receive(self, message: SpeechAct) -> None:
        """Process a message; the step that sent it is the cause of its effects."""
        self.cause = self.recorder.steps[self.recorder.sending_steps[message.number] - 1]
        super().receive(message)
        self.cause = None

    def post(self, sign: str, literal: Structure, intention: Intention | None) -> None:
        """Record an event and add it."""
        cause = self.cause
        if cause is None and intention is not None:
            cause = self._intentions.get(id(intention))
        step = self._record_event(sign, literal, cause)
        before = len(self.events)
        super().post(sign, literal, intention)
        if len(self.events) > before:  # an event that no plan is relevant for is not added
            self._events[id(self.events[-1])] = step

    def post_goal(self, goal: Structure) -> None:
        """Record a goal and add it."""
        step = self._record_event("+!", goal, self.cause)
        super().post_goal(goal)
        self._events[id(self.events[-1])] = step

    def note_goal(self, goal: Structure, state: str) -> None:
        """Record the new state of a goal, if a plan handles it."""
        before = len(self.events)
        super().note_goal(goal, state)
        if len(self.events) > before:
            sign, literal, _ = self.events[0]
            self._events[id(self.events[0])] = self._record_event(sign, literal, self.cause)

    def react(self, event: Event) -> IntendedMeans | bool:
        """Record the selection of a plan."""
        self.cause = self._events.pop(id(event), None)
        reacted = super().react(event)
        if isinstance(reacted, IntendedMeans):
            step = self._record_plan(reacted.plan, reacted.unifier)
            self._means[id(reacted)] = self._intentions[id(self.intentions[-1])] = step
        self.cause = None
        return reacted

    def execute(self, intention: Intention) -> None:
        """Execute a statement; the selection of its plan is the cause of its effects."""
        self.cause = self._means.get(id(intention.top))
        super().execute(intention)
        self.cause = None

    def _record_plan(self, plan: Plan, bindings: Bindings) -> Step:
        text = f"@{plan.label} {plan.trigger}" if plan.has_label else str(plan.trigger)
        beliefs = () if plan.context is None else self._context_beliefs(plan.context, bindings)
        return self.recorder.record(
            self.name, "plan", text, self.cause, plan=plan.label, place=place_of_plan(plan), beliefs=beliefs
        )

    def _context_beliefs(self, context: Formula, bindings: Bindings) -> tuple[str, ...]:
        """The beliefs that made a context true; only those that the context names as literals."""
        beliefs: list[str] = []
        for part in context.parts if isinstance(context, And) else (context,):
            try:
                value = self.value(part, bindings) if isinstance(part, Structure) else None
            except BdiError:
                continue
            if isinstance(value, Structure) and value.key != (False, "true", 0):
                held = self.beliefs.bucket(value.key).get(value.args)
                beliefs.append(str(held if isinstance(held, Structure) else value))
        return tuple(beliefs)


def place_of_plan(plan: Plan) -> str:
    """The location of a plan in the sources, as `Step.place`."""
    return _place(plan.location)


def _place(location: Location) -> str:
    return f"{Path(location.file).name}:{location.line}"
