"""BDI RL: subsets from a policy learned on the model's plan coverage, and the greedy selection of tests among them."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from pytest_hricdv.generate.context import GenerationContext, draft_of
from pytest_hricdv.generate.learner import LearningResult, learn
from pytest_hricdv.generate.model import ModelRun
from pytest_hricdv.generate.policy import policy_subsets
from pytest_hricdv.generate.reward import Plan
from pytest_hricdv.generate.saved_table import SavedTable
from pytest_hricdv.generate.suite import Generation, Suite, diagnose

if TYPE_CHECKING:
    from pytest_hricdv.generate.model_runner import ModelRunner


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
            )
            known = {run.beliefs for run in selector.chosen}
            wanted = parameters.suite_size * parameters.candidates
            subsets = policy_subsets(learned.q, space, parameters, wanted + len(known), context.seed, number)
            new = [subset for subset in subsets if subset not in known][:wanted]
            selector.choose(map(runner.run, new), parameters.suite_size)
            rounds.append(learned)
        _save(rounds[-1], context)
        drafts = [draft_of(run, space) for run in selector.chosen]
        notes = (*runner.notes(), *_notes(rounds, len(drafts), count, context))
        generation = replace(_generation(rounds, runner, context), notes=notes)
        suite = Suite.of_drafts(self.name, context.seed, drafts, generation)
        missed = [f"{agent}: {' '.join(labels)}" for agent, labels in suite.uncovered_plans().items()]
        suite = suite.with_note("plans that no test executes: " + "; ".join(missed)) if missed else suite
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


def _notes(rounds: Sequence[LearningResult], found: int, count: int, context: GenerationContext) -> Iterator[str]:
    if context.start.name:
        yield f"learning began with {context.start.name}"
    if found < count:
        yield f"{count} tests asked for, but the policy leads to {found} distinct subsets only"
    unconverged = [learned for learned in rounds if learned.converged_at is None]
    if unconverged:
        where = f" in {len(unconverged)} of {len(rounds)} rounds" if len(rounds) > 1 else ""
        last = max(learned.q_delta[-1] for learned in unconverged)
        done = max(learned.iterations for learned in unconverged)
        yield f"not converged{where} after {done} iterations: the last changed a cell by {last:g}"
