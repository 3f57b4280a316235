"""Internal actions on terms and strings: ``.ground``, ``.copy_term``, ``.add_annot``, ``.substring`` and others.

`internal_action` registers these functions, and `call_action` calls one with an `Invocation`: a call from a plan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import count

from pytest_hricdv.bdi.actions.registry import WRONG, Invocation, internal_action, is_function
from pytest_hricdv.bdi.agent.intentions import Outcome
from pytest_hricdv.bdi.agent.messages import is_source, text_of, with_source
from pytest_hricdv.bdi.language.collection import MapTerm, QueueTerm, SetTerm
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import check_text, spend
from pytest_hricdv.bdi.language.parser import parse_term
from pytest_hricdv.bdi.language.terms import (
    Call,
    ListTerm,
    Number,
    PlanTerm,
    String,
    Structure,
    Term,
    Variable,
    is_ground,
)
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_only
from pytest_hricdv.bdi.logic.unify import undo


def _is_atom(value: Term) -> bool:
    return isinstance(value, Structure) and not value.args and not value.annots and not value.negated


def _is_structure(value: Term) -> bool:
    return isinstance(value, ListTerm) or (isinstance(value, Structure) and not _is_atom(value))


def _is_a(expected: type[object]) -> Callable[[Term], bool]:
    return lambda value: isinstance(value, expected)


_TESTS: dict[str, Callable[[Term], bool]] = {
    "ground": is_ground,
    "number": _is_a(Number),
    "string": _is_a(String),
    "var": _is_a(Variable),
    "atom": _is_atom,
    "structure": _is_structure,
    "literal": _is_a(Structure),
    "list": _is_a(ListTerm),
}
"""Actions that test the kind of a term: name -> test."""


def _test(invocation: Invocation, holds: Callable[[Term], bool]) -> Outcome:
    return holds(invocation.value(0))


for _name, _holds in _TESTS.items():
    internal_action(_name, 1)(partial(_test, holds=_holds))


@internal_action("type", 2)
def _type(invocation: Invocation) -> Iterator[object]:
    """``.type(Term, Kind)``, one kind a solution, the narrowest first."""
    value = invocation.value(0)
    kinds = {
        "number": isinstance(value, Number),
        "atom": _is_atom(value),
        "literal": isinstance(value, (Structure, PlanTerm)),
        "string": isinstance(value, String),
        "list": isinstance(value, ListTerm),
        "set": isinstance(value, SetTerm),
        "map": isinstance(value, MapTerm),
        "structure": _is_structure(value),
        "plan": isinstance(value, PlanTerm),
        "queue": isinstance(value, QueueTerm),
        "ground": is_ground(value),
        "free": isinstance(value, Variable),
    }
    for kind, holds in kinds.items():
        if holds and invocation.unify(1, Structure(kind)):
            yield kind


@internal_action("copy_term", 2)
@internal_action("rename_apart", 2)
def _copy_term(invocation: Invocation) -> Outcome:
    """A copy in which each variable without a value is another one."""
    term = invocation.value(0)
    fresh: Bindings = {variable: invocation.agent.fresh() for variable in free_variables(term)}
    return invocation.unify(1, substitute_only(term, fresh))


def _annotate(term: Term, change: Callable[[Structure], Structure]) -> Term:
    """A literal, or each literal of a list, with other annotations; other terms have none."""
    if isinstance(term, ListTerm):
        return ListTerm(tuple(_annotate(item, change) for item in term.items), term.tail)
    return change(term) if isinstance(term, Structure) else term


@internal_action("add_annot", 3)
def _add_annot(invocation: Invocation) -> Outcome:
    term, annot = invocation.value(0), invocation.value(1)
    return invocation.unify(2, _annotate(term, lambda literal: literal.with_annotations((*literal.annots, annot))))


@internal_action("add_nested_source", 3)
def _add_nested_source(invocation: Invocation) -> Outcome:
    """The sources so far become those of the new one: of ``a[source(b)]`` and c, ``a[source(c)[source(b)]]``."""
    term, agent = invocation.value(0), text_of(invocation.value(1))
    return invocation.unify(2, _annotate(term, lambda literal: with_source(literal, agent)))


@internal_action("remove_source_annot", 2)
def _remove_source_annot(invocation: Invocation) -> Outcome:
    """A literal, or each of a list, without its sources."""

    def strip(literal: Structure) -> Structure:
        return literal.with_annotations(
            tuple(annot for annot in literal.annots if not is_source(annot)), literal.annots_tail
        )

    return invocation.unify(1, _annotate(invocation.value(0), strip))


@internal_action("internal_action", 1)
def _internal_action(invocation: Invocation) -> Outcome:
    return isinstance(invocation.args[0], Call) and not is_function(invocation.args[0])


@internal_action("version", 1)
def _version(invocation: Invocation) -> Outcome:
    """The version of Jason that has the newest of the actions here, including this one."""
    return invocation.unify(0, String("3.3"))


@internal_action("my_name", 1)
def _my_name(invocation: Invocation) -> Outcome:
    return invocation.unify(0, Structure(invocation.agent.name))


@internal_action("random", 1, 2)
def _random(invocation: Invocation) -> Outcome:
    """``.random(X)``, a number; ``.random(X, 5)``, up to five, one a solution; ``.random(Items, X)``, one of a list."""
    if len(invocation.args) == 1:
        return invocation.unify(0, Number(invocation.agent.run.draw()))
    if not isinstance(invocation.value(0), ListTerm):
        return _several_random(invocation, int(invocation.number(1)))
    drawn, items = invocation.agent.run.draw(), invocation.items(0)
    return bool(items) and invocation.unify(1, items[int(drawn * len(items))])


def _several_random(invocation: Invocation, most: int) -> Iterator[object]:
    """Numbers without end if asked for none."""
    for number in count() if most == 0 else range(most):
        spend(1)
        if invocation.unify(0, Number(invocation.agent.run.draw())):
            yield number


@internal_action("substring", 2, 4)
def _find_text(invocation: Invocation) -> Iterator[object]:
    """Where the first argument is in the second; if either is free, what is between two places of the other.

    The fourth argument is the index of the last character in a search for the text, otherwise the index after it.
    """
    part_is_free = invocation.is_free(0)
    if len(invocation.args) > 2 and (part_is_free or invocation.is_free(1)) and not invocation.is_free(2):
        whole = invocation.text(part_is_free)
        start = int(invocation.number(2))
        end = int(invocation.number(3)) if len(invocation.args) == 4 else len(whole)
        if not 0 <= start <= end <= len(whole):
            raise EvaluationError(f"{invocation.call}: no places {start} to {end} in {len(whole)} characters", WRONG)
        if invocation.unify(not part_is_free, String(whole[start:end])):
            yield start
        return
    part, text = invocation.text(0), invocation.text(1)
    start = text.find(part)
    while start >= 0:
        spend(1)
        mark = len(invocation.trail)
        start_matches = len(invocation.args) < 3 or invocation.unify(2, Number(start))
        if start_matches and (len(invocation.args) < 4 or invocation.unify(3, Number(start + len(part) - 1))):
            yield start
        else:
            undo(invocation.bindings, invocation.trail, mark)
        start = text.find(part, start + 1)


@internal_action("replace", 4)
def _replace_text(invocation: Invocation) -> Outcome:
    text, old, new = invocation.text(0), invocation.text(1), invocation.text(2)
    check_text(len(text) + text.count(old) * len(new))
    return invocation.unify(3, String(text.replace(old, new)))


@internal_action("lower_case", 2)
def _lower_case(invocation: Invocation) -> Outcome:
    return invocation.unify(1, String(invocation.text(0).lower()))


@internal_action("upper_case", 2)
def _upper_case(invocation: Invocation) -> Outcome:
    return invocation.unify(1, String(invocation.text(0).upper()))


@internal_action("term2string", 2)
def _term2string(invocation: Invocation) -> Outcome:
    if invocation.is_free(0):
        return invocation.unify(0, invocation.read(invocation.text(1), parse_term, "unknown"))
    return invocation.unify(1, String(str(invocation.value(0))))
