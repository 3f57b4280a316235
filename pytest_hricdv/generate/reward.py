"""Rewards of learning: the value of adding a belief, from the plans that the model then executes.

Each round of learning has a new reward object. It is called when a subset is begun and after each run of the model.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

#: A coverage plan: its agent and its label.
Plan = tuple[str, str]

#: What one run of the model executed: agent -> plan labels.
Executed = Mapping[str, frozenset[str]]

#: The reward for the plans that an agent covered: (covered, the most covered so far) -> reward.
Tier = Callable[[int, int], float]

_VALUE_OF_NEW_PLAN = 100.0


class Reward(Protocol):
    """The quantity that learning maximizes."""

    maxima: dict[str, int]
    """The most plans that one run covered, by agent."""

    def begin(self) -> None:
        """Called when a subset is begun: the next run is that of its start belief."""

    def of(self, executed: Executed) -> float:
        """The reward of the belief that was added last, from the plans that the run with it executed."""


class Published:
    """The paper's reward: the nearer an agent's coverage comes to the most measured so far, the higher.

    +100 for at least the maximum, +5 for one plan less, +1 for two less, else -100 (`QLearning.rewards`), added over
    the covered agents. It does not distinguish subsets that cover equally many, but different plans.
    """

    def __init__(self, tier: Tier, suite: Mapping[Plan, int], maxima: Mapping[str, int]) -> None:
        self._tier = tier
        self.maxima = dict(maxima)

    def begin(self) -> None:
        """Does nothing: the reward of a run does not depend on the runs before."""

    def of(self, executed: Executed) -> float:
        """See the class."""
        reward = 0.0
        for agent, plans in executed.items():
            maximum = self.maxima.get(agent, 0)
            reward += self._tier(len(plans), maximum)
            self.maxima[agent] = max(maximum, len(plans))
        return reward


class Uncovered:
    """The gain for the suite: plans that few of its tests execute have a high value, plans of many tests a low one.

    A plan that n tests of the suite so far execute has the value 100 / (1 + n)**2. A run has the sum over its plans,
    and a belief the difference that adding it made. So the rewards of a subset add up to the value of its last run,
    whatever the order of its beliefs: potential-based shaping (A. Y. Ng, D. Harada, S. Russell: Policy invariance
    under reward transformations, ICML 1999).
    """

    def __init__(self, tier: Tier, suite: Mapping[Plan, int], maxima: Mapping[str, int]) -> None:
        self._suite = suite
        self._value = 0.0
        self.maxima = dict(maxima)

    def begin(self) -> None:
        """The value before the first run of a subset is 0."""
        self._value = 0.0

    def of(self, executed: Executed) -> float:
        """See the class."""
        value = 0.0
        for agent, plans in sorted(executed.items()):
            self.maxima[agent] = max(self.maxima.get(agent, 0), len(plans))
            # Sorted: a sum of floats depends on the order, and the order of a set differs between processes.
            value += sum(_VALUE_OF_NEW_PLAN / (1 + self._suite.get((agent, plan), 0)) ** 2 for plan in sorted(plans))
        gain, self._value = value - self._value, value
        return gain


#: Makes a reward from the tiers of the published one, from how many tests of the suite so far execute each plan, and
#: from the maxima that are known already.
RewardFactory = Callable[[Tier, Mapping[Plan, int], Mapping[str, int]], Reward]

REWARDS: Mapping[str, RewardFactory] = {"published": Published, "uncovered": Uncovered}

#: Rounds of learning; each adds a part of the suite. Only a reward that depends on the suite needs several.
ROUNDS: Mapping[str, int] = {"published": 1, "uncovered": 10}
