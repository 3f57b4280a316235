"""A run of agents whose clock is set by the simulation that it is coupled to."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from pytest_hricdv.bdi import BdiError, Environment, Structure
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import TICKS_PER_MS, PendingQuestion, PendingWait, SpeechAct, ticks_of
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.limits import count_work
from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan, Program
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.bdi.run.system_run import SystemRun

MS_PER_S = 1000
TICKS_PER_S = TICKS_PER_MS * MS_PER_S

MAX_CYCLES = 10_000
"""An agent that takes more reasoning cycles without time passing waits busily. A thousand times what any agent of the
tests in tests/hri takes, which is 10."""

_NOBODY = AgentTemplate("", Program("", (), (), ()), (), PlanLibrary(()), [])
"""An agent that is only there to be sent to."""


class CoupledRun(SystemRun):
    """The run. Messages to agents that are not in it go nowhere."""

    def __init__(self) -> None:
        super().__init__(Environment(), 0, None)
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
        """The clock has reached `time_s`, and no wait is over before it: agents go on whose wait is over by now.

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
        """Let the agents do all that they can do now. Raises BdiError: one cannot continue, or never comes to rest."""
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
