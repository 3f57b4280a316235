"""What Q-learning is given: its parameters, and the table or the belief sets that it begins with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from random import Random

from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.reward import REWARDS, ROUNDS
from pytest_hricdv.generate.rng import random_index
from pytest_hricdv.suggestion import nearest

#: State -> belief added next -> value.
QTable = dict[str, dict[str, float]]


@dataclass(frozen=True)
class QLearning:
    """The parameters; the defaults are those of the paper.

    Args:
        reward: name of the reward: `published`, or `uncovered` for plans that the suite does not cover yet.
        gamma: discount of the next state's value.
        alpha0: learning rate of the first iteration.
        alpha_decay: alpha in iteration j = 0, 1, ... is alpha0 * alpha_decay**j.
        temperature_kt: kT of the Boltzmann choice: the higher, the more exploration.
        rewards: for coverage equal to the maximum measured so far or above it, one plan less, two less, and so on.
        reward_otherwise: for coverage still lower.
        min_beliefs: smallest subset; its size is drawn anew in every iteration, each size equally likely.
        max_beliefs: largest subset.
        iterations: most iterations of a round.
        model_runs: most runs of the model in learning, of all rounds together; the last iteration may be cut short.
            0: no limit.
        rounds: how often learning starts again; each round's policy gives a part of the suite. 0: as many as the reward
            needs, which is 1 for `published` and 10 for `uncovered`.
        tolerance: an iteration is quiet if no cell of Q changes by more than this.
        quiet_iterations: learning has converged after so many quiet iterations in a row. One is not enough: the
            rewards of two agents can cancel in a short iteration, which then changes nothing.
        stop_when_converged: stop then; otherwise do all iterations, as for the paper's figure.
        suite_size: tests of the suite made from the policy.
        candidates: subsets taken from the policy per test of the suite; greedy selection chooses among them.
        alternatives: beliefs of each state that the policy follows: the best and the second best.
        patience: walks in a row without a new subset, after which the subsets of the policy are enumerated.

    Raises:
        GenerateError: a parameter out of range.
    """

    reward: str = "published"
    gamma: float = 0.1
    alpha0: float = 0.1
    alpha_decay: float = 0.9
    temperature_kt: float = 10.0
    rewards: tuple[float, ...] = (100.0, 5.0, 1.0)
    reward_otherwise: float = -100.0
    min_beliefs: int = 2
    max_beliefs: int = 11
    iterations: int = 1000
    model_runs: int = 0
    rounds: int = 0
    tolerance: float = 1e-4
    quiet_iterations: int = 5
    stop_when_converged: bool = True
    suite_size: int = 134
    candidates: int = 10
    alternatives: int = 2
    patience: int = 1000

    def __post_init__(self) -> None:
        if self.reward not in REWARDS:
            raise GenerateError(f"QLearning: no reward {self.reward!r}{nearest(self.reward, REWARDS)}")
        checks = {
            "gamma": (0.0 <= self.gamma < 1.0, "0 <= gamma < 1"),
            "alpha0": (0.0 < self.alpha0 <= 1.0, "0 < alpha0 <= 1"),
            "alpha_decay": (0.0 < self.alpha_decay <= 1.0, "0 < alpha_decay <= 1"),
            "temperature_kt": (0.0 < self.temperature_kt < math.inf, "a finite number above 0"),
            "rewards": (all(map(math.isfinite, self.rewards)) and bool(self.rewards), "at least one finite number"),
            "reward_otherwise": (math.isfinite(self.reward_otherwise), "a finite number"),
            "min_beliefs": (self.min_beliefs >= 2, "at least 2: a start belief and one to learn about"),
            "max_beliefs": (self.max_beliefs >= self.min_beliefs, "at least min_beliefs"),
            "iterations": (self.iterations >= 1, "at least 1"),
            "tolerance": (0.0 <= self.tolerance < math.inf, "a finite number, at least 0"),
            "quiet_iterations": (self.quiet_iterations >= 1, "at least 1"),
            "suite_size": (self.suite_size >= 1, "at least 1"),
            "model_runs": (self.model_runs >= 0, "at least 0"),
            "rounds": (self.rounds >= 0, "at least 0"),
            "candidates": (self.candidates >= 1, "at least 1"),
            "alternatives": (self.alternatives >= 1, "at least 1"),
            "patience": (self.patience >= 1, "at least 1"),
        }
        for name, (good, expected) in checks.items():
            if not good:
                raise GenerateError(f"QLearning: {name} = {getattr(self, name)!r}; expected {expected}")

    def alpha(self, iteration: int) -> float:
        """The learning rate in iteration 0, 1, ..."""
        return self.alpha0 * self.alpha_decay**iteration

    def tier(self, covered: int, maximum: int) -> float:
        """The published reward for the plans that one agent covered, given the most covered so far."""
        less = max(maximum - covered, 0)
        return self.rewards[less] if less < len(self.rewards) else self.reward_otherwise

    def subset_size(self, rng: Random) -> int:
        """The size of one subset, each equally likely: 6.5 beliefs, and so runs of the model, on average."""
        return self.min_beliefs + random_index(rng, self.max_beliefs - self.min_beliefs + 1)

    def in_rounds(self, tests: int) -> tuple[QLearning, ...]:
        """The parameters of each round, with its share of the model runs and of the tests."""
        count = min(self.rounds or ROUNDS[self.reward], tests, self.model_runs or tests)

        def share(whole: int, number: int) -> int:
            return whole * (number + 1) // count - whole * number // count

        return tuple(
            replace(
                self,
                model_runs=share(self.model_runs, number),
                suite_size=share(tests, number),
            )
            for number in range(count)
        )


@dataclass(frozen=True)
class WarmStart:
    """A table or belief sets that learning begins with (the paper's future work).

    Args:
        name: for people.
        digest: hash of the content; learning is a function of it, too.
        q: a table learned before; empty for none.
        maxima: the most plans covered in one run so far, by agent.
        subsets: belief sets to run first, each with its start belief in front and at least one other belief.
    """

    name: str = ""
    digest: str = ""
    q: QTable = field(default_factory=dict, hash=False)
    maxima: Mapping[str, int] = field(default_factory=dict, hash=False)
    subsets: tuple[tuple[str, ...], ...] = ()


COLD_START = WarmStart()
