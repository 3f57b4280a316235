"""Methods: the ways to generate a suite, behind one protocol."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

from .abstract import Plans
from .beliefs import BeliefSpace
from .error import GenerateError
from .exploration import Exploration
from .identity import Draft
from .model import Model
from .qlearning import QLearning
from .suite import Suite, fingerprint
from .warm_start import COLD, WarmStart

if TYPE_CHECKING:
    from .explorer import Explorer

T = TypeVar("T")

#: Fewest and most actions of a pseudorandom test in the original experiment.
LENGTHS = (4, 19)


@dataclass(frozen=True)
class Context:
    """What methods generate from. A method takes what it needs and says what it misses.

    Args:
        model: the BDI agents.
        space: the beliefs they are steered with.
        commands: the commands that can be enacted, in the text format.
        seed: the master seed.
        tests: how many tests to generate, in place of the method's own number.
        by_hand: the TOML file of belief subsets written by hand.
        learning: the parameters of Q-learning.
        start: what Q-learning begins with.
        save: the file that the table learned is written to; no suite depends on it.
        lengths: fewest and most actions of a pseudorandom test.

    Raises:
        GenerateError: `tests` or `lengths` make no sense.
    """

    model: Model | None = None
    space: BeliefSpace | None = None
    commands: tuple[str, ...] = ()
    seed: int = 0
    tests: int | None = None
    by_hand: Path | None = None
    learning: QLearning = field(default_factory=QLearning)
    start: WarmStart = COLD
    save: Path | None = field(default=None, compare=False)
    lengths: tuple[int, int] = LENGTHS

    def __post_init__(self) -> None:
        if self.tests is not None and self.tests < 1:
            raise GenerateError(f"{self.tests} tests: expected at least 1")
        if not 1 <= self.lengths[0] <= self.lengths[1]:
            raise GenerateError(f"lengths {self.lengths}: expected 1 <= fewest <= most actions")

    def explorer(self) -> Explorer:
        """A new explorer of the model.

        Raises:
            GenerateError: there is no model, or it does not fit the belief space.
        """
        # Imported here: names and options of methods are wanted in every session, the BDI engine in few.
        from .explorer import Explorer

        if self.model is None:
            raise GenerateError("this method needs a BDI model, but the testbench has none")
        return Explorer(self.model, self.beliefs)

    @property
    def beliefs(self) -> BeliefSpace:
        """The belief space.

        Raises:
            GenerateError: there is none.
        """
        if self.space is None:
            raise GenerateError("this method needs a belief space, but the testbench has none")
        return self.space

    def fingerprint(self, method: str) -> str:
        """What the suite of a method depends on, as one hash (hex): the key to keep it under in a cache.

        Folders do not count, so that a checkout elsewhere has the same key. Suites read from files are not worth it.

        Raises:
            GenerateError: a file of the model, or the one of subsets by hand, cannot be read.
        """
        files = [] if self.model is None else list(self.model.files())
        files += [] if self.by_hand is None else [self.by_hand]
        parts = None if self.model is None else self.model.parts()
        learning = [asdict(self.learning), self.start.digest]
        parameters = [method, parts, self.commands, self.tests, learning, self.lengths]
        return fingerprint(files, self.space, parameters, self.seed)


class Method(Protocol):
    """One way to generate a suite."""

    @property
    def name(self) -> str:
        """What the method, and the suite it generates, is called."""

    def generate(self, context: Context) -> Suite:
        """The suite; the same for the same context, wherever and whenever.

        Raises:
            GenerateError: the context lacks something, or something in it makes no sense.
        """


def draft_of(exploration: Exploration, space: BeliefSpace, name: str = "") -> Draft:
    """The test that a run of the model showed."""
    plans: Plans = {agent: tuple(sorted(labels)) for agent, labels in sorted(exploration.plans.items())}
    return Draft(space.aim(exploration.beliefs), exploration.beliefs, exploration.lines, plans, name)


def spread(items: Sequence[T], count: int | None) -> list[T]:
    """`count` of the items, in order: evenly spaced if there are more, over and over if there are fewer."""
    if count is None or not items:
        return list(items)
    if count <= len(items):
        return [items[place * len(items) // count] for place in range(count)]
    return [items[place % len(items)] for place in range(count)]
