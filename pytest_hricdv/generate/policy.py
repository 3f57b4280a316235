"""The policy learned: the best and the second best belief in each state, and the subsets it leads to.

Paper: the two best beliefs of each state form the policy from which 134 belief subsets came.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from .beliefs import BeliefSpace
from .qlearning import QLearning
from .stream import index, shuffled, stream
from .warm_start import QTable


def rankings(q: QTable, space: BeliefSpace, *seed: int) -> dict[str, tuple[str, ...]]:
    """Each state's beliefs, best first. Equal values are in an order drawn per state, lest the declared one decide."""
    ranked = {}
    for state in space.beliefs:
        drawn = shuffled(stream("policy-ties", *seed, state), list(q[state]))
        ranked[state] = tuple(sorted(drawn, key=lambda belief: -q[state][belief]))
    return ranked


def subsets(
    q: QTable, space: BeliefSpace, parameters: QLearning, count: int, seed: int, number: int = 0
) -> tuple[tuple[str, ...], ...]:
    """Up to `count` distinct belief subsets that the policy leads to, each in the space's order.

    The rule: walks begin with each start belief in turn, draw their size as learning did, and at each step take the
    best or, just as likely, the second best belief in their state that is not yet in the subset (of as many as
    `alternatives` says). Walks go on until there are enough distinct subsets. If a thousand in a row (`patience`) bring
    nothing new, all that the policy leads to are enumerated, shortest first, so that fewer than `count` come back only
    if fewer exist. Each round of learning has a stream of its own.
    """
    key = (seed, number) if number else (seed,)
    ranked = rankings(q, space, *key)
    random = stream("policy-walks", *key)
    found: dict[tuple[str, ...], None] = {}
    fruitless = walks = 0
    while len(found) < count and fruitless < parameters.patience:
        walk = [space.start[walks % len(space.start)]]
        size = parameters.size(random)
        while len(walk) < size and (options := _options(ranked, walk[-1], walk, parameters.alternatives)):
            walk.append(options[index(random, len(options))])
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


def _options(ranked: Mapping[str, Sequence[str]], state: str, chosen: Sequence[str], count: int) -> list[str]:
    """The best, the second best and so on, `count` of them, in a state among those not yet chosen."""
    options: list[str] = []
    for belief in ranked[state]:
        if belief not in chosen:
            options.append(belief)
            if len(options) == count:
                break
    return options


def _enumerate(
    ranked: Mapping[str, Sequence[str]], space: BeliefSpace, parameters: QLearning
) -> Iterator[tuple[str, ...]]:
    """Every subset the policy leads to, shortest first. What follows depends on the last belief and the set only."""
    queue = deque((start, space.subset([start])) for start in space.start)
    seen = set(queue)
    while queue:
        state, subset = queue.popleft()
        if len(subset) >= parameters.min_beliefs:
            yield subset
        if len(subset) == parameters.max_beliefs:
            continue
        for belief in _options(ranked, state, subset, parameters.alternatives):
            node = (belief, space.subset([*subset, belief]))
            if node not in seen:
                seen.add(node)
                queue.append(node)
