"""The checks, one a module; a new one is added to the list here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .endless_spin import EndlessSpin
from .goal_without_plan import GoalWithoutPlan
from .near_name import NearName
from .shadowed_plan import ShadowedPlan
from .unbound_comparison import UnboundComparison
from .unknown_agent import UnknownAgent
from .unknown_belief import UnknownBelief
from .unmatched_deletion import UnmatchedDeletion

if TYPE_CHECKING:
    from ..finding import Check

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
