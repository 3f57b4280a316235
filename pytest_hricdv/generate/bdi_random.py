"""BDI pseudorandom: one belief from each group."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .method import Context, draft_of
from .stream import pick, stream
from .suite import Generation, Suite

_TRIES = 1000


@dataclass(frozen=True)
class BdiPseudorandom:
    """The paper's BDI pseudorandom method: distinct subsets, each with one belief from each group; 100 by default."""

    name: str = "bdi-random"
    size: int = 100

    def generate(self, context: Context) -> Suite:
        """Draw the subsets, run the model once for each. A larger suite of the same seed begins with the smaller."""
        explorer, space = context.explorer(), context.beliefs
        count = context.tests or self.size
        groups = [space.start, *space.groups.values()]
        exist = math.prod(len(group) for group in groups)
        random = stream(self.name, context.seed)
        chosen: dict[tuple[str, ...], None] = {}
        tries = 0
        while len(chosen) < min(count, exist) and tries < _TRIES * count:
            chosen[space.subset(pick(random, group) for group in groups)] = None
            tries += 1
        drafts = [draft_of(explorer.explore(subset), space) for subset in chosen]
        short = f"{count} tests asked for, but only {len(chosen)} distinct subsets were found of {exist} that exist"
        generation = Generation(
            bdi_runs=explorer.runs,
            declared_plans=explorer.plan_labels,
            notes=(*([short] if len(chosen) < count else []), *explorer.notes()),
        )
        return Suite.of_drafts(self.name, context.seed, drafts, generation)
