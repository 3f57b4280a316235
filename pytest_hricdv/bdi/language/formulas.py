"""Formulas: the conditions of contexts, rules and test goals."""

from __future__ import annotations

from dataclasses import dataclass

from pytest_hricdv.bdi.language.terms import AnnotatedVariable, Call, Structure, Term, Variable


@dataclass(frozen=True, slots=True)
class And:
    """All parts hold, tried from left to right."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' & '.join(map(str, self.parts))})"


@dataclass(frozen=True, slots=True)
class Or:
    """Some part holds, tried from left to right."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' | '.join(map(str, self.parts))})"


@dataclass(frozen=True, slots=True)
class Not:
    """Negation as failure: the part has no solution."""

    part: Formula

    def __str__(self) -> str:
        return f"not {self.part}"


@dataclass(frozen=True, slots=True)
class Comparison:
    """A relation between two terms; ``=`` unifies them, the others compare values."""

    operator: str
    left: Term
    right: Term

    def __str__(self) -> str:
        return f"({self.left} {self.operator} {self.right})"


Formula = Structure | Variable | AnnotatedVariable | Call | And | Or | Not | Comparison
FORMULAS = (Structure, Variable, AnnotatedVariable, Call, And, Or, Not, Comparison)
GOAL_TERMS = (Structure, Variable, AnnotatedVariable)
GoalTerm = Structure | Variable | AnnotatedVariable
"""What can be achieved, tested or believed: a literal, or a variable that stands for one."""
