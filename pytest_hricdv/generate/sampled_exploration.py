"""Exploration by sampling: runs randomly drawn belief sets of a model that is too large to be explored completely."""

from __future__ import annotations

import math
from collections.abc import Iterator
from random import Random

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.model import Exploration, ModelRun
from pytest_hricdv.generate.model_runner import MAX_OTHERS, ModelRunner, distinct_runs, order_of_run
from pytest_hricdv.generate.rng import make_rng, pick

SAMPLES = 2**MAX_OTHERS
"""Number of belief sets drawn: as many as one start belief has in the largest model that is explored completely."""

DRAWS = 20 * SAMPLES
"""Most draws: for spaces with fewer sets, more than 19 of 20 draws repeat one."""


def explore_by_sampling(runner: ModelRunner, reason: str) -> Exploration:
    """Find some runs of a model: of belief sets with one start belief, and one belief of each group or none.

    The sets depend on the belief space alone, so they are the same in each session. Sets that the model fails with are
    left out, and the reason says how many.

    Args:
        reason: why the model cannot be explored as a whole.

    Raises:
        GenerateError: the model fails with each set.
    """
    plans = tuple((agent, label) for agent, labels in runner.plan_labels.items() for label in labels)
    executed: list[ModelRun] = []
    failures: list[GenerateError] = []
    sets = [*_sets(runner, make_rng("sampled exploration", list(runner.space.beliefs)))]
    for beliefs in sets:
        try:
            executed.append(runner.run(beliefs))
        except GenerateError as error:
            failures.append(error)
    if not executed:
        raise failures[0]
    runs = sorted(distinct_runs(executed, runner.space, plans), key=order_of_run)
    text = f"{reason}; so {len(sets)} sets of beliefs were drawn, which gave {len(runs)} different runs"
    if failures:
        text += f"; with {len(failures)} of them the model failed; the first: {failures[0]}"
    return Exploration(plans, runner.space.beliefs, tuple(runs), text)


def _sets(runner: ModelRunner, rng: Random) -> Iterator[tuple[str, ...]]:
    """Distinct belief sets: each start belief alone, then those that are drawn."""
    space, drawn = runner.space, dict[tuple[str, ...], None]()
    groups = [
        ("", *(belief for belief in group if belief not in space.default_beliefs)) for group in space.groups.values()
    ]
    possible = len(space.start) * math.prod(len(group) for group in groups)
    for start in space.start:
        drawn[space.subset([start])] = None
    for _ in range(DRAWS):
        if len(drawn) >= min(SAMPLES, possible):
            break
        beliefs = [pick(rng, space.start), *(pick(rng, group) for group in groups)]
        drawn[space.subset(belief for belief in beliefs if belief)] = None
    yield from drawn
