"""Q-learning of belief subsets that cover much of the model.

Paper: section on reinforcement learning for the BDI agents. The action is the belief added next, the state is the
belief added last, and Q(p, b) = (1 - alpha) Q(p, b) + alpha [r + gamma max_b' Q(p', b')].
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from random import Random

from .beliefs import BeliefSpace
from .error import GenerateError
from .exploration import Explores
from .stream import index, pick, stream

#: State -> belief added next -> value.
QTable = dict[str, dict[str, float]]


@dataclass(frozen=True)
class QLearning:
    """The parameters; the defaults are those of the paper.

    Args:
        gamma: discount of the next state's value.
        alpha0: learning rate of the first iteration.
        alpha_decay: alpha in iteration j = 0, 1, ... is alpha0 * alpha_decay**j.
        temperature_kt: kT of the Boltzmann choice: the higher, the more is explored.
        rewards: for coverage equal to the maximum measured so far or above it, one plan less, two less, and so on.
        reward_otherwise: for coverage still lower.
        min_beliefs: smallest subset; its size is drawn anew in every iteration, each size equally likely.
        max_beliefs: largest subset.
        iterations: most iterations.
        tolerance: an iteration is quiet if no cell of Q changes by more than this.
        quiet_iterations: learning has converged after so many quiet iterations in a row. One is not enough: rewards
            of two agents can cancel, and a short iteration then changes nothing although learning has only begun.
        stop_when_converged: stop then; otherwise run all iterations, as for the paper's figure.
        suite_size: tests of the suite made from the policy.
        candidates: subsets taken from the policy per test of the suite; the suite has those that balance the plans.

    Raises:
        GenerateError: a parameter out of range.
    """

    gamma: float = 0.1
    alpha0: float = 0.1
    alpha_decay: float = 0.9
    temperature_kt: float = 10.0
    rewards: tuple[float, ...] = (100.0, 5.0, 1.0)
    reward_otherwise: float = -100.0
    min_beliefs: int = 2
    max_beliefs: int = 11
    iterations: int = 1000
    tolerance: float = 1e-4
    quiet_iterations: int = 5
    stop_when_converged: bool = True
    suite_size: int = 134
    candidates: int = 10

    def __post_init__(self) -> None:
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
            "candidates": (self.candidates >= 1, "at least 1"),
        }
        for name, (good, expected) in checks.items():
            if not good:
                raise GenerateError(f"QLearning: {name} = {getattr(self, name)!r}; expected {expected}")

    def alpha(self, iteration: int) -> float:
        """The learning rate in iteration 0, 1, ..."""
        return self.alpha0 * self.alpha_decay**iteration

    def reward(self, covered: int, maximum: int) -> float:
        """The reward for one agent's coverage, in plans, against the maximum measured so far."""
        less = max(maximum - covered, 0)
        return self.rewards[less] if less < len(self.rewards) else self.reward_otherwise

    def size(self, random: Random) -> int:
        """The size of one subset, each equally likely: 6.5 beliefs, and so runs of the model, on average."""
        return self.min_beliefs + index(random, self.max_beliefs - self.min_beliefs + 1)


@dataclass(frozen=True)
class Learned:
    """The outcome of learning.

    Args:
        q: the table.
        q_delta: the largest change of a cell in each iteration.
        converged_at: the first iteration (from 1) of the quiet ones in a row, or None.
        iterations: iterations done.
        bdi_runs: runs of the model.
        maxima: the most plans covered in one run, by agent.
    """

    q: QTable = field(hash=False)
    q_delta: tuple[float, ...]
    converged_at: int | None
    iterations: int
    bdi_runs: int
    maxima: Mapping[str, int] = field(hash=False)


def softmax(values: Sequence[float], temperature_kt: float) -> list[float]:
    """Boltzmann probabilities exp(v / kT) / sum, without overflow: the largest value is taken out first."""
    highest = max(values)
    weights = [math.exp((value - highest) / temperature_kt) for value in values]
    total = math.fsum(weights)
    return [weight / total for weight in weights]


def boltzmann(random: Random, choices: Sequence[str], row: Mapping[str, float], temperature_kt: float) -> str:
    """One of the choices, by the Boltzmann probabilities of their values."""
    mark = random.random()
    for choice, probability in zip(choices, softmax([row[each] for each in choices], temperature_kt), strict=True):
        mark -= probability
        if mark < 0.0:
            return choice
    return choices[-1]


def learn(explorer: Explores, space: BeliefSpace, parameters: QLearning, seed: int) -> Learned:
    """Learn which belief to add next.

    An iteration draws a start belief and a size, then adds beliefs by Boltzmann choice; the model runs after each.
    The start belief's run has no cell of Q: it is drawn, not chosen; but it counts towards the maxima.

    Raises:
        GenerateError: the space has no belief to add.
    """
    if not space.others:
        raise GenerateError("the belief space has start beliefs only; expected others to choose from")
    learner = _Learner(explorer, space, parameters, stream("qlearning", seed))
    deltas: list[float] = []
    converged_at: int | None = None
    for iteration in range(parameters.iterations):
        deltas.append(learner.iterate(iteration))
        last = deltas[-parameters.quiet_iterations :]
        if converged_at is None and len(last) == parameters.quiet_iterations and max(last) <= parameters.tolerance:
            converged_at = len(deltas) - len(last) + 1
        if converged_at is not None and parameters.stop_when_converged:
            break
    return Learned(learner.q, tuple(deltas), converged_at, len(deltas), learner.runs, dict(learner.maxima))


class _Learner:
    """What changes while learning: the table, the maxima and the stream."""

    def __init__(self, explorer: Explores, space: BeliefSpace, parameters: QLearning, random: Random) -> None:
        self.explorer = explorer
        self.space = space
        self.parameters = parameters
        self.random = random
        self.q: QTable = {state: {belief: 0.0 for belief in space.others if belief != state} for state in space.beliefs}
        self.maxima: dict[str, int] = {}
        self.runs = 0

    def iterate(self, iteration: int) -> float:
        """One iteration; the largest change of a cell."""
        alpha = self.parameters.alpha(iteration)
        state = pick(self.random, self.space.start)
        size = self.parameters.size(self.random)
        subset = [state]
        self._run(subset)
        options = list(self.space.others)
        largest = 0.0
        while len(subset) < size and options:
            belief = boltzmann(self.random, options, self.q[state], self.parameters.temperature_kt)
            options.remove(belief)
            subset.append(belief)
            reward = self._run(subset)
            largest = max(largest, self._update(state, belief, alpha, reward, options))
            state = belief
        return largest

    def _update(self, state: str, belief: str, alpha: float, reward: float, options: Sequence[str]) -> float:
        """Update one cell; its change. The next state's best is over the beliefs that can still be added."""
        best_next = max((self.q[belief][option] for option in options), default=0.0)
        old = self.q[state][belief]
        new = (1.0 - alpha) * old + alpha * (reward + self.parameters.gamma * best_next)
        self.q[state][belief] = new
        return abs(new - old)

    def _run(self, subset: Sequence[str]) -> float:
        """Run the model; the reward, added over the covered agents."""
        self.runs += 1
        reward = 0.0
        for agent, plans in self.explorer.explore(subset).plans.items():
            maximum = self.maxima.get(agent, 0)
            reward += self.parameters.reward(len(plans), maximum)
            self.maxima[agent] = max(maximum, len(plans))
        return reward
