"""What is known beforehand of all the agents of a system together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from pytest_hricdv.bdi.language.syntax import ExternalAction, Program
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Call, PlanTerm, Structure

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
_PRINTS = frozenset({".print", ".println", ".log"})


@dataclass(frozen=True, slots=True)
class Company:
    """The agents of a system.

    Args:
        names: their names.
        private: whether nothing looks at what intentions consist of.
        one_acts: whether at most one of them does external actions.
        one_prints: whether at most one of them prints.
    """

    names: frozenset[str]
    private: bool
    one_acts: bool
    one_prints: bool

    @classmethod
    def of(cls, programs: Mapping[str, Program]) -> Self:
        """The agents with these programs, by their names."""
        parts = {name: list(parts_of((program.beliefs, program.plans))) for name, program in programs.items()}
        acting = sum(any(isinstance(part, ExternalAction) for part in found) for found in parts.values())
        printing = sum(any(_prints(part) for part in found) for found in parts.values())
        private = all(_is_blind(part) for found in parts.values() for part in found)
        return cls(frozenset(programs), private, acting < 2, printing < 2)


def _prints(part: object) -> bool:
    return isinstance(part, PlanTerm) or (isinstance(part, Call) and part.name in _PRINTS)


def _is_blind(part: object) -> bool:
    if isinstance(part, PlanTerm):
        return False
    if not isinstance(part, Call):
        return True
    if part.name in _FORCE_AT:
        force = part.args[_FORCE_AT[part.name] : _FORCE_AT[part.name] + 1]
        return all(isinstance(each, Structure) and each.functor in _HARMLESS for each in force)
    return part.name in _BLIND or part.name.startswith("math.")
