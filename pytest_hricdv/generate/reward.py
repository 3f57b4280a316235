"""Rewards: what adding a belief is worth, judged by the plans that the model then executes.

A reward is a new object for each round of learning; it is told when a subset is begun, and asked after each run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from .qlearning import QLearning

#: A coverage plan: its agent and its label.
Plan = tuple[str, str]

#: What one run of the model executed: agent -> plan labels.
Executed = Mapping[str, frozenset[str]]

_WORTH = 100.0


class Reward(Protocol):
    """What learning maximizes."""

    maxima: dict[str, int]
    """The most plans that one run covered, by agent."""

    def begin(self) -> None:
        """A subset is begun: the next run is that of its start belief."""

    def of(self, executed: Executed) -> float:
        """The reward of the belief that was added last, by what the run with it executed."""


class Published:
    """The paper's: the nearer an agent's coverage comes to the most measured so far, the better.

    +100 for at least the maximum, +5 for one plan less, +1 for two less, else -100 (`QLearning.rewards`), added over
    the covered agents. It cannot tell two subsets that cover as many plans, but not the same.
    """

    def __init__(self, parameters: QLearning, suite: Mapping[Plan, int], maxima: Mapping[str, int]) -> None:
        self._parameters = parameters
        self.maxima = dict(maxima)

    def begin(self) -> None:
        """Nothing: each run is judged by itself."""

    def of(self, executed: Executed) -> float:
        """See the class."""
        reward = 0.0
        for agent, plans in executed.items():
            maximum = self.maxima.get(agent, 0)
            reward += self._parameters.tier(len(plans), maximum)
            self.maxima[agent] = max(maximum, len(plans))
        return reward


class Uncovered:
    """What the suite gains: plans that few of its tests execute are worth much, those of many hardly anything.

    A plan that n tests of the suite so far execute is worth 100 / (1 + n)**2, a run the sum over its plans, and a
    belief the difference that adding it made. Rewards of a subset then add up to the worth of its last run, whatever
    the order of its beliefs: shaping by a potential (A. Y. Ng, D. Harada, S. Russell: Policy invariance under reward
    transformations, ICML 1999).
    """

    def __init__(self, parameters: QLearning, suite: Mapping[Plan, int], maxima: Mapping[str, int]) -> None:
        self._suite = suite
        self._worth = 0.0
        self.maxima = dict(maxima)

    def begin(self) -> None:
        """The first run of a subset counts from nothing."""
        self._worth = 0.0

    def of(self, executed: Executed) -> float:
        """See the class."""
        worth = 0.0
        for agent, plans in sorted(executed.items()):
            self.maxima[agent] = max(self.maxima.get(agent, 0), len(plans))
            # Sorted: a sum of floats depends on its order, and that of a set on the process.
            worth += sum(_WORTH / (1 + self._suite.get((agent, plan), 0)) ** 2 for plan in sorted(plans))
        gain, self._worth = worth - self._worth, worth
        return gain


#: Makes a reward from the parameters, from how many tests of the suite so far execute each plan, and from the maxima
#: that are known already.
RewardMaker = Callable[["QLearning", Mapping[Plan, int], Mapping[str, int]], Reward]

REWARDS: Mapping[str, RewardMaker] = {"published": Published, "uncovered": Uncovered}

#: Rounds of learning, with a part of the suite made after each: only a reward that looks at the suite needs several.
ROUNDS: Mapping[str, int] = {"published": 1, "uncovered": 10}
