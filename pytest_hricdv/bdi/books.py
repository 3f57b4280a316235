"""What the agents of a run share: what they have done, the virtual clock, chance, and names for new things."""

from __future__ import annotations

import random
from collections.abc import Mapping

from pytest_hricdv.bdi.language.terms import Variable

from .environment import Environment
from .intentions import TICKS_PER_MS, duration

FIRST_FRESH = 100_000
"""Variables made in a run are numbered from here, those of the sources from 1."""


class Books:
    """The books of a run.

    Args:
        environment: what the agents perceive and act on.
        seed: of the run's one stream of random numbers.
    """

    def __init__(self, environment: Environment, seed: int) -> None:
        self.environment = environment
        self.prints: list[str] = []
        self.actions: list[tuple[str, str]] = []
        self.warnings: list[str] = []
        self.rounds = 0
        self.skipped = 0
        """The ticks of the virtual clock in which nobody had anything to do."""
        self.progress = 0
        """Grows with everything an agent does that another, or the user, could notice, or that it could remember."""
        self.sent = 0
        """Messages sent so far."""
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
        return self.ms(self.ticks)

    @staticmethod
    def ms(ticks: int) -> float:
        """Ticks as milliseconds."""
        return ticks / TICKS_PER_MS

    def after(self, wait_ms: float) -> float:
        """The tick at which a wait that begins now is over."""
        return self.ticks + duration(wait_ms)

    def percept_versions(self, agent: str) -> Mapping[str, int]:
        """Where an agent looks whether its percepts have changed: a number for each agent that grows with them."""
        return self.environment.versions

    def print(self, agent: str, text: str) -> None:
        """Note what an agent prints."""
        self.prints.append(f"[{agent}] {text}")
        self.progress += 1

    def warn(self, text: str) -> None:
        """Note what the author of the models should know."""
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
        self.sent += 1
        return f"mid{self.sent}"
