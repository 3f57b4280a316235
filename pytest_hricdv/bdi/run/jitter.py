"""`JitteredRun`: a run with random delays (`MultiAgentSystem.run(jitter=...)`), to find races.

Jason's agents run concurrently, so the interleaving of their steps is left to chance. A plain run here always
uses the same interleaving. A run with jitter uses others: in every round the agents act
in a random order, and messages and changes of percepts arrive some rounds late. But messages from one agent
to another keep their order, and what is perceived before the run is perceived at once. The seed determines
all delays. A model whose outcome differs between seeds has a race.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

from pytest_hricdv.bdi.agent.intentions import PerceptSource, SpeechAct
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.run.environment import Environment
from pytest_hricdv.bdi.run.system_run import SystemRun


class JitteredRun(SystemRun):
    """A run in which agents act in random order, and messages and percepts may be late.

    Args:
        environment: what the agents perceive and act on.
        seed: the seed of the delays and, in a stream of its own, of the agents' random numbers.
        jitter: maximum delay in rounds; 0 for a run without jitter.
    """

    def __init__(self, environment: Environment, seed: int, jitter: int) -> None:
        super().__init__(environment, seed)
        self._jitter = jitter
        # A stream of its own: agents draw the same random numbers whatever the delays.
        self._chance = random.Random(f"jitter {seed}")
        self._under_way: list[tuple[int, str, SpeechAct]] = []
        self._last_arrivals: dict[tuple[str, str], int] = {}
        self._late: dict[str, _LatePercepts] = {}

    def round_of_arrival(self) -> int:
        """The round in which something arrives that is sent now."""
        return self.rounds + self._chance.randint(0, self._jitter)

    def percepts_of(self, agent: str) -> PerceptSource:
        """The percepts of an agent, which learns of changes late."""
        percepts = super().percepts_of(agent)
        return self._late.setdefault(agent, _LatePercepts(self, percepts)) if self._jitter else percepts

    def deliver(self, receiver: str, message: SpeechAct) -> None:
        """Send a message on its way, not to arrive before an earlier one from the same sender."""
        if not self._jitter:
            super().deliver(receiver, message)
            return
        way = (message.sender, receiver)
        arrival = max(self.round_of_arrival(), self._last_arrivals.get(way, 0))
        self._last_arrivals[way] = arrival
        if arrival <= self.rounds:
            super().deliver(receiver, message)
        else:
            self.progress += 1
            self._under_way.append((arrival, receiver, message))

    def only_busy_waiting(self) -> bool:
        """As in any run; a message or percept in transit may still change everything."""
        return not self._expects() and super().only_busy_waiting()

    def _expects(self) -> bool:
        """Whether any message or percept is under way."""
        return bool(self._under_way) or any(late.is_pending for late in self._late.values())

    def do_round(self) -> bool:
        """Do a round, unless no agent has anything to do, now or once what is under way has arrived."""
        if not self._jitter:
            return super().do_round()
        self._arrive()
        agents = list(self.agents.values())
        self._chance.shuffle(agents)
        for agent in agents:
            agent.awake = agent.has_work()
        expecting = self._expects()
        if not expecting and not any(agent.awake for agent in agents):
            return False
        self.order = agents
        if not super().do_round():
            # Nobody acts while something is under way: the round counts all the same, or it would never arrive.
            self.rounds += 1
        # While something is under way, agents that only repeat themselves may yet have reason to stop.
        self.progress += expecting
        return True

    def _arrive(self) -> None:
        waiting = self._under_way
        self._under_way = [entry for entry in waiting if entry[0] > self.rounds]
        for arrival, receiver, message in waiting:
            if arrival <= self.rounds:
                super().deliver(receiver, message)


class _LatePercepts:
    """The percepts of an agent; the version is the one that the agent knows of, some rounds late."""

    def __init__(self, run: JitteredRun, percepts: PerceptSource) -> None:
        self._run = run
        self._percepts = percepts
        self._arrived = self._newest = percepts.version
        self._arrival = 0

    @property
    def is_pending(self) -> bool:
        """Whether a change has not arrived yet."""
        return self.version != self._newest

    @property
    def version(self) -> int:
        """Grows with every change that has arrived."""
        newest = self._percepts.version
        if newest != self._newest:
            self._newest = newest
            self._arrival = self._run.round_of_arrival()
        if self._run.rounds >= self._arrival:
            self._arrived = self._newest
        return self._arrived

    def literals(self) -> Iterable[Structure]:
        """The present percepts."""
        return self._percepts.literals()
