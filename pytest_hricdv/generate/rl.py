"""BDI RL: subsets from a policy learned on the model's plan coverage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .diagnosis import diagnose
from .method import Context, draft_of
from .policy import subsets
from .qlearning import Learned, learn
from .selection import GreedySelector
from .suite import Generation, Suite

if TYPE_CHECKING:
    from .explorer import Explorer


@dataclass(frozen=True)
class ReinforcementLearning:
    """The paper's BDI RL method: 134 tests unless told otherwise, as many as the policy leads to at most."""

    name: str = "rl"

    def generate(self, context: Context) -> Suite:
        """Learn, run the model with the subsets that the policy leads to, and keep those that balance the plans.

        The paper does not say which of the policy's subsets became its tests. With `candidates` = 1 every subset
        found becomes one. Where the reward looks at the suite, all of this is done in several rounds, each of which
        adds its part to the suite.
        """
        explorer, space = context.explorer(), context.beliefs
        count = context.tests or context.learning.suite_size
        selector, rounds = GreedySelector(), []
        for number, parameters in enumerate(context.learning.in_rounds(count)):
            learned = learn(
                explorer, space, parameters, context.seed, number=number, suite=selector.executed, start=context.start
            )
            known = {each.beliefs for each in selector.chosen}
            wanted = parameters.suite_size * parameters.candidates
            walked = subsets(learned.q, space, parameters, wanted + len(known), context.seed, number)
            fresh = [subset for subset in walked if subset not in known][:wanted]
            selector.choose(map(explorer.explore, fresh), parameters.suite_size)
            rounds.append(learned)
        _save(rounds[-1], context)
        drafts = [draft_of(exploration, space) for exploration in selector.chosen]
        generation = replace(
            _generation(rounds, explorer, context),
            notes=(*explorer.notes(), *_notes(rounds, len(drafts), count, context)),
        )
        suite = Suite.of_drafts(self.name, context.seed, drafts, generation)
        missed = [f"{agent}: {' '.join(labels)}" for agent, labels in suite.uncovered_plans().items()]
        suite = suite.noted("plans that no test executes: " + "; ".join(missed)) if missed else suite
        warning = diagnose(suite).warning
        return suite.noted(warning) if warning else suite


def _save(learned: Learned, context: Context) -> None:
    """Save the table, that of the last round, where it is wanted."""
    if context.save is None or context.model is None:
        return
    from .saved_table import SavedTable

    SavedTable.of(learned, context.model, context.beliefs, context.learning, context.seed).write(context.save)


def _generation(rounds: Sequence[Learned], explorer: Explorer, context: Context) -> Generation:
    """How it came about; iterations are numbered through all rounds."""
    iterations = sum(learned.iterations for learned in rounds)
    before = iterations - rounds[-1].iterations
    converged = [learned.converged_at for learned in rounds if learned.converged_at is not None]
    offset, news_at = 0, 0
    for learned in rounds:
        news_at = offset + learned.news_at if learned.news_at else news_at
        offset += learned.iterations
    return Generation(
        bdi_runs=explorer.runs,
        iterations=iterations,
        converged_at=before + converged[-1] if len(converged) == len(rounds) else None,
        q_delta=tuple(delta for learned in rounds for delta in learned.q_delta),
        news_at=news_at,
        reward=context.learning.reward,
        declared_plans=explorer.plan_labels,
    )


def _notes(rounds: Sequence[Learned], found: int, count: int, context: Context) -> Iterator[str]:
    if context.start.name:
        yield f"learning began with {context.start.name}"
    if found < count:
        yield f"{count} tests asked for, but the policy leads to {found} distinct subsets only"
    open_ = [learned for learned in rounds if learned.converged_at is None]
    if open_:
        where = f" in {len(open_)} of {len(rounds)} rounds" if len(rounds) > 1 else ""
        last = max(learned.q_delta[-1] for learned in open_)
        done = max(learned.iterations for learned in open_)
        yield f"not converged{where} after {done} iterations: the last changed a cell by {last:g}"
