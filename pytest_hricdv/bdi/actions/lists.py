"""Internal actions on lists (``.member``, ``.sort`` ...), which plans call; `internal_action` registers them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from pytest_hricdv.bdi.actions.registry import INTERNAL, MANY, WRONG, Invocation, internal_action
from pytest_hricdv.bdi.agent.intentions import Outcome
from pytest_hricdv.bdi.language.collection import CollectionTerm, SetTerm
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import ITEMS, check_text, spend
from pytest_hricdv.bdi.language.terms import (
    ListTerm,
    Number,
    String,
    Structure,
    Term,
    is_name,
    render,
    size_of,
    sort_terms,
    term_order,
)
from pytest_hricdv.bdi.logic.unify import undo


@internal_action("member", 2)
def _member(invocation: Invocation) -> Iterator[object]:
    value = invocation.value(1)
    for item in value.items() if isinstance(value, SetTerm) else invocation.items(1):
        spend(1)
        if invocation.unify(0, item):
            yield item


@internal_action("length", 2)
def _length(invocation: Invocation) -> Outcome:
    value = invocation.value(0)
    if isinstance(value, String):
        return invocation.unify(1, Number(len(value.value)))
    if isinstance(value, CollectionTerm):
        return invocation.unify(1, Number(len(value)))
    return isinstance(value, ListTerm) and invocation.unify(1, Number(len(value.items)))


@internal_action("empty", 1)
def _empty(invocation: Invocation) -> Outcome:
    value = invocation.value(0)
    if isinstance(value, CollectionTerm):
        return not len(value)
    return not value.value if isinstance(value, String) else not invocation.items(0)


@internal_action("concat", 2, MANY)
def _concat(invocation: Invocation) -> Outcome:
    values = [invocation.value(index) for index in range(len(invocation.args) - 1)]
    if isinstance(values[0], ListTerm):
        items = tuple(item for index in range(len(values)) for item in invocation.items(index))
        return invocation.unify(len(values), ListTerm(items))
    # As in Jason, a quoted name is joined without its quotes, although printing shows them.
    texts = [render(value).strip("'") if is_name(value) else render(value) for value in values]
    check_text(sum(map(len, texts)))
    text = "".join(texts)
    return invocation.unify(len(values), String(text))


@internal_action("nth", 3)
def _nth(invocation: Invocation) -> Iterator[object]:
    items = invocation.items(1)
    if invocation.is_free(0):
        for index, item in enumerate(items):
            spend(1)
            mark = len(invocation.trail)
            if invocation.unify(0, Number(index)):
                if invocation.unify(2, item):
                    yield item
                else:
                    undo(invocation.bindings, invocation.trail, mark)
        return
    index = int(invocation.number(0))
    if not 0 <= index < len(items):
        raise EvaluationError(f"{invocation.call}: no item {index} in a list of {len(items)}", INTERNAL)
    if invocation.unify(2, items[index]):
        yield items[index]


def _comparable(items: tuple[Term, ...]) -> tuple[Term, ...]:
    """Count the work of comparing these terms."""
    spend(sum(map(size_of, items), len(items)))
    return items


@internal_action("max", 2)
def _max(invocation: Invocation) -> Outcome:
    items = _comparable(invocation.items(0))
    return bool(items) and invocation.unify(1, max(items, key=term_order))


@internal_action("min", 2)
def _min(invocation: Invocation) -> Outcome:
    items = _comparable(invocation.items(0))
    return bool(items) and invocation.unify(1, min(items, key=term_order))


@internal_action("sort", 2)
def _sort(invocation: Invocation) -> Outcome:
    return invocation.unify(1, ListTerm(tuple(sorted(_comparable(invocation.items(0)), key=term_order))))


@internal_action("reverse", 2)
def _reverse(invocation: Invocation) -> Outcome:
    value = invocation.value(0)
    if isinstance(value, String):
        return invocation.unify(1, String(value.value[::-1]))
    return invocation.unify(1, ListTerm(invocation.items(0)[::-1]))


@internal_action("shuffle", 2)
def _shuffle(invocation: Invocation) -> Outcome:
    items = list(invocation.items(0))
    spend(len(items))
    # Shuffle by hand (Fisher and Yates), so that all randomness comes from the run's own stream.
    for last in range(len(items) - 1, 0, -1):
        other = int(invocation.agent.run.draw() * (last + 1))
        items[last], items[other] = items[other], items[last]
    return invocation.unify(1, ListTerm(tuple(items)))


@internal_action("range", 3, 4)
def _range(invocation: Invocation) -> Iterator[object]:
    start, end = int(invocation.number(1)), int(invocation.number(2))
    step = int(invocation.number(3)) if len(invocation.args) == 4 else 1
    if step == 0:
        raise EvaluationError(f"{invocation.call}: a range needs a step other than 0", WRONG)
    for number in range(start, end + (1 if step > 0 else -1), step):
        spend(1)
        if invocation.unify(0, Number(number)):
            yield number


@internal_action("delete", 3, 4)
def _delete(invocation: Invocation) -> Outcome:
    """``.delete(Item, List, Rest)``, by place if that is a number; ``.delete(Start, End, List, Rest)``."""
    if len(invocation.args) == 4:
        return _delete_range(invocation)
    unwanted, value = invocation.value(0), invocation.value(1)
    if isinstance(value, String):
        if isinstance(unwanted, Number):
            index = int(unwanted)
            return invocation.unify(2, String(value.value[:index] + value.value[index + 1 :]))
        return invocation.unify(2, String(value.value.replace(invocation.text(0), "")))
    items = invocation.items(1)
    if isinstance(unwanted, Number):
        index = int(unwanted)
        return invocation.unify(2, ListTerm(items[:index] + items[index + 1 :]))
    spend(len(items))
    # As in Jason, the first item that matches binds the variables of the pattern: the others must be equal to that one.
    mark = len(invocation.trail)
    kept = tuple(item for item in items if not invocation.unify(0, item))
    undo(invocation.bindings, invocation.trail, mark)
    return invocation.unify(2, ListTerm(kept))


def _delete_range(invocation: Invocation) -> Outcome:
    start, end, value = int(invocation.number(0)), int(invocation.number(1)), invocation.value(2)
    end = max(start, end)
    if isinstance(value, String):
        return invocation.unify(3, String(value.value[:start] + value.value[end:]))
    items = invocation.items(2)
    return invocation.unify(3, ListTerm(items[:start] + items[end:]))


@internal_action("union", 3)
def _union(invocation: Invocation) -> Outcome:
    return invocation.unify(2, ListTerm(sort_terms(_comparable(invocation.items(0) + invocation.items(1)))))


@internal_action("intersection", 3)
def _intersection(invocation: Invocation) -> Outcome:
    return _select(invocation, in_other=True)


@internal_action("difference", 3)
def _difference(invocation: Invocation) -> Outcome:
    return _select(invocation, in_other=False)


def _select(invocation: Invocation, *, in_other: bool) -> bool:
    """The items of the first list that are in the second, or are not."""
    other, items = invocation.items(1), invocation.items(0)
    spend(len(items) * (1 + len(other) // ITEMS))
    return invocation.unify(2, ListTerm(sort_terms(tuple(item for item in items if (item in other) is in_other))))


def _any_of(invocation: Invocation, lists: Iterable[tuple[Term, ...]]) -> Iterator[object]:
    """A solution for each of these lists that the first argument unifies with."""
    for items in lists:
        spend(1)
        if invocation.unify(0, ListTerm(items)):
            yield items


@internal_action("prefix", 2)
def _prefix(invocation: Invocation) -> Iterator[object]:
    items = invocation.items(1)
    return _any_of(invocation, (items[:end] for end in range(len(items), -1, -1)))


@internal_action("suffix", 2)
def _suffix(invocation: Invocation) -> Iterator[object]:
    items = invocation.items(1)
    return _any_of(invocation, (items[start:] for start in range(len(items) + 1)))


@internal_action("sublist", 2)
def _sublist(invocation: Invocation) -> Iterator[object]:
    items = invocation.items(1)
    # In Jason's order: those that begin with the first item come first, and of these the longest.
    places = ((start, end) for start in range(len(items)) for end in range(len(items), start, -1))
    return _any_of(invocation, chain((items[start:end] for start, end in places), [()]))


@internal_action("all_names", 1)
def _all_names(invocation: Invocation) -> Outcome:
    return invocation.unify(0, ListTerm(tuple(Structure(name) for name in invocation.agent.run.agents)))
