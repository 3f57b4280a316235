"""The mutable state of a run: outputs, virtual clock, random stream, fresh variables."""

from __future__ import annotations

import random
from collections.abc import Mapping

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import TICKS_PER_MS, ticks_of
from pytest_hricdv.bdi.language.terms import Structure, Variable
from pytest_hricdv.bdi.run.environment import Environment

FIRST_FRESH = 100_000
"""Variables made in a run are numbered from here, those of the sources from 1."""


class RunState:
    """The state that the agents of a run share.

    Args:
        environment: what the agents perceive and act on.
        seed: of the run's one stream of random numbers.
    """

    def __init__(self, environment: Environment, seed: int) -> None:
        self.environment = environment
        self.agents: dict[str, Agent] = {}
        """The agents by name, in the order in which they act."""
        self.prints: list[str] = []
        self.actions: list[tuple[str, str]] = []
        self.warnings: list[str] = []
        self.rounds = 0
        self.skipped = 0
        """The ticks of the virtual clock in which no agent had anything to do."""
        self.progress = 0
        """Grows with everything an agent does that another, or the user, could notice, or that it could remember."""
        self._messages = 0
        self._seed = seed
        self._random: random.Random | None = None
        self._fresh = FIRST_FRESH

    @property
    def ticks(self) -> int:
        """The virtual clock."""
        return self.rounds + self.skipped

    @property
    def time_ms(self) -> float:
        """Virtual time."""
        return self.ticks / TICKS_PER_MS

    def deadline(self, wait_ms: float) -> float:
        """The tick at which a wait that begins now is over."""
        return self.ticks + ticks_of(wait_ms)

    def percept_versions(self, agent: str) -> Mapping[str, int]:
        """Where an agent finds under its name a number that grows with every change of its percepts."""
        return self.environment.versions

    def percepts(self, agent: str) -> tuple[Structure, ...]:
        """What an agent perceives now."""
        return self.environment.percepts(agent)

    def print(self, agent: str, text: str) -> None:
        """Record what an agent prints."""
        self.prints.append(f"[{agent}] {text}")
        self.progress += 1

    def warn(self, text: str) -> None:
        """Record what the author of the models should know."""
        self.warnings.append(text)
        self.progress += 1

    def draw(self) -> float:
        """The next random number, from 0 inclusive to 1 exclusive."""
        if self._random is None:
            self._random = random.Random(self._seed)
        self.progress += 1
        return self._random.random()

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        self._fresh += 1
        return Variable(f"_{self._fresh}")

    def is_fresh(self, variable: Variable) -> bool:
        """Whether :meth:`fresh` made the variable."""
        return variable[:1] == "_" and variable[1:].isdigit() and int(variable[1:]) > FIRST_FRESH

    def next_message_number(self) -> str:
        """A number for a message."""
        self._messages += 1
        return f"mid{self._messages}"
