"""All checks of lint; a new one is added to the tuple here."""

from __future__ import annotations

from pytest_hricdv.bdi.lint.checks.beliefs import UnknownBelief, UnmatchedDeletion
from pytest_hricdv.bdi.lint.checks.endless_spin import EndlessSpin
from pytest_hricdv.bdi.lint.checks.goals import GoalWithoutPlan
from pytest_hricdv.bdi.lint.checks.names import NearName, UnknownAgent
from pytest_hricdv.bdi.lint.checks.shadowed_plan import ShadowedPlan
from pytest_hricdv.bdi.lint.checks.unbound_comparison import UnboundComparison
from pytest_hricdv.bdi.lint.finding import Check

CHECKS: tuple[Check, ...] = (
    EndlessSpin(),
    GoalWithoutPlan(),
    NearName(),
    ShadowedPlan(),
    UnboundComparison(),
    UnknownAgent(),
    UnknownBelief(),
    UnmatchedDeletion(),
)
