"""Comparisons: equality, unification, and the order of terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.formulas import Comparison
from pytest_hricdv.bdi.language.terms import Arithmetic, ListTerm, Number, Structure, Term, term_order
from pytest_hricdv.bdi.logic.substitution import Bindings, substitute, walk
from pytest_hricdv.bdi.logic.unify import Trail, unify

if TYPE_CHECKING:
    from pytest_hricdv.bdi.agent import Agent


def compare(agent: Agent, comparison: Comparison, env: Bindings, trail: Trail) -> bool:
    """Decide a comparison; ``=`` and ``=..`` bind variables.

    Raises:
        EvaluationError: a side is an expression without a value.
    """
    left = substitute(comparison.left, env, agent.function)
    right = substitute(comparison.right, env, agent.function)
    operator = comparison.operator
    if operator == "=":
        return unify(_valued(left), _valued(right), env, trail)
    if operator == "==":
        return left == right
    if operator == "\\==":
        return left != right
    if operator == "=..":
        return _univ(left, right, env, trail)
    if isinstance(left, Number) and isinstance(right, Number):
        below, above = left < right, left > right
    else:
        below, above = term_order(left) < term_order(right), term_order(left) > term_order(right)
    if operator == "<":
        return below
    if operator == ">":
        return above
    return not above if operator == "<=" else not below


def _valued(term: Term) -> Term:
    if isinstance(term, Arithmetic):
        raise EvaluationError(f"{term} has no value: a variable in it is not bound")
    return term


def _univ(left: Term, right: Term, env: Bindings, trail: Trail) -> bool:
    """``p(a)[b] =.. [p,[a],[b]]``, to take a literal apart or to build one."""
    if isinstance(left, Structure):
        parts = ListTerm((Structure(left.functor, negated=left.negated), ListTerm(left.args), ListTerm(left.annots)))
        return unify(parts, right, env, trail)
    if isinstance(right, ListTerm) and len(right.items) == 3:
        functor, args, annots = (walk(item, env) for item in right.items)
        if isinstance(functor, Structure) and isinstance(args, ListTerm) and isinstance(annots, ListTerm):
            built = Structure(functor.functor, args.items, (), functor.negated).with_annotations(annots.items)
            return unify(left, built, env, trail)
    raise EvaluationError(f"neither side of {left} =.. {right} is known")
