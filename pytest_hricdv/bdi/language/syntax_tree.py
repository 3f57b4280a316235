"""Traverses syntax trees (`parts_of`, `children`, `variables_of`), and copies them with terms replaced by their values.

Lint and the memo traverse programs. `substitution` and internal actions copy terms with `with_values` and its variants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from pytest_hricdv.bdi.language import syntax
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import MAX_SIZE, spend, too_large
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Arithmetic,
    Call,
    FormulaTerm,
    ListTerm,
    PlanTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
)

Valuation = Callable[[Term], Term]
"""Gives the value of a term under some bindings."""
_VALUED = (Variable, Structure, ListTerm, Arithmetic, AnnotatedVariable, QualifiedLiteral, PlanTerm, FormulaTerm)


def with_values(term: PlanTerm, value: Valuation) -> PlanTerm:
    """The plan term with its terms replaced by their values; in ``{ !g; B }``, B is replaced by its statements."""
    size = sum(1 for _ in parts_of(term))
    if size > MAX_SIZE:
        raise too_large()
    spend(size)
    return PlanTerm(_replace_terms(term.plan, value)) if variables_of(term) else term


def call_with_values(call: Call, value: Valuation) -> Call:
    """The call of an action with the terms in its arguments replaced by their values; it is not executed."""
    return Call(call.name, _replace_terms(call.args, value), call.location)


def condition_with_values(term: FormulaTerm, value: Valuation) -> FormulaTerm:
    """The condition with its terms replaced by their values."""
    return FormulaTerm(_replace_terms(term.formula, value), term.location)


def _replace_terms(part: Any, value: Valuation) -> Any:
    if isinstance(part, tuple):
        return tuple(replacement for item in part for replacement in _replacements(item, value))
    if isinstance(part, _VALUED):
        return value(part)
    if isinstance(part, Call):
        # The action itself is executed with the body, not now.
        return call_with_values(part, value)
    names = child_fields(part)
    if not names:
        return part
    return replace(part, **{name: _replace_terms(getattr(part, name), value) for name in names})


def _replacements(part: Any, value: Valuation) -> tuple[syntax.Statement, ...]:
    """The statements that replace an item: for a statement that is a variable, those of its body."""
    if isinstance(part, syntax.ExternalAction) and isinstance(part.action, Variable):
        body = value(part.action)
        if isinstance(body, PlanTerm) and isinstance(body.plan, tuple):
            return body.plan
    return (_replace_terms(part, value),)


def with_constants_evaluated(term: Term) -> Term:
    """The term with each expression without variables replaced by its value: ``p(1 + 2, X)`` is ``p(3, X)``.

    Raises:
        EvaluationError: see :meth:`~pytest_hricdv.bdi.language.terms.Arithmetic.value`.
    """
    if isinstance(term, Arithmetic):
        value = term.value(tuple(map(with_constants_evaluated, term.operands)))
        if isinstance(value, Call):
            raise EvaluationError(f"{value.args[0]} is not a number, in {term}")
        return value
    if isinstance(term, Structure) and term.evaluable:
        args, annots = (tuple(map(with_constants_evaluated, part)) for part in (term.args, term.annots))
        return Structure(term.functor, args, (), term.negated).with_annotations(annots, term.annots_tail)
    if isinstance(term, ListTerm) and term.evaluable:
        return ListTerm(tuple(map(with_constants_evaluated, term.items)), term.tail)
    return term


def variables_of(node: object) -> set[Variable]:
    """The variables in a term or formula."""
    return {part for part in parts_of(node) if isinstance(part, Variable)}


def functors_of(node: object) -> dict[str, None]:
    """The names of all literals and structures in a part of a program, in the order of the text, each once."""
    return {part.functor: None for part in parts_of(node) if isinstance(part, Structure)}


def parts_of(node: object) -> Iterator[object]:
    """A term, formula, statement or plan, or a tuple of them, and all its parts, in the order of the text."""
    pending = [node]
    while pending:
        part = pending.pop()
        yield part
        pending.extend(reversed(children(part)))


def children(node: object) -> tuple[object, ...]:
    """The parts of a term, formula or statement, one level down."""
    if isinstance(node, tuple):
        return node
    return tuple(value for name in child_fields(node) if (value := getattr(node, name)) is not None)


def child_fields(node: object) -> tuple[str, ...]:
    """The attributes that hold the parts of a term, formula or statement."""
    return _CHILDREN.get(type(node), ())


_CHILDREN: dict[type, tuple[str, ...]] = {
    Structure: ("args", "annots", "annots_tail"),
    QualifiedLiteral: ("space", "literal"),
    AnnotatedVariable: ("variable", "annots", "annots_tail"),
    Call: ("args",),
    ListTerm: ("items", "tail"),
    Arithmetic: ("operands",),
    PlanTerm: ("plan",),
    FormulaTerm: ("formula",),
    syntax.And: ("parts",),
    syntax.Or: ("parts",),
    syntax.Not: ("part",),
    syntax.Comparison: ("left", "right"),
    syntax.AchievementGoal: ("literal",),
    syntax.TestGoal: ("formula",),
    syntax.BeliefUpdate: ("literal",),
    syntax.ExternalAction: ("action",),
    syntax.InternalActionCall: ("call",),
    syntax.ConditionStatement: ("formula",),
    syntax.If: ("condition", "then", "otherwise"),
    syntax.While: ("condition", "body"),
    syntax.For: ("condition", "body"),
    syntax.ForkStatement: ("branches",),
    syntax.PlanTrigger: ("literal",),
    syntax.Plan: ("trigger", "context", "body"),
    syntax.Rule: ("head", "body"),
    syntax.Program: ("beliefs", "goals", "plans"),
}
