"""Records of how a suite was generated."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord


class LastNewPlan(PlainRecord, frozen=True, kw_only=True):
    """The iteration of learning, and the number of the test, after which no new plan was executed."""

    iteration: Count | None
    test: Count


class Diversity(PlainRecord, frozen=True, kw_only=True):
    """How varied a suite is, before any test has run; `plans_executed` is agent -> number of plans."""

    distinct_subsets: Count
    belief_entropy_bits: NotNegative
    belief_entropy_most_bits: NotNegative
    plans_executed: Mapping[str, Count]
    last_new_plan: LastNewPlan


class GenerationResult(PlainRecord, frozen=True, kw_only=True):
    """How a suite was generated. `q_delta` is the largest change of a cell of Q, one number an iteration."""

    wall_s: NotNegative
    cached: bool
    bdi_runs: Count
    iterations: Count
    converged_at: Count | None
    q_delta: tuple[NotNegative, ...]
    distinct_texts: Count
    reward: str
    diagnosis: Diversity
    notes: Names
