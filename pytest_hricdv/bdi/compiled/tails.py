"""Plans whose last statement pursues a goal: most of them are never looked at again, and need not be remembered.

Such a plan waits for the goal on its intention's stack, but has nothing left to do. It only matters to a plan for the
failure of its own goal, and to actions that look at intentions. Where there is neither, the stack of an agent that
does everything in one long intention stays short, and its mental state is the same whatever way led to it.
"""

from __future__ import annotations

from ..library import PlanLibrary
from ..syntax import Plan


def is_forgotten(plan: Plan, library: PlanLibrary) -> bool:
    """Whether a plan of an agent with private intentions need not be remembered once it has nothing left to do."""
    key = plan.trigger.key
    return key is not None and not library.relevant(f"-{key[0][1:]}", key[1])
