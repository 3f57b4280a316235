"""The methods without learning, and all methods by name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.generate.belief_sets import read_belief_sets
from pytest_hricdv.generate.context import GenerationContext, Method, draft_of, evenly_spaced
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.files import Files
from pytest_hricdv.generate.ids import Draft
from pytest_hricdv.generate.rl import ReinforcementLearning
from pytest_hricdv.generate.rng import make_rng, pick, random_index
from pytest_hricdv.generate.suite import Generation, Suite
from pytest_hricdv.generate.text_format import target_of_commands
from pytest_hricdv.suggestion import nearest

_DRAWS_PER_TEST = 1000


@dataclass(frozen=True)
class ByHand:
    """The paper's method by hand: the subsets of `GenerationContext.by_hand`, in the file's order."""

    name: str = "by-hand"

    def generate(self, context: GenerationContext) -> Suite:
        """Run the model once for each subset.

        Raises:
            GenerateError: the testbench names no file, or something in it is wrong; with file, line and column.
        """
        if context.by_hand is None:
            raise GenerateError("tests by hand need a file of belief subsets, but the testbench names none")
        runner, space = context.model_runner(), context.beliefs
        drafts: list[Draft] = []
        for entry in read_belief_sets(context.by_hand, space):
            for subset in entry.subsets:
                drafts += [draft_of(runner.run(subset), space, entry.name)] * entry.concretizations
        generation = Generation(bdi_runs=runner.run_count, declared_plans=runner.plan_labels, notes=runner.notes())
        return Suite.of_drafts(self.name, context.seed, evenly_spaced(drafts, context.tests), generation)


@dataclass(frozen=True)
class BdiPseudorandom:
    """The paper's BDI pseudorandom method: distinct subsets, each with one belief from each group; 100 by default."""

    name: str = "bdi-random"
    size: int = 100

    def generate(self, context: GenerationContext) -> Suite:
        """Draw the subsets, run the model once for each. A larger suite of the same seed begins with the smaller."""
        runner, space = context.model_runner(), context.beliefs
        count = context.tests or self.size
        groups = [space.start, *space.groups.values()]
        possible = math.prod(len(group) for group in groups)
        rng = make_rng(self.name, context.seed)
        chosen: dict[tuple[str, ...], None] = {}
        draws = 0
        while len(chosen) < min(count, possible) and draws < _DRAWS_PER_TEST * count:
            chosen[space.subset(pick(rng, group) for group in groups)] = None
            draws += 1
        drafts = [draft_of(runner.run(subset), space) for subset in chosen]
        short = f"{count} tests asked for, but only {len(chosen)} distinct subsets were found of {possible} that exist"
        generation = Generation(
            bdi_runs=runner.run_count,
            declared_plans=runner.plan_labels,
            notes=(*([short] if len(chosen) < count else []), *runner.notes()),
        )
        return Suite.of_drafts(self.name, context.seed, drafts, generation)


@dataclass(frozen=True)
class Pseudorandom:
    """The paper's baseline without a model: 100 tests by default, each a random sequence of commands."""

    name: str = "pseudorandom"
    size: int = 100

    def generate(self, context: GenerationContext) -> Suite:
        """Draw the tests, each from its own random stream, with `GenerationContext.lengths` commands.

        Raises:
            GenerateError: no command can be executed.
        """
        if not context.commands:
            raise GenerateError("pseudorandom tests need the commands that can be executed, but the testbench has none")
        drafts = [self._draw(context, number) for number in range(context.tests or self.size)]
        return Suite.of_drafts(self.name, context.seed, drafts, Generation())

    def _draw(self, context: GenerationContext, number: int) -> Draft:
        rng = make_rng(self.name, context.seed, number)
        fewest, most = context.lengths
        length = fewest + random_index(rng, most - fewest + 1)
        lines = tuple(pick(rng, context.commands) for _ in range(length))
        return Draft(target_of_commands(lines), (), lines)


#: The methods of the paper, in its order.
METHODS: Mapping[str, Method] = {
    method.name: method for method in (ByHand(), BdiPseudorandom(), ReinforcementLearning(), Pseudorandom())
}
ALL = "all"


def select_methods(selection: str, root: Path) -> tuple[Method, ...]:
    """The methods of a selection such as `by-hand,rl`, `all` or `tests/recorded.txt`, in order, each once.

    Args:
        selection: names, `all`, or paths of files and folders of tests, with commas between them.
        root: the folder that paths are relative to.

    Raises:
        GenerateError: a name that is no method, and no file or folder either; or nothing selected.
    """
    chosen: dict[Method, None] = {}
    for name in filter(None, (part.strip() for part in selection.split(","))):
        if name == ALL:
            chosen.update(dict.fromkeys(METHODS.values()))
        elif name in METHODS:
            chosen[METHODS[name]] = None
        elif (root / name).exists():
            chosen[Files(root / name)] = None
        else:
            raise GenerateError(
                f"suite {name!r} is no method, and there is no file or folder of that name in {root}"
                f"{nearest(name, (*METHODS, ALL))}"
            )
    if not chosen:
        raise GenerateError(f"suite {selection!r} selects nothing{nearest('', (*METHODS, ALL))}")
    return tuple(chosen)
