"""Selection: which of many explorations become the tests of a suite."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable

from .exploration import Exploration


def balanced(explorations: Iterable[Exploration], count: int) -> tuple[Exploration, ...]:
    """Up to `count` of the explorations, chosen so that each plan of the model is executed by about as many tests.

    The next one is always one that executes the plan executed least so far, rather with a text that is new, rather an
    earlier one. Without this a suite has dozens of tests of what is common and hardly one of what is rare.
    """
    candidates = list(explorations)
    plans = [[(agent, plan) for agent, own in each.plans.items() for plan in own] for each in candidates]
    executed: Counter[tuple[str, str]] = Counter()
    texts: set[tuple[str, ...]] = set()
    left = list(range(len(candidates)))
    chosen: list[Exploration] = []

    def order(place: int) -> tuple[float, bool, int]:
        rarest = min((executed[plan] for plan in plans[place]), default=math.inf)
        return rarest, candidates[place].lines in texts, place

    while left and len(chosen) < count:
        place = min(left, key=order)
        left.remove(place)
        chosen.append(candidates[place])
        texts.add(candidates[place].lines)
        executed.update(plans[place])
    return tuple(chosen)
