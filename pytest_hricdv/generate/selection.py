"""Greedy selection: which of many model runs become the tests of a suite."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from pytest_hricdv.generate.model import ModelRun
from pytest_hricdv.generate.reward import Plan


@dataclass
class GreedySelector:
    """Chooses tests so that each plan of the model is executed by about as many of them.

    The next test always executes the plan that the chosen tests execute least. Among equals a test with a new text
    goes first, then the earlier one. Without this a suite has dozens of tests of common plans and few of rare ones.
    """

    executed: Counter[Plan] = field(default_factory=Counter)
    """How many of the chosen tests execute each plan."""
    chosen: list[ModelRun] = field(default_factory=list)

    def choose(self, runs: Iterable[ModelRun], count: int) -> None:
        """Choose up to `count` more, of these.

        A heap with lazy updates: choosing a test can only move the others back in the order. So the first entry whose
        rank is still the one it was queued with comes before all others.
        """
        candidates = list(runs)
        plans = [[(agent, plan) for agent, own in each.plans.items() for plan in own] for each in candidates]
        texts = {each.lines for each in self.chosen}

        def rank(place: int) -> tuple[float, bool, int]:
            rarest = min([self.executed[plan] for plan in plans[place]], default=math.inf)
            return rarest, candidates[place].lines in texts, place

        wanted = len(self.chosen) + min(count, len(candidates))
        queue = [rank(place) for place in range(len(candidates))]
        heapq.heapify(queue)
        while len(self.chosen) < wanted:
            queued = queue[0]
            place = queued[-1]
            now = rank(place)
            if now != queued:
                heapq.heapreplace(queue, now)
                continue
            heapq.heappop(queue)
            self.chosen.append(candidates[place])
            texts.add(candidates[place].lines)
            self.executed.update(plans[place])
