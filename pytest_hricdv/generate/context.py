"""`GenerationContext` has the inputs from which suites are generated; a `Method` generates a suite from it.

`session.suites` makes the context of a testbench and the options, and calls `generate` of each selected method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

from pytest_hricdv._base.message import quote
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractDraft, Plans
from pytest_hricdv.generate.actors import NO_ORDER, After
from pytest_hricdv.generate.beliefs import MAX_TESTS, BeliefSpace
from pytest_hricdv.generate.model import Model, ModelRun, file_digests
from pytest_hricdv.generate.qlearning import COLD_START, QLearning, WarmStart
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.generate.suite import Suite

if TYPE_CHECKING:
    from pytest_hricdv.generate.model_runner import ModelRunner

T = TypeVar("T")

GENERATOR_VERSION = "1"
"""Part of the key of every cached suite; increase it if the same inputs give other tests than before."""

PSEUDORANDOM_LENGTHS = (4, 19)
"""Minimum and maximum number of actions of a pseudorandom test in the original experiment."""


@dataclass(frozen=True)
class GenerationContext:
    """The inputs of suite generation. A method that lacks one raises an error.

    Args:
        space: the beliefs they are steered with.
        commands: the commands that can be executed, in the text format.
        tests: how many tests to generate, in place of the method's own number.
        by_hand: the TOML file of belief subsets written by hand.
        start: the table or belief sets with which Q-learning begins.
        save: the file that the learned table is written to; no suite depends on it.
        lengths: fewest and most actions of a pseudorandom test, of each actor where there are several.

    Raises:
        GenerateError: `tests` or `lengths` out of range.
    """

    model: Model | None = None
    space: BeliefSpace | None = None
    commands: tuple[str, ...] = ()
    seed: int = 0
    tests: int | None = None
    by_hand: Path | None = None
    learning: QLearning = field(default_factory=QLearning)
    start: WarmStart = COLD_START
    save: Path | None = field(default=None, compare=False)
    tell: Callable[[str], None] = field(default=lambda text: None, compare=False)
    lengths: tuple[int, int] = PSEUDORANDOM_LENGTHS

    def __post_init__(self) -> None:
        if self.tests is not None and not 1 <= self.tests <= MAX_TESTS:
            raise GenerateError(f"{quote(self.tests)} tests: expected a number from 1 to {MAX_TESTS}")
        if not 1 <= self.lengths[0] <= self.lengths[1]:
            raise GenerateError(f"random_test_length {self.lengths}: expected 1 <= fewest <= most actions")

    def model_runner(self) -> ModelRunner:
        """A new runner of the model. Raises GenerateError: there is no model, or it does not fit the belief space."""
        # Imported here: every session needs the names and options of methods, few need the BDI engine.
        from pytest_hricdv.generate.model_runner import ModelRunner

        if self.model is None:
            raise GenerateError("this method needs a BDI model, but the testbench has none")
        return ModelRunner(self.model, self.beliefs)

    @property
    def beliefs(self) -> BeliefSpace:
        """The belief space. Raises GenerateError: there is none."""
        if self.space is None:
            raise GenerateError("this method needs a belief space, but the testbench has none")
        return self.space

    def fingerprint(self, method: str) -> str:
        """Hash (hex) of everything that the suite of a method depends on: its key in a cache.

        Of files, names and contents count, but not folders, so that another checkout has the same key. Suites that
        are read from files have no key.

        Raises:
            GenerateError: a file of the model, or the one of subsets by hand, cannot be read.
        """
        model, space = self.model, self.space
        files = [] if model is None else list(model.files())
        files += [] if self.by_hand is None else [self.by_hand]
        groups = None if space is None else [list(group) for group in space.groups.items()]
        return digest(
            GENERATOR_VERSION,
            method,
            file_digests(files),
            None if model is None else model.parts(),
            None if space is None else [space.start, groups, space.id_groups, space.default_beliefs],
            self.commands,
            self.seed,
            self.tests,
            [list(item) for item in asdict(self.learning).items()],
            self.start.digest,
            self.lengths,
        )


class Method(Protocol):
    """One way to generate a suite."""

    @property
    def name(self) -> str:
        """The name of the method and of the suite it generates."""

    def generate(self, context: GenerationContext) -> Suite:
        """The suite; the same for the same context on every machine.

        Raises:
            GenerateError: the context lacks something, or something in it is invalid.
        """


def draft_of(run: ModelRun, space: BeliefSpace, name: str = "", after: After = NO_ORDER) -> AbstractDraft:
    """The test that a run of the model gives; `after` is the order between its actors."""
    plans: Plans = {agent: tuple(sorted(labels)) for agent, labels in sorted(run.plans.items())}
    return AbstractDraft(space.target(run.beliefs), run.beliefs, run.lines, plans, name, after=after)


def evenly_spaced(items: Sequence[T], count: int | None) -> list[T]:
    """`count` of the items, in order: evenly spaced if there are more, repeated from the start if there are fewer."""
    if count is None or not items:
        return list(items)
    if count <= len(items):
        return [items[place * len(items) // count] for place in range(count)]
    return [items[place % len(items)] for place in range(count)]
