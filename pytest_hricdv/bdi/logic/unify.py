"""`unify` makes two terms equal by binding variables: it matches events with plans, and goals with beliefs.

Queries (`inference`), plan libraries and internal actions call it. `compare` decides ``=``, ``<`` and ``=..``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pytest_hricdv.bdi.language.collection import CollectionTerm
from pytest_hricdv.bdi.language.errors import EvaluationError, Location
from pytest_hricdv.bdi.language.limits import WORK, spend, too_much_work
from pytest_hricdv.bdi.language.namespaces import DEFAULT, LOCAL, without_space
from pytest_hricdv.bdi.language.syntax import TRUE, And, Comparison, Formula, Not, Or, Plan
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    FormulaTerm,
    ListTerm,
    Number,
    PlanTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
    is_ground,
    size_of,
    term_order,
)
from pytest_hricdv.bdi.logic.substitution import Bindings, Functions, free_variables, substitute, walk

Trail = list[Variable]
"""The variables bound so far, in order: undoing a trail takes its bindings back."""


def undo(bindings: Bindings, trail: Trail, mark: int) -> None:
    """Take back the bindings made since the trail had ``mark`` entries."""
    while len(trail) > mark:
        del bindings[trail.pop()]


def unify(pattern: Term, target: Term, bindings: Bindings, trail: Trail) -> bool:
    """Make two terms equal by binding variables; the annotations of the pattern must be among the target's.

    Bindings made before a failure stay: the caller undoes its trail.
    """
    if type(pattern) is Variable:
        pattern = walk(pattern, bindings)
    if type(target) is Variable:
        target = walk(target, bindings)
    if pattern is target:
        return True
    kind, other = type(pattern), type(target)
    if kind is Variable:
        return pattern == target or _bind(pattern, target, bindings, trail)  # type: ignore[arg-type]
    if other is Variable:
        return _bind(target, pattern, bindings, trail)  # type: ignore[arg-type]
    if isinstance(pattern, AnnotatedVariable):
        return _unify_annotated(pattern, target, bindings, trail)
    if kind is not other:
        if kind is QualifiedLiteral:
            return _unify_qualified(pattern, target, bindings, trail)  # type: ignore[arg-type]
        if other is QualifiedLiteral:
            return _unify_qualified(target, pattern, bindings, trail)  # type: ignore[arg-type]
        return isinstance(target, AnnotatedVariable) and _unify_annotated(target, pattern, bindings, trail)
    if isinstance(pattern, Structure) and isinstance(target, Structure):
        return _unify_structures(pattern, target, bindings, trail)
    if isinstance(pattern, ListTerm) and isinstance(target, ListTerm):
        return _unify_lists(pattern, target, bindings, trail)
    return pattern == target or (isinstance(pattern, CollectionTerm) and pattern.matches(target))


def _bind(variable: Variable, value: Term, bindings: Bindings, trail: Trail) -> bool:
    # Neither a ground term nor another variable can contain this one: most bindings need no walk through the term.
    if not is_ground(value) and type(value) is not Variable and occurs(variable, value, bindings):
        return False
    bindings[variable] = value
    trail.append(variable)
    return True


def occurs(variable: Variable, term: Term, bindings: Bindings) -> bool:
    """Occurs check: whether the variable is part of the term, so that binding it would make an infinite term."""
    pending = free_variables(term)
    while pending:
        value = walk(pending.pop(), bindings)
        if type(value) is not Variable:
            spend(1)
            pending.extend(free_variables(value))
        elif value == variable:
            return True
    return False


def _unify_structures(pattern: Structure, target: Structure, bindings: Bindings, trail: Trail) -> bool:
    if pattern.key != target.key:
        return False
    # Variables bound to each other's terms can make this continue for 2 to the power of their number.
    WORK.left -= 1
    if WORK.left < 0:
        raise too_much_work()
    for left, right in zip(pattern.args, target.args, strict=True):
        if not unify(left, right, bindings, trail):
            return False
    if not pattern.annots and pattern.annots_tail is None:
        return True
    # Only a query tries the other ways. The generator is dropped where it has yielded, before it would undo the
    # bindings of this way: so they stay.
    return next(match_annotations(pattern, target.annots, bindings, trail), False)


def match_annotations(
    pattern: Structure | AnnotatedVariable, annots: tuple[Term, ...], bindings: Bindings, trail: Trail
) -> Iterator[bool]:
    """Every way in which the annotations of the pattern are among ``annots``; the tail takes the rest."""
    return _match(pattern.annots, pattern.annots_tail, annots, bindings, trail)


def _match(
    wanted: tuple[Term, ...], tail: Variable | None, annots: tuple[Term, ...], bindings: Bindings, trail: Trail
) -> Iterator[bool]:
    mark = len(trail)
    if not wanted:
        if tail is None or unify(tail, ListTerm(annots), bindings, trail):
            yield True
        undo(bindings, trail, mark)
        return
    for index, annot in enumerate(annots):
        spend(1)
        if unify(wanted[0], annot, bindings, trail):
            # The rest without the annotation used: the tail must not take it again.
            yield from _match(wanted[1:], tail, annots[:index] + annots[index + 1 :], bindings, trail)
        undo(bindings, trail, mark)


def _unify_annotated(pattern: AnnotatedVariable, target: Term, bindings: Bindings, trail: Trail) -> bool:
    value = walk(pattern.variable, bindings)
    if not isinstance(target, Structure) or target.negated < pattern.negated:
        return False
    if not next(match_annotations(pattern, target.annots, bindings, trail), False):
        return False
    if isinstance(value, Variable):
        return _bind(value, stands_for(pattern, target), bindings, trail)
    return unify(value, _without_sign(pattern, target), bindings, trail)


def _unify_qualified(pattern: QualifiedLiteral, target: Term, bindings: Bindings, trail: Trail) -> bool:
    """Make a literal of a namespace equal to one whose namespace is known; a local one is seen by its name only."""
    if not isinstance(target, Structure):
        return False
    space, literal = without_space(target)
    if space.functor.startswith(LOCAL) and walk(pattern.space, bindings) != space:
        return False
    return unify(pattern.space, space, bindings, trail) and unify(pattern.literal, literal, bindings, trail)


def stands_for(pattern: AnnotatedVariable, target: Structure) -> Structure:
    """The literal that the variable in a pattern is bound to.

    As in Jason, a variable that is written with annotations stands for the literal without any, `~X` for one that is
    not negated.
    """
    bare = target.without_annotations() if pattern.annots or pattern.annots_tail is not None else target
    return _without_sign(pattern, bare)


def _without_sign(pattern: AnnotatedVariable, literal: Structure) -> Structure:
    if not pattern.negated:
        return literal
    return Structure(literal.functor, literal.args, literal.annots, False, literal.annots_tail)


def _unify_lists(pattern: ListTerm, target: ListTerm, bindings: Bindings, trail: Trail) -> bool:
    shared = min(len(pattern.items), len(target.items))
    spend(1 + shared)
    for left, right in zip(pattern.items[:shared], target.items[:shared], strict=True):
        if not unify(left, right, bindings, trail):
            return False
    rest, other = _rest(pattern, shared), _rest(target, shared)
    if isinstance(rest, ListTerm) and isinstance(other, ListTerm):
        # Neither ends in an open tail here: equal only if nothing is left of both.
        return rest.items == other.items and rest.tail == other.tail
    return unify(rest, other, bindings, trail)


def _rest(term: ListTerm, start: int) -> Term:
    if start == len(term.items) and term.tail is not None:
        return term.tail
    return ListTerm(term.items[start:], term.tail) if start else term


def compare(comparison: Comparison, bindings: Bindings, trail: Trail, functions: Functions) -> bool:
    """Decide a comparison; ``=`` and ``=..`` bind variables.

    Raises:
        EvaluationError: a side is an expression without a value.
    """
    left = substitute(comparison.left, bindings, functions)
    right = substitute(comparison.right, bindings, functions)
    operator = comparison.operator
    if operator == "=":
        return unify(left, right, bindings, trail)
    if operator in ("==", "\\=="):
        equal = left.matches(right) if isinstance(left, CollectionTerm) else left == right
        return equal == (operator == "==")
    if operator == "=..":
        return _univ(left, right, bindings, trail, functions)
    if isinstance(left, Number) and isinstance(right, Number):
        below, above = left < right, left > right
    else:
        spend(size_of(left) + size_of(right))
        below, above = term_order(left) < term_order(right), term_order(left) > term_order(right)
    if operator == "<":
        return below
    if operator == ">":
        return above
    return not above if operator == "<=" else not below


def _univ(left: Term, right: Term, bindings: Bindings, trail: Trail, functions: Functions) -> bool:
    """``p(a)[b] =.. [p,[a],[b]]``, to take a literal apart or to build one; with its namespace first if it has one."""
    if isinstance(left, PlanTerm) or _is_of_plan(right, bindings):
        return univ_of_plan(left, right, bindings, trail)
    has_space = isinstance(right, ListTerm) and len(right.items) == 4
    if isinstance(left, Structure):
        space, bare = without_space(left)
        spaces = (space,) if has_space or space.functor != DEFAULT else ()
        name = Structure(bare.functor, negated=bare.negated)
        return unify(ListTerm((*spaces, name, ListTerm(bare.args), ListTerm(bare.annots))), right, bindings, trail)
    if isinstance(right, ListTerm) and (has_space or len(right.items) == 3):
        functor, args, annots = (walk(item, bindings) for item in right.items[-3:])
        if isinstance(functor, Structure) and isinstance(args, ListTerm) and isinstance(annots, ListTerm):
            built: Term = Structure(functor.functor, args.items, (), functor.negated).with_annotations(annots.items)
            if has_space:
                built = substitute(QualifiedLiteral(right.items[0], built), bindings, functions)  # type: ignore[arg-type]
            return unify(left, built, bindings, trail)
    raise EvaluationError(f"neither side of {left} =.. {right} is known")


def _is_of_plan(right: Term, bindings: Bindings) -> bool:
    return (
        isinstance(right, ListTerm) and len(right.items) == 4 and isinstance(walk(right.items[3], bindings), PlanTerm)
    )


def univ_of_plan(left: Term, right: Term, bindings: Bindings, trail: Trail) -> bool:
    """``P =.. [label, { +!g }, context, { body }]``, to take a plan apart or to build one."""
    if isinstance(left, PlanTerm):
        plan = left.plan
        if not isinstance(plan, Plan) or not plan.has_label:  # as in Jason, a plan without a label is not decomposed
            return False
        context: Term = TRUE if plan.context is None else as_term(plan.context, plan.location)
        event = PlanTerm(Plan("_plan", plan.trigger, None, (), plan.location))
        parts = (Structure(plan.label, annots=plan.annots), event, context, PlanTerm(plan.body))
        return unify(ListTerm(parts), right, bindings, trail)
    assert isinstance(right, ListTerm)
    label, event_term, condition, body = (walk(item, bindings) for item in right.items)
    event_plan = event_term.plan if isinstance(event_term, PlanTerm) else None
    if not isinstance(label, Structure) or not isinstance(event_plan, Plan) or not isinstance(body, PlanTerm):
        raise EvaluationError(f"{right} is not [label, event, context, body] of a plan")
    formula: Any = condition.formula if isinstance(condition, FormulaTerm) else condition
    statements = body.plan if isinstance(body.plan, tuple) else ()
    built = Plan(label.functor, event_plan.trigger, formula, statements, event_plan.location, label.annots)
    return unify(left, PlanTerm(built), bindings, trail)


def as_term(formula: Formula, place: Location) -> Term:
    """A condition as a term: what is one already, as it is."""
    return FormulaTerm(formula, place) if isinstance(formula, (And, Or, Not, Comparison)) else formula
