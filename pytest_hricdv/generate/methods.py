"""The methods that generate suites, such as `ByHand`; `select_methods` finds those of `--hri-suite` by name.

`session.suites` calls it, and then `generate` of each method with a `GenerationContext`.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

from pytest_hricdv._base.message import nearest
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractDraft, slug, target_of_commands
from pytest_hricdv.generate.actors import actor_of, actors_of
from pytest_hricdv.generate.beliefs import read_belief_sets
from pytest_hricdv.generate.context import GenerationContext, Method, draft_of, evenly_spaced
from pytest_hricdv.generate.learner import LearningResult, learn, policy_subsets
from pytest_hricdv.generate.model import ModelRun
from pytest_hricdv.generate.qlearning import Plan
from pytest_hricdv.generate.rng import make_rng, pick, random_index
from pytest_hricdv.generate.saved_table import SavedTable
from pytest_hricdv.generate.suite import Generation, Suite, diagnose
from pytest_hricdv.generate.suite_files import Files

if TYPE_CHECKING:
    from pytest_hricdv.generate.model_runner import ModelRunner

# Limit of random draws for each test. Drawing each of n subsets once takes about ln n + 0.6 draws per subset (coupon
# collector), 12 for 100,000. So the limit is only reached if fewer different subsets exist than expected.
_DRAWS_PER_TEST = 1000


def _draft(runner: ModelRunner, run: ModelRun, name: str = "") -> AbstractDraft:
    return draft_of(run, runner.space, name, runner.order(run.beliefs))


@dataclass(frozen=True)
class ByHand:
    """The paper's method by hand: the subsets of a file, in its order.

    Args:
        path: of the file; None: `GenerationContext.by_hand`.
    """

    name: str = "by-hand"
    path: Path | None = None

    def generate(self, context: GenerationContext) -> Suite:
        """Run the model once for each subset.

        Raises:
            GenerateError: the testbench names no file, or something in it is wrong; with file, line and column.
        """
        path = self.path or context.by_hand
        if path is None:
            raise GenerateError("tests by hand need a file of belief subsets, but the testbench names none")
        runner, space = context.model_runner(), context.beliefs
        drafts: list[AbstractDraft] = []
        for entry in read_belief_sets(path, space):
            for subset in entry.subsets:
                drafts += [_draft(runner, runner.run(subset), entry.name)] * entry.concretizations
        generation = Generation(bdi_runs=runner.run_count, declared_plans=runner.plan_labels, notes=runner.notes())
        return Suite.of_drafts(self.name, context.seed, evenly_spaced(drafts, context.tests), generation)


@dataclass(frozen=True)
class BdiPseudorandom:
    """The paper's BDI pseudorandom method: distinct subsets, each with one belief from each group; 100 by default."""

    name: str = "bdi-random"
    size: int = 100

    def generate(self, context: GenerationContext) -> Suite:
        """Draw the subsets, run the model once for each. A larger suite of the same seed begins with the smaller."""
        runner, space = context.model_runner(), context.beliefs
        count = context.tests or self.size
        groups = [space.start, *space.groups.values()]
        possible = math.prod(len(group) for group in groups)
        rng = make_rng(self.name, context.seed)
        chosen: dict[tuple[str, ...], None] = {}
        draws = 0
        while len(chosen) < min(count, possible) and draws < _DRAWS_PER_TEST * count:
            chosen[space.subset(pick(rng, group) for group in groups)] = None
            draws += 1
        drafts = [_draft(runner, runner.run(subset)) for subset in chosen]
        short = f"{count} tests asked for, but only {len(chosen)} distinct subsets were found of {possible} that exist"
        generation = Generation(
            bdi_runs=runner.run_count,
            declared_plans=runner.plan_labels,
            notes=(*([short] if len(chosen) < count else []), *runner.notes()),
        )
        return Suite.of_drafts(self.name, context.seed, drafts, generation)


@dataclass(frozen=True)
class Pseudorandom:
    """The paper's baseline without a model: 100 tests by default, each a random sequence of commands.

    Of several actors, each has a sequence of its own commands, from a random stream of its own.
    """

    name: str = "pseudorandom"
    size: int = 100

    def generate(self, context: GenerationContext) -> Suite:
        """Draw the tests, each from its own random stream, with `GenerationContext.lengths` commands.

        Raises:
            GenerateError: no command can be executed.
        """
        if not context.commands:
            raise GenerateError("pseudorandom tests need the commands that can be executed, but the testbench has none")
        # Each test has a stream of its own, by its number: a larger suite begins with the smaller one.
        drafts = [self._draw(context, number) for number in range(context.tests or self.size)]
        return Suite.of_drafts(self.name, context.seed, drafts, Generation())

    def _draw(self, context: GenerationContext, number: int) -> AbstractDraft:
        rng = make_rng(self.name, context.seed, number)
        lines = _draw_lines(rng, context.commands, context.lengths)
        actors = actors_of(context.commands)
        if actors:
            lanes = [
                _draw_lines(
                    make_rng(self.name, context.seed, number, actor),
                    [command for command in context.commands if actor_of(command) == actor],
                    context.lengths,
                )
                for actor in actors
            ]
            # Alternate, so that the order of the text, the simplest interleaving, is a real one.
            lines = tuple(line for lines in zip_longest(*lanes) for line in lines if line is not None)
        return AbstractDraft(target_of_commands(lines), (), lines)


def _draw_lines(rng: Random, commands: Sequence[str], lengths: tuple[int, int]) -> tuple[str, ...]:
    fewest, most = lengths
    length = fewest + random_index(rng, most - fewest + 1)
    return tuple(pick(rng, commands) for _ in range(length))


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
        plans = [[(agent, plan) for agent, own in run.plans.items() for plan in own] for run in candidates]
        texts = {run.lines for run in self.chosen}

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


@dataclass(frozen=True)
class ReinforcementLearning:
    """The paper's BDI RL method: 134 tests by default, fewer if the policy leads to fewer subsets."""

    name: str = "rl"

    def generate(self, context: GenerationContext) -> Suite:
        """Learn, run the model with the subsets that the policy leads to, and select tests among these runs.

        The paper does not say which of the policy's subsets became its tests. With `candidates` = 1 every subset
        found becomes one. If the reward depends on the suite, there are several rounds, and each adds a part of it.
        """
        runner, space = context.model_runner(), context.beliefs
        count = context.tests or context.learning.suite_size
        selector = GreedySelector()
        rounds: list[LearningResult] = []
        for number, parameters in enumerate(context.learning.in_rounds(count)):
            learned = learn(
                runner,
                space,
                parameters,
                context.seed,
                round_number=number,
                suite=selector.executed,
                start=context.start,
                tell=context.tell,
            )
            chosen = {run.beliefs for run in selector.chosen}
            # Ask for as many more as were chosen before: this round's policy may lead to those, too.
            wanted = parameters.suite_size * parameters.candidates
            subsets = policy_subsets(learned.q, space, parameters, wanted + len(chosen), context.seed, number)
            new = [subset for subset in subsets if subset not in chosen][:wanted]
            selector.choose(map(runner.run, new), parameters.suite_size)
            rounds.append(learned)
        _save(rounds[-1], context)
        drafts = [_draft(runner, run) for run in selector.chosen]
        notes = (*runner.notes(), *_notes(rounds, len(drafts), count, context))
        generation = replace(_generation(rounds, runner, context), notes=notes)
        suite = Suite.of_drafts(self.name, context.seed, drafts, generation)
        missed = [f"{agent}: {' '.join(labels)}" for agent, labels in suite.plans_not_covered().items()]
        suite = suite.with_note("uncovered plans: " + "; ".join(missed)) if missed else suite
        warning = diagnose(suite).warning
        return suite.with_note(warning) if warning else suite


def _save(learned: LearningResult, context: GenerationContext) -> None:
    """Save the table of the last round if a file is given."""
    if context.save is not None and context.model is not None:
        table = SavedTable.of(learned, context.model, context.beliefs, context.learning, context.seed)
        table.write(context.save)


def _generation(rounds: Sequence[LearningResult], runner: ModelRunner, context: GenerationContext) -> Generation:
    """Facts on the generation; iterations are numbered through all rounds."""
    iterations = sum(learned.iterations for learned in rounds)
    before = iterations - rounds[-1].iterations
    converged = [learned.converged_at for learned in rounds if learned.converged_at is not None]
    offset, last_new_plan_at = 0, 0
    for learned in rounds:
        last_new_plan_at = offset + learned.last_new_plan_at if learned.last_new_plan_at else last_new_plan_at
        offset += learned.iterations
    return Generation(
        bdi_runs=runner.run_count,
        iterations=iterations,
        converged_at=before + converged[-1] if len(converged) == len(rounds) else None,
        q_delta=tuple(delta for learned in rounds for delta in learned.q_delta),
        last_new_plan_at=last_new_plan_at,
        reward=context.learning.reward,
        declared_plans=runner.plan_labels,
    )


def _notes(rounds: Sequence[LearningResult], tests: int, count: int, context: GenerationContext) -> Iterator[str]:
    if context.start.name:
        yield f"learning began with {context.start.name}"
    if tests < count:
        yield f"{count} tests asked for, but the policy leads to {tests} distinct subsets only"
    unconverged = [learned for learned in rounds if learned.converged_at is None]
    if unconverged:
        where = f" in {len(unconverged)} of {len(rounds)} rounds" if len(rounds) > 1 else ""
        last = max(learned.q_delta[-1] for learned in unconverged)
        done = max(learned.iterations for learned in unconverged)
        yield f"not converged{where} after {done} iterations: the last changed a cell by {last:g}"


#: The methods of the paper, in its order.
METHODS: Mapping[str, Method] = {
    method.name: method for method in (ByHand(), BdiPseudorandom(), ReinforcementLearning(), Pseudorandom())
}
ALL = "all"


def select_methods(selection: str, root: Path, lacking: Container[str] = ()) -> tuple[Method, ...]:
    """The methods of a selection such as `by-hand,rl`, `all` or `tests/recorded.txt`, in order, each once.

    Args:
        selection: names, `all`, or paths of files and folders of tests, or of belief sets (`*.toml`), with commas
            between them.
        root: the folder that paths are relative to.
        lacking: names of methods that `all` leaves out, as the testbench lacks what they need.

    Raises:
        GenerateError: a name that is not a method, and no file or folder either; or nothing selected.
    """
    chosen: dict[Method, None] = {}
    for name in filter(None, (part.strip() for part in selection.split(","))):
        if name == ALL:
            chosen.update(dict.fromkeys(method for method in METHODS.values() if method.name not in lacking))
        elif name in METHODS:
            chosen[METHODS[name]] = None
        elif (root / name).is_file() and name.endswith(".toml"):
            chosen[ByHand(slug(Path(name).stem), root / name)] = None
        elif (root / name).exists():
            chosen[Files(root / name)] = None
        else:
            raise GenerateError(
                f"suite {name!r} is not a method, and there is no file or folder of that name in {root}"
                f"{nearest(name, (*METHODS, ALL))}"
            )
    if not chosen:
        raise GenerateError(f"suite {selection!r} selects nothing{nearest('', (*METHODS, ALL))}")
    return tuple(chosen)
