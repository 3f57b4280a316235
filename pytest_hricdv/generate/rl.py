"""BDI RL: subsets from a policy learned on the model's plan coverage."""

from __future__ import annotations

from dataclasses import dataclass

from .method import Context, draft_of
from .policy import subsets
from .qlearning import learn
from .selection import balanced
from .suite import Generation, Suite


@dataclass(frozen=True)
class ReinforcementLearning:
    """The paper's BDI RL method: 134 tests unless told otherwise, as many as the policy leads to at most."""

    name: str = "rl"

    def generate(self, context: Context) -> Suite:
        """Learn, run the model with the subsets that the policy leads to, and keep those that balance the plans.

        The paper does not say which of the policy's subsets became its tests. With `candidates` = 1 every subset
        found becomes one.
        """
        explorer, space, parameters = context.explorer(), context.beliefs, context.learning
        learned = learn(explorer, space, parameters, context.seed)
        count = context.tests or parameters.suite_size
        walked = subsets(learned.q, space, parameters, count * parameters.candidates, context.seed)
        chosen = balanced(map(explorer.explore, walked), count)
        drafts = [draft_of(exploration, space) for exploration in chosen]
        notes = list(explorer.notes())
        if len(chosen) < count:
            notes.append(f"{count} tests asked for, but the policy leads to {len(chosen)} distinct subsets only")
        if learned.converged_at is None:
            last = learned.q_delta[-1]
            notes.append(f"not converged after {learned.iterations} iterations: the last changed a cell by {last:g}")
        generation = Generation(
            bdi_runs=explorer.runs,
            iterations=learned.iterations,
            converged_at=learned.converged_at,
            q_delta=learned.q_delta,
            declared_plans=explorer.plan_labels,
            notes=tuple(notes),
        )
        suite = Suite.of_drafts(self.name, context.seed, drafts, generation)
        missed = [f"{agent}: {' '.join(labels)}" for agent, labels in suite.uncovered_plans().items()]
        return suite.noted("plans that no test executes: " + "; ".join(missed)) if missed else suite
