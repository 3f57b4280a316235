"""Comparisons: equality, unification, and the order of terms."""

from __future__ import annotations

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.formulas import Comparison
from pytest_hricdv.bdi.language.terms import Arithmetic, ListTerm, Number, Structure, Term, term_order
from pytest_hricdv.bdi.logic.substitution import Bindings, Functions, substitute, walk
from pytest_hricdv.bdi.logic.unify import Trail, unify


def compare(comparison: Comparison, bindings: Bindings, trail: Trail, functions: Functions) -> bool:
    """Decide a comparison; ``=`` and ``=..`` bind variables.

    Raises:
        EvaluationError: a side is an expression without a value.
    """
    left = substitute(comparison.left, bindings, functions)
    right = substitute(comparison.right, bindings, functions)
    operator = comparison.operator
    if operator == "=":
        return unify(_valued(left), _valued(right), bindings, trail)
    if operator == "==":
        return left == right
    if operator == "\\==":
        return left != right
    if operator == "=..":
        return _univ(left, right, bindings, trail)
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


def _univ(left: Term, right: Term, bindings: Bindings, trail: Trail) -> bool:
    """``p(a)[b] =.. [p,[a],[b]]``, to take a literal apart or to build one."""
    if isinstance(left, Structure):
        parts = ListTerm((Structure(left.functor, negated=left.negated), ListTerm(left.args), ListTerm(left.annots)))
        return unify(parts, right, bindings, trail)
    if isinstance(right, ListTerm) and len(right.items) == 3:
        functor, args, annots = (walk(item, bindings) for item in right.items)
        if isinstance(functor, Structure) and isinstance(args, ListTerm) and isinstance(annots, ListTerm):
            built = Structure(functor.functor, args.items, (), functor.negated).with_annotations(annots.items)
            return unify(left, built, bindings, trail)
    raise EvaluationError(f"neither side of {left} =.. {right} is known")
