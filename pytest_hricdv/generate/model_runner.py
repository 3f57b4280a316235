"""`ModelRunner` runs a model with belief sets; the external actions of its actors in a run are an abstract test.

The generation methods run it with the sets that they select. `coverage.reachability` gets all runs of a model from
`explore_exhaustively`, or, where there are too many, runs of randomly drawn sets from `explore_by_sampling`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from random import Random

from pytest_hricdv._base.message import nearest
from pytest_hricdv.bdi import BdiError, Environment, MultiAgentSystem, TooLargeError
from pytest_hricdv.bdi.language.syntax_tree import functors_of
from pytest_hricdv.bdi.memo import Memo
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import Plans, command_from_action
from pytest_hricdv.generate.actors import After
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.causes import causes
from pytest_hricdv.generate.model import Exploration, ExploredRun, Model, ModelRun
from pytest_hricdv.generate.rng import make_rng, pick

Content = tuple[tuple[str, ...], int]
"""The lines of a run's abstract test, and the executed plans as a bit set."""

MAX_OTHERS = 9
"""Maximum number of beliefs besides the start beliefs in a space that is explored set by set: 512 runs for each start
belief."""
TOO_LARGE = "too large: the model has too many different runs"
NOT_ENUMERABLE = "too large: {} beliefs besides the start beliefs, of which more than {} cannot be tried in all sets"
"""Followed by the reason why the memo cannot enumerate the runs (`Memo.obstacle`)."""

_ROUND_LIMIT = "round limit"
"""`Result.ended` of a run that the BDI engine stopped after `max_rounds`."""

_MOST_NAMED = 3
"""Maximum number of endless plans that the notes of a suite name."""
_REMEDY = "let it end, as by a plan with a context before it"


class ModelRunner:
    """Runs a model with any number of belief sets, called subsets of the belief space.

    The percepts of a subset are always in the space's order, so that a set of beliefs has exactly one run. Every run
    starts from the agents' initial beliefs and the model's own seed.

    Args:
        model: the agents.
        space: the beliefs they are steered with.

    Raises:
        GenerateError: the model cannot be loaded; it lacks an agent or a coverage plan; a belief of the space does not
            occur in the actor's program, so that choosing it cannot change a test, and is not a default belief.
    """

    def __init__(self, model: Model, space: BeliefSpace) -> None:
        self.model = model
        self.space = space
        self.run_count = 0
        self._cut_off_count = 0
        self._has_acted = False
        self._endless: Counter[str] = Counter()
        self._memo = _load(model.path, model.sha256())
        self._system = self._memo.system
        self._check_agents()
        self.plan_labels: Plans = {agent: tuple(self._system.plan_labels(agent)) for agent in model.covered}
        self._coverage_plans = {agent: frozenset(labels) for agent, labels in self.plan_labels.items()}
        for agent, labels in self.plan_labels.items():
            if not labels:
                raise GenerateError(f"{model.path}: agent {agent!r} has no labelled plan; expected some to cover")
        self._check_beliefs()

    def _check_agents(self) -> None:
        for agent in (self.model.steering_agent, *self.model.who_acts, *self.model.covered):
            if agent not in self._system.agents:
                hint = nearest(agent, self._system.agents)
                raise GenerateError(f"{self.model.path}: no agent {agent!r} in this model{hint}")

    def _check_beliefs(self) -> None:
        actors = self.model.who_acts
        mentioned = [name for actor in actors for name in functors_of(self._system.program(actor))]
        where = f"agent {actors[0]!r}" if len(actors) == 1 else f"the actors {', '.join(actors)}"
        for belief in self.space.beliefs:
            if belief not in mentioned and belief not in self.space.default_beliefs:
                raise GenerateError(
                    f"{self.model.path}: belief {belief!r} of the space occurs nowhere in {where}, "
                    "so that choosing it could never change a test; expected it there, or among the default beliefs"
                    f"{nearest(belief, mentioned)}"
                )

    def run(self, beliefs: Iterable[str]) -> ModelRun:
        """Run the model with one subset.

        Raises:
            GenerateError: a belief is not of the space, the model fails, or an action has no text form.
        """
        subset = self.space.subset(beliefs)
        percepts = {self.model.steering_agent: [f"{self.model.chosen}({belief})" for belief in subset]}
        try:
            result = self._memo.run(max_rounds=self.model.max_rounds, seed=self.model.seed, percepts=percepts)
        except BdiError as error:
            raise GenerateError(f"BDI model {self.model.path} with {' '.join(subset)}: {error}") from error
        self.run_count += 1
        self._cut_off_count += result.ended == _ROUND_LIMIT
        self._has_acted |= bool(lines := self._lines(result.actions))
        self._endless.update(result.endless)
        sequence = {agent: self._coverage(agent, result.plans.get(agent, [])) for agent in self.model.covered}
        return ModelRun(
            beliefs=subset,
            lines=lines,
            plans={agent: frozenset(labels) for agent, labels in sequence.items()},
            sequence=sequence,
            rounds=result.rounds,
            ended=result.ended,
        )

    def order(self, beliefs: Iterable[str]) -> After:
        """The order between actions of different actors that the model's dependencies require.

        Empty for one actor. The run is repeated for it, with a trace.

        Raises:
            GenerateError: as `run`.
        """
        model = self.model
        if not model.actors:
            return {}
        subset = self.space.subset(beliefs)
        percepts = {model.steering_agent: [f"{model.chosen}({belief})" for belief in subset]}
        try:
            result = self._system.run(max_rounds=model.max_rounds, seed=model.seed, percepts=percepts, trace=True)
        except BdiError as error:
            raise GenerateError(f"BDI model {model.path} with {' '.join(subset)}: {error}") from error
        assert result.trace is not None, "asked for"
        programs = {agent: self._system.program(agent) for agent in self._system.agents}
        return causes(result.trace, programs, model.actors)

    def all_runs(self, plans: Sequence[tuple[str, str]]) -> list[ExploredRun] | None:
        """Every distinct run with one start belief and any other beliefs.

        Args:
            plans: agents and labels of the plans of interest, by the number of their bit.

        Returns:
            The runs; None if the engine cannot enumerate the runs of this model.

        Raises:
            TooLargeError: there are too many runs.
            GenerateError: the model fails, or an action has no text form.
        """
        plan_bits = {plan: 1 << place for place, plan in enumerate(plans)}

        def content(actions: Sequence[tuple[str, str]], executed: Sequence[tuple[str, list[str]]]) -> Content:
            labels = {(agent, label) for agent, done in executed for label in done}
            return self._lines(actions), sum(plan_bits.get(plan, 0) for plan in labels)

        model, bits = self.model, self.space.bits
        explored: list[ExploredRun] = []
        for start in self.space.start:
            fixed = {belief: belief == start for belief in self.space.start}
            try:
                runs = self._memo.explore_all(
                    model.steering_agent, model.chosen, self.space.beliefs, fixed, content, model.max_rounds, model.seed
                )
            except BdiError as error:
                raise GenerateError(f"BDI model {model.path}: {error}") from error
            if runs is None:
                return None
            explored += [
                ExploredRun(lines, mask, bits[start] | sum([bits[belief] for belief in beliefs]))
                for (lines, mask), beliefs in runs.items()
            ]
        return explored

    def not_enumerable(self) -> str:
        """Why `all_runs` gives none, where there are too many belief sets to try."""
        model, space = self.model, self.space
        obstacle = self._memo.obstacle(model.steering_agent, model.chosen, space.others)
        return f"{NOT_ENUMERABLE.format(len(space.others), MAX_OTHERS)}; nor can runs be put together: {obstacle}"

    def notes(self) -> tuple[str, ...]:
        """Notes for the suite: how many runs, and so tests, were cut off, and the plans that did not end.

        Raises:
            GenerateError: all runs were cut off.
        """
        plans = self._endless.most_common(_MOST_NAMED)
        notes = [f"{place} never ends in {count} runs of the model; {_REMEDY}" for place, count in plans]
        if self._cut_off_count:
            limit = self.model.max_rounds
            cut_off = f"{self._cut_off_count} of {self.run_count} runs of the model were cut off after {limit} rounds"
            if self._cut_off_count == self.run_count:
                raise GenerateError("; ".join((cut_off, *notes)))
            notes.insert(0, cut_off)
        if self.run_count and not self._has_acted:
            who = ", ".join(self.model.actors or (self.model.actor,))
            notes.append(f"no run of the model has an action of {who}: hricdv model run shows what the agents do")
        return tuple(notes)

    def _lines(self, actions: Iterable[tuple[str, str]]) -> tuple[str, ...]:
        if self.model.actors:
            return tuple([_command(action, agent) for agent, action in actions if agent in self.model.actors])
        # A list inside: a generator takes nearly twice the time, 8 us for 20 commands; a run from the memo takes less.
        return tuple([_command(action) for agent, action in actions if agent == self.model.actor])

    def _coverage(self, agent: str, labels: list[str]) -> tuple[str, ...]:
        coverage = self._coverage_plans[agent]
        return tuple([label for label in labels if label in coverage])


@lru_cache(maxsize=1)  # one model a session
def _load(path: Path, sha256: str) -> Memo:
    """Load the model once per process, so that all methods and the exploration share the memo of its runs.

    The hash is part of the key: a changed model is loaded again. The environment is the plain one, in which every
    external action succeeds and changes nothing but the trace.
    """
    try:
        return Memo(MultiAgentSystem.load(path, Environment()))
    except (BdiError, OSError) as error:
        raise GenerateError(f"BDI model {path}: {error}") from error


@lru_cache(maxsize=4096)
def _command(action: str, actor: str = "") -> str:
    """Like `command_from_action`; a model has few different actions, and every run has some of them."""
    return command_from_action(action, actor)


def explore_exhaustively(runner: ModelRunner) -> Exploration:
    """Find all runs of a model: every abstract test that a belief set can give, with the plans executed.

    The belief sets are those with one start belief and any of the others. If the BDI engine can enumerate the runs of
    the model, not all sets have to be run; otherwise a small space is explored set by set, and a large one is not
    explored.

    Raises:
        GenerateError: the model fails.
    """
    plans = tuple((agent, label) for agent, labels in runner.plan_labels.items() for label in labels)
    beliefs = runner.space.beliefs
    try:
        runs = runner.all_runs(plans)
    except TooLargeError:
        return Exploration(plans, beliefs, reason=TOO_LARGE)
    if runs is None:
        if len(runner.space.others) > MAX_OTHERS:
            return Exploration(plans, beliefs, reason=runner.not_enumerable())
        runs = _set_by_set(runner, plans)
    return Exploration(plans, beliefs, tuple(sorted(runs, key=order_of_run)))


def _set_by_set(runner: ModelRunner, plans: Sequence[tuple[str, str]]) -> list[ExploredRun]:
    """Each distinct run once, by running all belief sets, the smallest first."""
    others, starts = runner.space.others, runner.space.start
    subsets = (
        (start, *chosen) for size in range(len(others) + 1) for start in starts for chosen in combinations(others, size)
    )
    return distinct_runs(map(runner.run, subsets), runner.space, plans)


def distinct_runs(runs: Iterable[ModelRun], space: BeliefSpace, plans: Sequence[tuple[str, str]]) -> list[ExploredRun]:
    """The runs, each once; the first of those with the same test and the same plans."""
    distinct: dict[tuple[tuple[str, ...], int], ExploredRun] = {}
    for run in runs:
        mask = sum(1 << place for place, (agent, label) in enumerate(plans) if label in run.plans[agent])
        beliefs = sum(space.bits[belief] for belief in run.beliefs)
        distinct.setdefault((run.lines, mask), ExploredRun(run.lines, mask, beliefs))
    return list(distinct.values())


def order_of_run(run: ExploredRun) -> tuple[int, int, ExploredRun]:
    """Sort key: part of the cache and of what is chosen from it, so it is the same on every machine."""
    return run.beliefs.bit_count(), run.beliefs, run


SAMPLES = 2**MAX_OTHERS
"""Number of belief sets drawn: as many as one start belief has in the largest model that is explored completely."""

DRAWS = 20 * SAMPLES
"""Most draws: for spaces with fewer sets, more than 19 of 20 draws repeat one."""


def explore_by_sampling(runner: ModelRunner, reason: str) -> Exploration:
    """Find some runs of a model: of belief sets with one start belief, and one belief of each group or none.

    The sets depend on the belief space alone, so they are the same in each session. Sets that the model fails with are
    left out, and the reason says how many.

    Args:
        reason: why the model cannot be explored as a whole.

    Raises:
        GenerateError: the model fails with each set.
    """
    plans = tuple((agent, label) for agent, labels in runner.plan_labels.items() for label in labels)
    executed: list[ModelRun] = []
    failures: list[GenerateError] = []
    sets = [*_sets(runner, make_rng("sampled exploration", list(runner.space.beliefs)))]
    for beliefs in sets:
        try:
            executed.append(runner.run(beliefs))
        except GenerateError as error:
            failures.append(error)
    if not executed:
        raise failures[0]
    runs = sorted(distinct_runs(executed, runner.space, plans), key=order_of_run)
    text = f"{reason}; so {len(sets)} sets of beliefs were drawn, which gave {len(runs)} different runs"
    if failures:
        text += f"; with {len(failures)} of them the model failed; the first: {failures[0]}"
    return Exploration(plans, runner.space.beliefs, tuple(runs), text)


def _sets(runner: ModelRunner, rng: Random) -> Iterator[tuple[str, ...]]:
    """Distinct belief sets: each start belief alone, then those that are drawn."""
    space, drawn = runner.space, dict[tuple[str, ...], None]()
    groups = [
        ("", *(belief for belief in group if belief not in space.default_beliefs)) for group in space.groups.values()
    ]
    possible = len(space.start) * math.prod(len(group) for group in groups)
    for start in space.start:
        drawn[space.subset([start])] = None
    for _ in range(DRAWS):
        if len(drawn) >= min(SAMPLES, possible):
            break
        beliefs = [pick(rng, space.start), *(pick(rng, group) for group in groups)]
        drawn[space.subset(belief for belief in beliefs if belief)] = None
    yield from drawn
