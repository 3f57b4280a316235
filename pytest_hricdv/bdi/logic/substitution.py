"""`substitute` replaces the variables of a term by the values that `Bindings` give them, and evaluates its expressions.

`walk` gives the value of one variable, `rename_apart` new names. Agents, queries and unification use the module.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from pytest_hricdv.bdi.language.limits import WORK, spend
from pytest_hricdv.bdi.language.namespaces import in_space
from pytest_hricdv.bdi.language.syntax import And, Comparison, Formula, Not, Or
from pytest_hricdv.bdi.language.syntax_tree import condition_with_values, variables_of, with_values
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Arithmetic,
    Call,
    FormulaTerm,
    ListTerm,
    Number,
    PlanTerm,
    QualifiedLiteral,
    String,
    Structure,
    Term,
    Variable,
    is_ground,
    sort_terms,
)

Bindings = dict[Variable, Term]
Functions = Callable[[Call, Bindings], Term]
"""Gives the value of a function such as ``math.abs(X)`` in an expression."""


def walk(term: Term, bindings: Bindings) -> Term:
    """The final value of a variable; any other term unchanged."""
    # Chains of variables arise where rules call rules; they are short, and shortening them would need undoing.
    while type(term) is Variable:
        value = bindings.get(term)
        if value is None:
            return term
        term = value
    return term


def substitute(term: Term, bindings: Bindings, functions: Functions) -> Term:
    """The term with its variables replaced by their values and its expressions evaluated.

    Raises:
        EvaluationError: an expression over something that is not a number.
    """
    # The kinds of terms in the order in which they are most frequent.
    kind = type(term)
    if kind is Number or kind is String:
        return term
    if kind is Variable:
        value: Term | None = bindings.get(term)  # type: ignore[arg-type]
        if value is None:
            return term
        if type(value) is Number:
            return value
        value = walk(value, bindings)
        return value if type(value) is Variable or is_ground(value) else substitute(value, bindings, functions)
    if type(term) is Arithmetic:
        result = term.value(substitute_all(term.operands, bindings, functions))
        return functions(result, bindings) if type(result) is Call else result
    if isinstance(term, Structure):
        return term if term.ground else _substitute_structure(term, bindings, functions)
    if isinstance(term, ListTerm):
        if term.ground:
            return term
        spend(len(term.items))
        items = substitute_all(term.items, bindings, functions)
        return ListTerm(items, None if term.tail is None else substitute(term.tail, bindings, functions))
    if isinstance(term, Call):
        return functions(term, bindings)
    if isinstance(term, AnnotatedVariable):
        return _substitute_annotated(term, bindings, functions)
    if isinstance(term, QualifiedLiteral):
        space, literal = (substitute(part, bindings, functions) for part in (term.space, term.literal))
        return in_space(space, literal, term)
    if isinstance(term, FormulaTerm):
        return condition_with_values(term, partial(substitute, bindings=bindings, functions=functions))
    if isinstance(term, PlanTerm):
        return with_values(term, partial(substitute, bindings=bindings, functions=functions))
    return term


def substitute_all(terms: tuple[Term, ...], bindings: Bindings, functions: Functions) -> tuple[Term, ...]:
    """Each term as :func:`substitute` gives it."""
    values = []
    # A comprehension would be one more call, and this function is called most often of all.
    for term in terms:
        values.append(term if type(term) is Number else substitute(term, bindings, functions))  # noqa: PERF401
    return tuple(values)


def _substitute_structure(term: Structure, bindings: Bindings, functions: Functions) -> Structure:
    WORK.left -= 1  # the size of terms ends what would continue without end
    args = substitute_all(term.args, bindings, functions)
    if not term.annots and term.annots_tail is None:
        return Structure(term.functor, args, (), term.negated)
    annots, tail = _substitute_annots(term, bindings, functions)
    return Structure(term.functor, args, sort_terms(annots), term.negated, tail)


def _substitute_annots(
    term: Structure | AnnotatedVariable, bindings: Bindings, functions: Functions
) -> tuple[tuple[Term, ...], Variable | None]:
    annots = substitute_all(term.annots, bindings, functions)
    tail = term.annots_tail
    if tail is not None:
        rest = substitute(tail, bindings, functions)
        if isinstance(rest, ListTerm):
            return annots + rest.items, rest.tail if isinstance(rest.tail, Variable) else None
        tail = rest if isinstance(rest, Variable) else None
    return annots, tail


def _substitute_annotated(term: AnnotatedVariable, bindings: Bindings, functions: Functions) -> Term:
    value = substitute(term.variable, bindings, functions)
    annots, tail = _substitute_annots(term, bindings, functions)
    if isinstance(value, Structure):
        negated = value.negated or term.negated
        return Structure(value.functor, value.args, (), negated).with_annotations(value.annots + annots, tail)
    if isinstance(value, Variable):
        return AnnotatedVariable(value, annots, tail, term.negated)
    return value


def substitute_only(term: Term, bindings: Bindings) -> Term:
    """Replace variables once, leaving expressions as they are."""
    if isinstance(term, Variable):
        return bindings.get(term, term)
    if isinstance(term, Structure):
        if term.ground:
            return term
        args = tuple(substitute_only(arg, bindings) for arg in term.args)
        annots = tuple(substitute_only(annot, bindings) for annot in term.annots)
        tail = None if term.annots_tail is None else bindings.get(term.annots_tail, term.annots_tail)
        return Structure(term.functor, args, annots, term.negated, tail if isinstance(tail, Variable) else None)
    if isinstance(term, ListTerm):
        items = tuple(substitute_only(item, bindings) for item in term.items)
        return ListTerm(items, None if term.tail is None else substitute_only(term.tail, bindings))
    if isinstance(term, Arithmetic):
        return Arithmetic(term.operator, tuple(substitute_only(operand, bindings) for operand in term.operands))
    if isinstance(term, AnnotatedVariable):
        value = bindings.get(term.variable, term.variable)
        annots = tuple(substitute_only(annot, bindings) for annot in term.annots)
        variable = value if isinstance(value, Variable) else term.variable
        return AnnotatedVariable(variable, annots, term.annots_tail, term.negated)
    if isinstance(term, QualifiedLiteral):
        space, literal = (substitute_only(part, bindings) for part in (term.space, term.literal))
        return in_space(space, literal, term)
    if isinstance(term, Call):
        return _rename_term(term, bindings)
    if isinstance(term, FormulaTerm):
        return FormulaTerm(rename_formula(term.formula, bindings), term.location)  # type: ignore[arg-type]
    return term


def rename_apart(term: Term, prefix: str) -> Term:
    """The term with a prefix to its variables' names, so that it shares none with another term."""
    return substitute_only(term, {variable: Variable(prefix + variable) for variable in free_variables(term)})


def rename_formula(formula: Formula, renaming: Bindings) -> Formula:
    """The formula with its variables replaced as ``renaming`` says."""
    if isinstance(formula, And):
        return And(tuple(rename_formula(part, renaming) for part in formula.parts))
    if isinstance(formula, Or):
        return Or(tuple(rename_formula(part, renaming) for part in formula.parts))
    if isinstance(formula, Not):
        return Not(rename_formula(formula.part, renaming))
    if isinstance(formula, Comparison):
        left, right = _rename_term(formula.left, renaming), _rename_term(formula.right, renaming)
        return Comparison(formula.operator, left, right)
    return _rename_term(formula, renaming)  # type: ignore[return-value]


def _rename_term(term: Term, renaming: Bindings) -> Term:
    if isinstance(term, Call):
        return Call(term.name, tuple(rename_formula(arg, renaming) for arg in term.args), term.location)  # type: ignore[arg-type]
    if isinstance(term, Arithmetic):
        return Arithmetic(term.operator, tuple(_rename_term(operand, renaming) for operand in term.operands))
    return substitute_only(term, renaming)


def _free_variables(term: Term) -> list[Variable]:
    """The variables of a term in order of appearance."""
    variables: dict[Variable, None] = {}
    pending: list[Term | None] = [term]
    while pending:
        WORK.left -= 1
        part = pending.pop()
        if isinstance(part, Variable):
            variables[part] = None
        elif isinstance(part, Structure) and not part.ground:
            pending.extend((part.annots_tail, *reversed(part.annots), *reversed(part.args)))
        elif isinstance(part, ListTerm) and not part.ground:
            pending.extend((part.tail, *reversed(part.items)))
        elif isinstance(part, Arithmetic):
            pending.extend(reversed(part.operands))
        elif isinstance(part, QualifiedLiteral):
            pending.extend((part.literal, part.space))
        elif isinstance(part, AnnotatedVariable):
            pending.extend((part.annots_tail, *reversed(part.annots), part.variable))
        elif isinstance(part, (PlanTerm, Call, FormulaTerm)):
            variables.update(dict.fromkeys(sorted(variables_of(part))))
    return list(variables)


def free_variables(term: Term) -> list[Variable]:
    """The variables of a term in order of appearance."""
    return [] if is_ground(term) or isinstance(term, String) else _free_variables(term)
