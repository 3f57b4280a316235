"""`learn` runs Q-learning, to find belief subsets with which the model executes many of its plans.

Its result is a table Q, from which `policy_subsets` takes the subsets of the suite; `ReinforcementLearning` calls both.
Paper: section on reinforcement learning for the BDI agents. The action is the belief added next, the state is the
belief added last, and Q(p, b) = (1 - alpha) Q(p, b) + alpha [r + gamma max_b' Q(p', b')]. The two best beliefs of each
state form the policy, which gave the paper's 134 belief subsets.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Protocol

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import ModelRun
from pytest_hricdv.generate.qlearning import COLD_START, REWARDS, Plan, QLearning, QTable, RewardFunction, WarmStart
from pytest_hricdv.generate.rng import make_rng, pick, random_index, shuffle


class SubsetRunner(Protocol):
    """Runs a model with belief subsets, as `ModelRunner` does."""

    def run(self, beliefs: Iterable[str]) -> ModelRun:
        """Run the model with one subset."""


@dataclass(frozen=True)
class LearningResult:
    """The outcome of learning.

    Args:
        q: the table.
        q_delta: the largest change of a cell in each iteration.
        converged_at: the first (from 1) of the iterations in which Q hardly changed any more; None if there was none.
        maxima: the most plans covered in one run, by agent.
        last_new_plan_at: the last iteration (from 1) that executed a plan which neither an earlier run nor a test of
            the suite had executed; 0 if none did.
    """

    q: QTable = field(hash=False)
    q_delta: tuple[float, ...]
    converged_at: int | None
    iterations: int
    bdi_runs: int
    maxima: Mapping[str, int] = field(hash=False)
    last_new_plan_at: int


def softmax(values: Sequence[float], temperature_kt: float) -> list[float]:
    """Boltzmann probabilities exp(v / kT) / sum; the largest value is subtracted first, which avoids overflow."""
    highest = max(values)
    weights = [math.exp((value - highest) / temperature_kt) for value in values]
    total = math.fsum(weights)  # exact, so that the order of the values has no effect on the last digit
    return [weight / total for weight in weights]


def boltzmann_choice(rng: Random, choices: Sequence[str], row: Mapping[str, float], temperature_kt: float) -> str:
    """One of the choices, by the Boltzmann probabilities of their values."""
    mark = rng.random()
    for choice, probability in zip(choices, softmax([row[option] for option in choices], temperature_kt), strict=True):
        mark -= probability
        if mark < 0.0:
            return choice
    return choices[-1]  # rounded probabilities can add up to a little less than the mark


def learn(
    runner: SubsetRunner,
    space: BeliefSpace,
    parameters: QLearning,
    seed: int,
    *,
    round_number: int = 0,
    suite: Mapping[Plan, int] | None = None,
    start: WarmStart = COLD_START,
    tell: Callable[[str], None] = lambda text: None,
) -> LearningResult:
    """Learn which belief to add next.

    An iteration draws a start belief and a size, then adds beliefs by Boltzmann choice; the model runs after each.
    The start belief has no cell of Q, as it is drawn and not chosen, but its run counts towards the maxima. The belief
    sets of a warm start are run first, at the first iteration's learning rate; they do not count as iterations.

    Args:
        round_number: from 0; each round has its own random stream.
        suite: how many tests of the suite so far execute each plan.
        start: the table or the belief sets to begin with.

    Raises:
        GenerateError: the space has no belief to add.
    """
    if not space.others:
        raise GenerateError("the belief space has start beliefs only; expected others to choose from")
    # The first round has no number in its key: learning in one round is the same as before there were several.
    key = ("qlearning", seed, round_number) if round_number else ("qlearning", seed)
    reward = REWARDS[parameters.reward](parameters.tier, suite or {}, start.maxima)
    learner = _Learner(runner, space, parameters, make_rng(*key), reward)
    learner.seen.update(suite or {})
    learner.begin_with(start, make_rng("qlearning-start", *key[1:]))
    deltas: list[float] = []
    converged_at: int | None = None
    last_new_plan_at = 0
    for iteration in range(parameters.iterations):
        tell(f"iteration {iteration + 1} of {parameters.iterations}, {learner.runs} model runs")
        seen_before = len(learner.seen)
        deltas.append(learner.iterate(iteration))
        last_new_plan_at = iteration + 1 if len(learner.seen) > seen_before else last_new_plan_at
        last = deltas[-parameters.quiet_iterations :]
        if converged_at is None and len(last) == parameters.quiet_iterations and max(last) <= parameters.tolerance:
            converged_at = len(deltas) - len(last) + 1
        if learner.out_of_runs or (converged_at is not None and parameters.stop_when_converged):
            break
    done = (tuple(deltas), converged_at, len(deltas), learner.runs)
    return LearningResult(learner.q, *done, dict(learner.reward.maxima), last_new_plan_at)


class _Learner:
    """The state of learning: the table, the reward, the plans seen, and the random stream."""

    def __init__(
        self, runner: SubsetRunner, space: BeliefSpace, parameters: QLearning, rng: Random, reward: RewardFunction
    ) -> None:
        self.runner = runner
        self.space = space
        self.parameters = parameters
        self.rng = rng
        self.reward = reward
        self.q: QTable = {state: {belief: 0.0 for belief in space.others if belief != state} for state in space.beliefs}
        self.seen: set[Plan] = set()
        self.runs = 0
        self._runs_of_start = 0

    @property
    def out_of_runs(self) -> bool:
        """Whether the limit of model runs is reached; the runs of a warm start do not count."""
        return 0 < self.parameters.model_runs <= self.runs - self._runs_of_start

    def begin_with(self, start: WarmStart, rng: Random) -> None:
        """Copy a table; run belief sets, each in a random order."""
        for state, row in start.q.items():
            self.q[state].update(row)
        for subset in start.subsets:
            state, others = subset[0], shuffle(rng, subset[1:])
            options = list(self.space.others)
            self.reward.begin()
            self._run(grown := [state])
            for belief in others:
                options.remove(belief)
                grown.append(belief)
                self._update(state, belief, self.parameters.alpha0, self._run(grown), options)
                state = belief
        self._runs_of_start = self.runs

    def iterate(self, iteration: int) -> float:
        """Do one iteration; returns the largest change of a cell."""
        alpha = self.parameters.alpha(iteration)
        state = pick(self.rng, self.space.start)
        size = self.parameters.subset_size(self.rng)
        subset = [state]
        self.reward.begin()
        self._run(subset)
        options = list(self.space.others)
        largest = 0.0
        while len(subset) < size and options and not self.out_of_runs:
            belief = boltzmann_choice(self.rng, options, self.q[state], self.parameters.temperature_kt)
            options.remove(belief)
            subset.append(belief)
            reward = self._run(subset)
            largest = max(largest, self._update(state, belief, alpha, reward, options))
            state = belief
        return largest

    def _update(self, state: str, belief: str, alpha: float, reward: float, options: Sequence[str]) -> float:
        """Update one cell; returns its change. `options` are the beliefs that can still be added in the next state."""
        # 0 where nothing can be added any more: a subset that is full has no next state, and cells begin at 0.
        best_next = max((self.q[belief][option] for option in options), default=0.0)
        old = self.q[state][belief]
        new = (1.0 - alpha) * old + alpha * (reward + self.parameters.gamma * best_next)
        self.q[state][belief] = new
        return abs(new - old)

    def _run(self, subset: Sequence[str]) -> float:
        """Run the model; returns the reward of the belief added last."""
        self.runs += 1
        executed = self.runner.run(subset).plans
        self.seen.update((agent, plan) for agent, plans in executed.items() for plan in plans)
        return self.reward.of(executed)


def rankings(q: QTable, space: BeliefSpace, *seed: int) -> dict[str, tuple[str, ...]]:
    """The beliefs of each state, best first. Ties are broken at random, so that the declared order has no effect."""
    ranked = {}
    for state in space.beliefs:
        drawn = shuffle(make_rng("policy-ties", *seed, state), list(q[state]))
        ranked[state] = tuple(sorted(drawn, key=lambda belief: -q[state][belief]))
    return ranked


def policy_subsets(
    q: QTable, space: BeliefSpace, parameters: QLearning, count: int, seed: int, round_number: int = 0
) -> tuple[tuple[str, ...], ...]:
    """At most `count` distinct belief subsets that the policy leads to, each in the space's order.

    The rule: walks begin with each start belief in turn and draw their size as learning did. Each step takes one of
    the best beliefs in the current state that are not yet in the subset, each equally likely; how many of the best is
    `alternatives` (2: the best or the second best). Walks continue until there are enough distinct subsets. After
    `patience` walks in a row without a new subset, all subsets of the policy are enumerated, shortest first. So fewer
    than `count` are returned only if fewer exist. Each round of learning has its own random stream.
    """
    key = (seed, round_number) if round_number else (seed,)  # as in `learn`
    ranked = rankings(q, space, *key)
    rng = make_rng("policy-walks", *key)
    subsets: dict[tuple[str, ...], None] = {}
    fruitless = walks = 0
    while len(subsets) < count and fruitless < parameters.patience:
        # In turn, not drawn, so that each start belief has its share even in a small suite.
        walk = [space.start[walks % len(space.start)]]
        size = parameters.subset_size(rng)
        while len(walk) < size and (options := _options(ranked[walk[-1]], walk, parameters.alternatives)):
            walk.append(options[random_index(rng, len(options))])
        subset = space.subset(walk)
        fruitless = fruitless + 1 if subset in subsets else 0
        subsets[subset] = None
        walks += 1
    if len(subsets) < count:
        for subset in _enumerate(ranked, space, parameters):
            subsets[subset] = None
            if len(subsets) == count:
                break
    return tuple(subsets)


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
