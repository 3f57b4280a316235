"""An agent of the model that runs in time with something else, and acts only when its act has been observed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from pytest_hricdv.bdi import BdiError, Environment, EvaluationError, Structure
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import (
    TICKS_PER_MS,
    Event,
    IntendedMeans,
    Intention,
    Message,
    Question,
    Wait,
    ticks_of,
)
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.syntax import ExternalAction, InternalActionCall, Plan, Program
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, Number
from pytest_hricdv.bdi.logic.unify import unify
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.bdi.run.system_run import SystemRun
from pytest_hricdv.conformance.agent_names import CONTENT
from pytest_hricdv.conformance.oracle import Oracle
from pytest_hricdv.conformance.terms import comparable

MS_PER_S = 1000
TICKS_PER_S = TICKS_PER_MS * MS_PER_S

MAX_CYCLES = 10_000
"""An agent that is still busy after so many reasoning cycles without time passing waits busily."""

_NOBODY = AgentTemplate("", Program("", (), (), ()), (), PlanLibrary(()), [])
"""An agent that is only there to be sent to."""


@dataclass(eq=False)
class ReadyAct:
    """Something that the agent is ready to do, and does not do until it is observed.

    Args:
        text: the act, as AgentSpeak.
        literal: its literal; None for a plan's beginning.
        acts: the numbers of the declared acts that it is.
        plan: the label of the plan that it belongs to.
        ready_s: when the agent became ready for it (s).
    """

    text: str
    literal: Structure | None
    acts: tuple[int, ...]
    plan: str
    ready_s: float
    intention: Intention = field(repr=False)


class OnlineRun(SystemRun):
    """A run whose clock is set from outside. Messages to other agents go nowhere."""

    def __init__(self) -> None:
        super().__init__(Environment(), 0, None)
        self.now_s = 0.0
        self.succeeds = True
        """Whether the external action that is executed next succeeds."""

    @property
    def ticks(self) -> int:
        """The agent's clock."""
        return math.floor(self._exact_ticks())

    def _exact_ticks(self) -> float:
        # Rounded first: a time that is a whole number of ticks has no exact binary form.
        return round(self.now_s * TICKS_PER_S, 6)

    def deadline(self, wait_ms: float) -> float:
        """The tick at which a wait that begins now is over: never before its time."""
        return math.ceil(self._exact_ticks()) + ticks_of(wait_ms)

    def end_waits(self) -> None:
        """End the waits that are over by now."""
        self._end_waits()

    def deliver(self, receiver: str, message: Message) -> None:
        """Put a message of the agent to itself into its mailbox."""
        if message.sender == "self":
            super().deliver(receiver, message)

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """An external action has been executed: whether it succeeded."""
        return self.succeeds


class FollowedAgent(Agent):
    """An agent that stops before each act that corresponds to an event; takes what an agent takes."""

    oracle: Oracle
    run: OnlineRun

    def follow(self, oracle: Oracle) -> None:
        """Prepare for following."""
        self.oracle = oracle
        self.ready_acts: list[ReadyAct] = []
        """What it is ready to do, in the order in which it became ready."""
        self._observed: Intention | None = None

    def react(self, event: Event) -> IntendedMeans | bool:
        """Select a plan, and stop before it if its beginning is an act."""
        reacted = super().react(event)
        if isinstance(reacted, IntendedMeans) and (acts := self.oracle.labels.get(reacted.plan.label)):
            self._stop_before(self.intentions.pop(), f"@{reacted.plan.label}", None, acts)
        return reacted

    def execute(self, intention: Intention) -> None:
        """Execute the next statement of an intention, unless it is an act: then stop before it."""
        if intention is self._observed:
            self._observed = None
        elif (literal := self._act_of(intention)) is not None and (acts := self._acts(literal)):
            self._stop_before(intention, str(literal), literal, acts)
            return
        super().execute(intention)

    def go_on_observed(self, act: ReadyAct, succeeded: bool = True) -> None:
        """An act that it is ready for has been observed: do it."""
        self.ready_acts.remove(act)
        if act.literal is not None:
            self._observed, self.run.succeeds = act.intention, succeeded
        self.intentions.appendleft(act.intention)
        self.awake = True

    def all_intentions(self) -> list[tuple[Intention, Event | None]]:
        """All intentions, those before an act among them."""
        return super().all_intentions() + [(act.intention, None) for act in self.ready_acts]

    def remove_intention(self, intention: Intention) -> None:
        """Remove an intention; what it was ready to do is not expected any more."""
        super().remove_intention(intention)
        self.ready_acts = [act for act in self.ready_acts if act.intention is not intention]

    def _stop_before(self, intention: Intention, text: str, literal: Structure | None, acts: tuple[int, ...]) -> None:
        labelled = [means.plan.label for means in intention.stack if means.plan.has_label]
        plan = labelled[-1] if labelled else ""
        self.ready_acts.append(ReadyAct(text, literal, acts, plan, self.run.now_s, intention))

    def _acts(self, literal: Structure) -> tuple[int, ...]:
        does = self.oracle.does
        return tuple(
            number
            for number in self.oracle.literals.get(literal.key, ())
            if (pattern := does[number].pattern) is not None and unify(pattern, literal, {}, [])
        )

    def _act_of(self, intention: Intention) -> Structure | None:
        """The message or external action that an intention is about to send or execute."""
        means = intention.stack[-1]
        if means.finished:
            return None
        statement = means.statement
        written: object = None
        if isinstance(statement, ExternalAction):
            written = statement.action
        elif isinstance(statement, InternalActionCall) and statement.call.name in CONTENT:
            written = statement.call.args[CONTENT[statement.call.name]]
        if written is None:
            return None
        try:
            literal = self.value(written, means.unifier)  # type: ignore[arg-type]
        except EvaluationError:
            return None  # executing it fails in the same way
        return comparable(literal) if isinstance(literal, Structure) else None


class Follower:
    """The agent of one run.

    Args:
        oracle: what it follows.
        limits: belief -> the duration (s) that it believes in this run.
    """

    def __init__(self, oracle: Oracle, limits: Mapping[str, float]) -> None:
        self.run = OnlineRun()
        self._ended_waits = 0
        agent = oracle.agent.agent(self.run, FollowedAgent)
        assert isinstance(agent, FollowedAgent)
        agent.follow(oracle)
        self.agent = self.run.agents[agent.name] = agent
        self.run.order = (agent,)
        for name in oracle.others:
            self.run.agents[name] = replace(_NOBODY, name=name).agent(self.run)
        for name, limit in limits.items():
            # Whole milliseconds: sums of them are exact, so that a limit is reached when it should be.
            self._set_belief(name, round(limit * MS_PER_S))
        self.settle()

    def _set_belief(self, name: str, value: float) -> None:
        beliefs = self.agent.beliefs
        for held in list(beliefs.bucket((False, name, 1)).values()):
            if isinstance(held, Structure):
                beliefs.remove(held)
        beliefs.add(Structure(name, (Number(value),), (SOURCE_SELF,)))

    @property
    def due_s(self) -> float:
        """When the agent's next wait is over (s); infinite if there is none."""
        waiting: list[Wait | Question] = [*self.agent.waits, *self.agent.questions.values()]
        deadlines = [each.deadline for each in waiting if each.deadline is not None]
        return min(deadlines, default=math.inf) / TICKS_PER_S

    def hear(self, literal: Structure, source: str, goal: bool) -> None:
        """Tell the agent something, or give it a goal, now."""
        self.run.messages += 1
        self.agent.mailbox.append(Message(source, "achieve" if goal else "tell", literal, self.run.messages))
        self.agent.awake = True
        self.settle()

    def observe(self, act: ReadyAct, succeeded: bool = True) -> None:
        """An act for which the agent is ready has been observed: it goes on."""
        self.agent.go_on_observed(act, succeeded)
        self.settle()

    def wait_until(self, time_s: float) -> None:
        """The clock has reached `time_s`, and no wait is over before it: the agent goes on if one is over by now.

        Raises:
            BdiError: as `settle`.
        """
        self._ended_waits = self._ended_waits + 1 if time_s == self.run.now_s else 0
        if self._ended_waits > MAX_CYCLES:
            raise BdiError(f"{self.agent.name} waits again and again without time passing: {self.agent.doing()}")
        self.run.now_s = time_s
        if self.run.earliest_deadline <= self.run.ticks:
            self.run.end_waits()
            self.settle()

    def settle(self) -> None:
        """Let the agent do all that it can do now.

        Raises:
            BdiError: it cannot go on, or never comes to rest.
        """
        agent = self.agent
        for _ in range(MAX_CYCLES):
            if not self.run.do_round() or (agent.busy_waiting and not agent.has_news()):
                return
        raise BdiError(f"{agent.name} does not come to rest: it has to wait with .wait, not busily: {agent.doing()}")
