"""Selection: which of many explorations become the tests of a suite."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from .exploration import Exploration
from .reward import Plan


@dataclass
class Balance:
    """Chooses tests so that each plan of the model is executed by about as many of them; remembers what it chose.

    The next one is always one that executes the plan executed least so far, rather with a text that is new, rather an
    earlier one. Without this a suite has dozens of tests of what is common and hardly one of what is rare.
    """

    executed: Counter[Plan] = field(default_factory=Counter)
    """How many of the tests chosen so far execute each plan."""
    chosen: list[Exploration] = field(default_factory=list)

    def choose(self, explorations: Iterable[Exploration], count: int) -> None:
        """Choose up to `count` more, of these."""
        candidates = list(explorations)
        plans = [[(agent, plan) for agent, own in each.plans.items() for plan in own] for each in candidates]
        texts = {each.lines for each in self.chosen}
        left = list(range(len(candidates)))

        def order(place: int) -> tuple[float, bool, int]:
            rarest = min((self.executed[plan] for plan in plans[place]), default=math.inf)
            return rarest, candidates[place].lines in texts, place

        for _ in range(min(count, len(left))):
            place = min(left, key=order)
            left.remove(place)
            self.chosen.append(candidates[place])
            texts.add(candidates[place].lines)
            self.executed.update(plans[place])


def balanced(explorations: Iterable[Exploration], count: int) -> tuple[Exploration, ...]:
    """Up to `count` of the explorations, chosen as `Balance` does."""
    balance = Balance()
    balance.choose(explorations, count)
    return tuple(balance.chosen)
