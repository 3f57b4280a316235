"""Q-learning of belief subsets that cover much of the model.

Paper: section on reinforcement learning for the BDI agents. The action is the belief added next, the state is the
belief added last, and Q(p, b) = (1 - alpha) Q(p, b) + alpha [r + gamma max_b' Q(p', b')].
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from .beliefs import BeliefSpace
from .error import GenerateError, nearest
from .exploration import Explores
from .reward import REWARDS, ROUNDS, Plan, Reward
from .stream import index, pick, shuffled, stream
from .warm_start import COLD, QTable, WarmStart


@dataclass(frozen=True)
class QLearning:
    """The parameters; the defaults are those of the paper.

    Args:
        reward: what is rewarded: `published`, or `uncovered`, what the suite has not covered yet (see `reward`).
        gamma: discount of the next state's value.
        alpha0: learning rate of the first iteration.
        alpha_decay: alpha in iteration j = 0, 1, ... is alpha0 * alpha_decay**j.
        temperature_kt: kT of the Boltzmann choice: the higher, the more is explored.
        rewards: for coverage equal to the maximum measured so far or above it, one plan less, two less, and so on.
        reward_otherwise: for coverage still lower.
        min_beliefs: smallest subset; its size is drawn anew in every iteration, each size equally likely.
        max_beliefs: largest subset.
        iterations: most iterations of a round.
        model_runs: most runs of the model in learning, of all rounds together; the last iteration is cut short, so that
            it is that many to the run. 0: no limit.
        rounds: learning begins anew so many times, and each round's policy makes its part of the suite. 0: as many as
            the reward needs, which is 1 for `published` and 10 for `uncovered`.
        tolerance: an iteration is quiet if no cell of Q changes by more than this.
        quiet_iterations: learning has converged after so many quiet iterations in a row. One is not enough: rewards
            of two agents can cancel, and a short iteration then changes nothing although learning has only begun.
        stop_when_converged: stop then; otherwise run all iterations, as for the paper's figure.
        suite_size: tests of the suite made from the policy.
        candidates: subsets taken from the policy per test of the suite; the suite has those that balance the plans.
        alternatives: beliefs of each state that the policy follows: the best and the second best.
        patience: fruitless walks in a row after which the subsets that the policy leads to are enumerated instead.

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
        """The published reward for one agent's coverage, in plans, against the maximum measured so far."""
        less = max(maximum - covered, 0)
        return self.rewards[less] if less < len(self.rewards) else self.reward_otherwise

    def size(self, random: Random) -> int:
        """The size of one subset, each equally likely: 6.5 beliefs, and so runs of the model, on average."""
        return self.min_beliefs + index(random, self.max_beliefs - self.min_beliefs + 1)

    def in_rounds(self, tests: int) -> tuple[QLearning, ...]:
        """The parameters of each round, in which model runs and tests have their share."""
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
class Learned:
    """The outcome of learning.

    Args:
        q: the table.
        q_delta: the largest change of a cell in each iteration.
        converged_at: the first iteration (from 1) of the quiet ones in a row, or None.
        iterations: iterations done.
        bdi_runs: runs of the model.
        maxima: the most plans covered in one run, by agent.
        news_at: the last iteration (from 1) in which a plan was executed that no run before, and no test of the suite
            so far, had executed; 0 if in none.
    """

    q: QTable = field(hash=False)
    q_delta: tuple[float, ...]
    converged_at: int | None
    iterations: int
    bdi_runs: int
    maxima: Mapping[str, int] = field(hash=False)
    news_at: int


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


def learn(
    explorer: Explores,
    space: BeliefSpace,
    parameters: QLearning,
    seed: int,
    *,
    number: int = 0,
    suite: Mapping[Plan, int] | None = None,
    start: WarmStart = COLD,
) -> Learned:
    """Learn which belief to add next.

    An iteration draws a start belief and a size, then adds beliefs by Boltzmann choice; the model runs after each.
    The start belief's run has no cell of Q: it is drawn, not chosen; but it counts towards the maxima. Belief sets that
    learning begins with are gone through first, at the first iteration's learning rate and without being counted.

    Args:
        number: of the round; each has a stream of its own.
        suite: how many tests of the suite so far execute each plan.
        start: the table, or the belief sets, to begin with.

    Raises:
        GenerateError: the space has no belief to add.
    """
    if not space.others:
        raise GenerateError("the belief space has start beliefs only; expected others to choose from")
    key = ("qlearning", seed, number) if number else ("qlearning", seed)
    reward = REWARDS[parameters.reward](parameters, suite or {}, start.maxima)
    learner = _Learner(explorer, space, parameters, stream(*key), reward)
    learner.seen.update(suite or {})
    learner.begin_with(start, stream("qlearning-start", *key[1:]))
    deltas: list[float] = []
    converged_at: int | None = None
    news_at = 0
    for iteration in range(parameters.iterations):
        known = len(learner.seen)
        deltas.append(learner.iterate(iteration))
        news_at = iteration + 1 if len(learner.seen) > known else news_at
        last = deltas[-parameters.quiet_iterations :]
        if converged_at is None and len(last) == parameters.quiet_iterations and max(last) <= parameters.tolerance:
            converged_at = len(deltas) - len(last) + 1
        if learner.spent or (converged_at is not None and parameters.stop_when_converged):
            break
    done = (tuple(deltas), converged_at, len(deltas), learner.runs)
    return Learned(learner.q, *done, maxima=dict(learner.reward.maxima), news_at=news_at)


class _Learner:
    """What changes while learning: the table, the reward, what was seen, and the stream."""

    def __init__(
        self, explorer: Explores, space: BeliefSpace, parameters: QLearning, random: Random, reward: Reward
    ) -> None:
        self.explorer = explorer
        self.space = space
        self.parameters = parameters
        self.random = random
        self.reward = reward
        self.q: QTable = {state: {belief: 0.0 for belief in space.others if belief != state} for state in space.beliefs}
        self.seen: set[Plan] = set()
        self.runs = 0
        self._before = 0

    @property
    def spent(self) -> bool:
        """Whether there are no runs of the model left."""
        return 0 < self.parameters.model_runs <= self.runs - self._before

    def begin_with(self, start: WarmStart, random: Random) -> None:
        """Take a table over; go through belief sets, each in an order of its own."""
        for state, row in start.q.items():
            self.q[state].update(row)
        for subset in start.subsets:
            state, others = subset[0], shuffled(random, subset[1:])
            options = list(self.space.others)
            self.reward.begin()
            self._run(grown := [state])
            for belief in others:
                options.remove(belief)
                grown.append(belief)
                self._update(state, belief, self.parameters.alpha0, self._run(grown), options)
                state = belief
        self._before = self.runs

    def iterate(self, iteration: int) -> float:
        """One iteration; the largest change of a cell."""
        alpha = self.parameters.alpha(iteration)
        state = pick(self.random, self.space.start)
        size = self.parameters.size(self.random)
        subset = [state]
        self.reward.begin()
        self._run(subset)
        options = list(self.space.others)
        largest = 0.0
        while len(subset) < size and options and not self.spent:
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
        """Run the model; the reward of the belief added last."""
        self.runs += 1
        executed = self.explorer.explore(subset).plans
        self.seen.update((agent, plan) for agent, plans in executed.items() for plan in plans)
        return self.reward.of(executed)
