"""The learned policy: the best and the second best belief in each state, and the subsets that follow from it.

Paper: the two best beliefs of each state form the policy from which 134 belief subsets came.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.qlearning import QLearning, QTable
from pytest_hricdv.generate.rng import make_rng, random_index, shuffled


def rankings(q: QTable, space: BeliefSpace, *seed: int) -> dict[str, tuple[str, ...]]:
    """The beliefs of each state, best first. Ties are broken at random, so that the declared order has no effect."""
    ranked = {}
    for state in space.beliefs:
        drawn = shuffled(make_rng("policy-ties", *seed, state), list(q[state]))
        ranked[state] = tuple(sorted(drawn, key=lambda belief: -q[state][belief]))
    return ranked


def policy_subsets(
    q: QTable, space: BeliefSpace, parameters: QLearning, count: int, seed: int, round_number: int = 0
) -> tuple[tuple[str, ...], ...]:
    """Up to `count` distinct belief subsets that the policy leads to, each in the space's order.

    The rule: walks begin with each start belief in turn and draw their size as learning did. Each step takes one of
    the best beliefs in the current state that are not yet in the subset, each equally likely; how many of the best is
    `alternatives` (2: the best or the second best). Walks go on until there are enough distinct subsets. After
    `patience` walks in a row without a new subset, all subsets of the policy are enumerated, shortest first. So fewer
    than `count` are returned only if fewer exist. Each round of learning has its own random stream.
    """
    key = (seed, round_number) if round_number else (seed,)
    ranked = rankings(q, space, *key)
    rng = make_rng("policy-walks", *key)
    found: dict[tuple[str, ...], None] = {}
    fruitless = walks = 0
    while len(found) < count and fruitless < parameters.patience:
        walk = [space.start[walks % len(space.start)]]
        size = parameters.subset_size(rng)
        while len(walk) < size and (options := _options(ranked[walk[-1]], walk, parameters.alternatives)):
            walk.append(options[random_index(rng, len(options))])
        subset = space.subset(walk)
        fruitless = fruitless + 1 if subset in found else 0
        found[subset] = None
        walks += 1
    if len(found) < count:
        for subset in _enumerate(ranked, space, parameters):
            found[subset] = None
            if len(found) == count:
                break
    return tuple(found)


def _options(ranking: Sequence[str], chosen: Sequence[str], count: int) -> list[str]:
    """The `count` best beliefs of a state that are not yet chosen."""
    options: list[str] = []
    for belief in ranking:
        if belief not in chosen:
            options.append(belief)
            if len(options) == count:
                break
    return options


def _enumerate(
    ranked: Mapping[str, Sequence[str]], space: BeliefSpace, parameters: QLearning
) -> Iterator[tuple[str, ...]]:
    """Every subset of the policy, shortest first. The next options depend on the last belief and on the set only."""
    queue = deque((start, space.subset([start])) for start in space.start)
    seen = set(queue)
    while queue:
        state, subset = queue.popleft()
        if len(subset) >= parameters.min_beliefs:
            yield subset
        if len(subset) == parameters.max_beliefs:
            continue
        for belief in _options(ranked[state], subset, parameters.alternatives):
            node = (belief, space.subset([*subset, belief]))
            if node not in seen:
                seen.add(node)
                queue.append(node)
