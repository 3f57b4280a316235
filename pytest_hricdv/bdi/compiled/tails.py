"""Plans whose last statement pursues a goal: most of them are never looked at again, and need not be remembered.

Such a plan waits for the goal on its intention's stack, but has nothing left to do. It only matters to a plan for the
failure of its own goal, and to actions that look at intentions. Where there is neither, the stack of an agent that
does everything in one long intention stays short, and its mental state is the same whatever way led to it.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..library import PlanLibrary
from ..syntax import Plan, Program, children
from ..terms import Call, Quoted, Structure

# fmt: off
_BLIND = frozenset({
    ".print", ".println", ".log", ".send", ".broadcast", ".abolish", ".wait", ".findall", ".setof", ".count",
    ".belief", ".fail", ".stopMAS", ".random", ".my_name", ".member", ".length", ".concat", ".nth", ".max", ".min",
    ".sort", ".reverse", ".range", ".delete", ".union", ".intersection", ".difference", ".empty", ".eval",
    ".string", ".atom", ".number", ".list", ".ground", ".literal", ".structure", ".var", ".term2string", ".time",
})
# fmt: on
"""Internal actions that do not look at intentions, nor lead to any that might."""
_HARMLESS = frozenset({"tell", "untell", "achieve", "askOne", "askAll"})
"""Forces of messages that do not tell the receiver to give up a goal, or to get to know a plan."""
_FORCE_AT = {".send": 1, ".broadcast": 0}


def are_intentions_private(programs: Iterable[Program]) -> bool:
    """Whether nothing in the programs of a system looks at what intentions consist of."""
    return all(_is_blind(part) for program in programs for part in _parts((program.beliefs, program.plans)))


def is_forgotten(plan: Plan, library: PlanLibrary) -> bool:
    """Whether a plan of an agent with private intentions need not be remembered once it has nothing left to do."""
    key = plan.trigger.key
    return key is not None and not library.relevant(f"-{key[0][1:]}", key[1])


def _is_blind(part: object) -> bool:
    if isinstance(part, Quoted):
        return False
    if not isinstance(part, Call):
        return True
    if part.name in _FORCE_AT:
        force = part.args[_FORCE_AT[part.name] : _FORCE_AT[part.name] + 1]
        return all(isinstance(each, Structure) and each.functor in _HARMLESS for each in force)
    return part.name in _BLIND or part.name.startswith("math.")


def _parts(node: object) -> Iterable[object]:
    pending = [node]
    while pending:
        part = pending.pop()
        yield part
        if not isinstance(part, (float, str)):
            pending.extend(children(part))
