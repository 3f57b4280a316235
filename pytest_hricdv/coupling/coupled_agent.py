"""`CoupledAgent`: an agent that pauses before each act, and resumes when the simulated run reports that it is done.

Interactive agents (`OnlineAgent`, `OnlinePeople`) and the oracle's agent (`FollowedAgent`) are coupled. A `CoupledRun`
executes them; the simulation sets its clock. A `ReadyAct` is an act before which an agent has paused.
"""

from __future__ import annotations

import heapq
import math
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Collection, Iterable, Iterator, Set
from dataclasses import dataclass, field, replace
from itertools import count
from operator import attrgetter

from pytest_hricdv.bdi import BdiError, Environment, EvaluationError, Structure
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import (
    TICKS_PER_MS,
    Event,
    Intention,
    PendingQuestion,
    PendingWait,
    SpeechAct,
    ticks_of,
)
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.limits import count_work
from pytest_hricdv.bdi.language.syntax import ExternalAction, InternalActionCall, Plan, Program
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.bdi.run.system_run import SystemRun
from pytest_hricdv.coupling.agent_names import CONTENT, comparable

MS_PER_S = 1000
TICKS_PER_S = TICKS_PER_MS * MS_PER_S

MAX_CYCLES = 10_000
"""Maximum number of reasoning cycles of an agent at one instant; with more, it is in an endless loop. Chosen: a
thousand times as many as any agent in tests/hri takes, which is 10."""

_NOBODY = AgentTemplate("", Program("", (), (), ()), (), PlanLibrary(()), [])
"""Receives the messages to agents that are not in the run."""


class CoupledRun(SystemRun):
    """The run of coupled agents. Messages to agents that are not in it go nowhere."""

    def __init__(self) -> None:
        super().__init__(Environment(), 0)
        self.now_s = 0.0
        self.succeeds = True
        """Whether the external action that is executed next succeeds."""
        self._ended_waits = 0

    def put(self, agents: Iterable[Agent], others: Iterable[str]) -> None:
        """These agents are in the run; the others, by name, are only there to be sent to."""
        self.order = tuple(agents)
        self.agents |= {agent.name: agent for agent in self.order}
        for name in others:
            self.agents[name] = replace(_NOBODY, name=name).agent(self)

    @property
    def ticks(self) -> int:
        """The agents' clock."""
        return math.floor(self._exact_ticks())

    def _exact_ticks(self) -> float:
        # Rounded first: a time that is a whole number of ticks has no exact binary form.
        return round(self.now_s * TICKS_PER_S, 6)

    def deadline(self, wait_ms: float) -> float:
        """The tick at which a wait that begins now is over: never before its time."""
        # Up, while `ticks` rounds down: a wait that begins between two ticks would else be over too early.
        return math.ceil(self._exact_ticks()) + ticks_of(wait_ms)

    @property
    def due_s(self) -> float:
        """When the next wait of an agent is over (s); infinite if there is none."""
        waiting: list[PendingWait | PendingQuestion] = []
        for agent in self.order:
            waiting += [*agent.waits, *agent.questions.values()]
        deadlines = [wait.deadline for wait in waiting if wait.deadline is not None]
        return min(deadlines, default=math.inf) / TICKS_PER_S

    def deliver(self, receiver: str, message: SpeechAct) -> None:
        """Put a message into the mailbox of an agent that is in the run."""
        if self.agents[receiver] in self.order:
            super().deliver(receiver, message)

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """An external action has been executed: whether it succeeded."""
        return self.succeeds

    def tell(self, receiver: Agent, literal: Structure, source: str, goal: bool) -> None:
        """Tell an agent something, or give it a goal, now. Raises BdiError: as `settle`."""
        self.messages += 1
        receiver.mailbox.append(SpeechAct(source, "achieve" if goal else "tell", literal, self.messages))
        receiver.awake = True
        self.settle()

    def wait_until(self, time_s: float) -> None:
        """The clock has reached `time_s`, and no wait is over before it: agents continue whose wait is over by now.

        Raises:
            BdiError: as `settle`; or an agent waits again and again for no time.
        """
        self._ended_waits = self._ended_waits + 1 if time_s == self.now_s else 0
        if self._ended_waits > MAX_CYCLES:
            raise BdiError(
                f"{self._names()} waits more than {MAX_CYCLES:,} times without time passing: {self._activities()}"
            )
        self.now_s = time_s
        if self.earliest_deadline <= self.ticks:
            self._end_waits()
            self.settle()

    def advance_to(self, time_s: float) -> None:
        """Let the agents live up to `time_s`: their waits end at their times. Raises BdiError: as `wait_until`."""
        while self.due_s <= time_s:
            self.wait_until(max(self.due_s, self.now_s))
        if time_s > self.now_s:
            self.wait_until(time_s)

    def settle(self) -> None:
        """Let the agents do all they can now. Raises BdiError: an agent cannot continue, or never comes to rest."""
        with count_work(self):
            for _ in range(MAX_CYCLES):
                if not self.do_round() or self._only_busy():
                    return
        raise BdiError(
            f"{self._names()} does not come to rest: let it wait with .wait, not in a busy loop: {self._activities()}"
        )

    def _only_busy(self) -> bool:
        return all(agent.busy_waiting and not agent.has_news() for agent in self.order if agent.awake)

    def _names(self) -> str:
        return " or ".join(agent.name for agent in self.order)

    def _activities(self) -> str:
        return "; ".join(agent.activity() for agent in self.order)


_in_order = attrgetter("number")


@dataclass(eq=False)  # two intentions before the same act are two: to remove one has to find this one
class ReadyAct:
    """Something that the agent is ready to do, and does not do until it is told to.

    Args:
        text: the act, as AgentSpeak.
        literal: its literal; None for a plan's beginning.
        plan: the label of the plan that it belongs to.
        ready_s: when the agent became ready for it (s).
        acts: the numbers of the declared acts that it is, where acts are declared.
        number: counts what the agent has been ready for.
    """

    text: str
    literal: Structure | None
    plan: str
    ready_s: float
    intention: Intention = field(repr=False)
    acts: tuple[int, ...] = ()
    number: int = 0


# Ordered, because to remove the first and to find the next first takes constant time only then.
_Acts = OrderedDict[ReadyAct, None]


class _Kind:
    """The open acts that are the same declared ones: all of them, and by their text, in order."""

    def __init__(self) -> None:
        self.all: _Acts = OrderedDict()
        self.by_text: dict[str, _Acts] = {}

    def different(self) -> Iterator[ReadyAct]:
        """The first act of each text, in order."""
        yield next(iter(self.all))  # most often the one that is looked for
        yield from sorted((next(iter(acts)) for acts in self.by_text.values()), key=_in_order)[1:]


class ReadyActs(Collection[ReadyAct]):
    """The ready acts of an agent, in the order in which they became ready.

    Equal acts differ only in when they became ready, so an event looks only at the first of each sort, however many are
    open.
    """

    def __init__(self) -> None:
        self._acts: _Acts = OrderedDict()
        self._kinds: dict[tuple[int, ...], _Kind] = {}
        self._numbers = count()

    def __contains__(self, act: object) -> bool:
        """Whether the agent is ready for this act."""
        return act in self._acts

    def __iter__(self) -> Iterator[ReadyAct]:
        """All acts, in order."""
        return iter(self._acts)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._acts)

    def add(self, act: ReadyAct) -> None:
        """The agent has become ready for an act."""
        act.number = next(self._numbers)
        kind = self._kinds.setdefault(act.acts, _Kind())
        for acts in (self._acts, kind.all, kind.by_text.setdefault(act.text, OrderedDict())):
            acts[act] = None

    def remove(self, act: ReadyAct) -> None:
        """The agent is not ready for an act any more."""
        kind = self._kinds[act.acts]
        for acts in (self._acts, kind.all, kind.by_text[act.text]):
            del acts[act]
        if not kind.by_text[act.text]:
            del kind.by_text[act.text]
        if not kind.all:
            del self._kinds[act.acts]

    def different(self, numbers: Set[int]) -> Iterator[ReadyAct]:
        """The acts that are one of these declared ones; of equal acts the first, in order."""
        kinds = [kind.different() for acts, kind in self._kinds.items() if any(number in numbers for number in acts)]
        return heapq.merge(*kinds, key=_in_order)

    def longest_ready(self) -> list[ReadyAct]:
        """The act that became ready first, for each group of equal declared acts; in order."""
        return sorted((next(iter(kind.all)) for kind in self._kinds.values()), key=_in_order)


class CoupledAgent(Agent, ABC):
    """An agent that pauses before acts; a subclass decides which. Takes the arguments of `Agent`."""

    run: CoupledRun

    def couple(self) -> None:
        """Prepare for a run."""
        self.ready_acts = ReadyActs()
        """Its ready acts, in the order in which they became ready."""
        self._released: Intention | None = None

    @abstractmethod
    def acts_of(self, intention: Intention, literal: Structure) -> tuple[int, ...] | None:
        """The declared acts that an intention is about to do; None if it need not pause before this one."""

    def execute(self, intention: Intention) -> None:
        """Execute the next statement of an intention, unless it has to pause before it."""
        if intention is self._released:
            self._released = None
        elif (literal := self._act_of(intention)) is not None:
            acts = self.acts_of(intention, literal)
            if acts is not None:
                self.stop_before(intention, str(literal), literal, acts)
                return
        super().execute(intention)

    def go_on_after(self, act: ReadyAct, succeeded: bool = True) -> None:
        """Resume after an act that it was ready for has been done."""
        self.ready_acts.remove(act)
        if act.literal is not None:
            self._released, self.run.succeeds = act.intention, succeeded
        # To the front: the statements after the act belong to the instant at which it was done.
        self.intentions.appendleft(act.intention)
        self.awake = True

    def all_intentions(self) -> list[tuple[Intention, Event | None]]:
        """All intentions, those before an act among them."""
        return super().all_intentions() + [(act.intention, None) for act in self.ready_acts]

    def remove_intention(self, intention: Intention) -> None:
        """Remove an intention, and the act that it is ready for."""
        super().remove_intention(intention)
        for act in [act for act in self.ready_acts if act.intention is intention]:
            self.ready_acts.remove(act)

    def stop_before(self, intention: Intention, text: str, literal: Structure | None, acts: tuple[int, ...]) -> None:
        """Pause an intention before an act."""
        # The innermost plan that has a label: plans without one are details of it.
        labelled = [means.plan.label for means in intention.stack if means.plan.has_label]
        plan = labelled[-1] if labelled else ""
        self.ready_acts.add(ReadyAct(text, literal, plan, self.run.now_s, intention, acts))

    def is_external(self, intention: Intention) -> bool:
        """Whether an intention is about to execute an external action."""
        means = intention.stack[-1]
        return not means.is_finished and isinstance(means.statement, ExternalAction)

    def _act_of(self, intention: Intention) -> Structure | None:
        """The message or external action that an intention is about to send or execute."""
        means = intention.stack[-1]
        if means.is_finished:
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
