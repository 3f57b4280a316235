"""Internal actions on sets, maps and queues (``.set.add`` ...), which plans call; `internal_action` registers them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TypeVar

from pytest_hricdv.bdi.actions.registry import WRONG, Invocation, internal_action
from pytest_hricdv.bdi.agent.intentions import Outcome
from pytest_hricdv.bdi.language.collection import CollectionTerm, MapTerm, QueueTerm, SetTerm
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import ITEMS, spend
from pytest_hricdv.bdi.language.terms import ListTerm, Term, term_order

AnyCollection = TypeVar("AnyCollection", bound=CollectionTerm)
_collection_action = partial(internal_action, inspects=True)


def _note_change(invocation: Invocation) -> bool:
    """Note that conditions that intentions wait for may hold now."""
    invocation.agent.run.progress += 1
    invocation.agent.beliefs.version += 1
    return True


def _create(invocation: Invocation, collection: CollectionTerm) -> bool:
    return invocation.is_free(0) and invocation.unify(0, collection)


def _collection(invocation: Invocation, expected: type[AnyCollection]) -> AnyCollection:
    """The first argument; a variable without a value is bound to a new set or map, but not to a new queue."""
    if expected is not QueueTerm and invocation.is_free(0):
        invocation.unify(0, expected(term_order))
    # As in Jason, where nothing checks the type: a failure of no kind of its own.
    return invocation.argument(0, expected, f"a {expected.NAME}", "unknown")


def _terms(invocation: Invocation, index: int) -> tuple[Term, ...]:
    """The terms in a list or in a set."""
    value = invocation.value(index)
    if isinstance(value, SetTerm):
        return value.items()
    if isinstance(value, ListTerm):
        spend(len(value.items) // ITEMS)
        return value.items
    raise EvaluationError(f"{invocation.call}: argument {index + 1} is not a list or set but {value}", WRONG)


def _any_of(invocation: Invocation, index: int, terms: Iterable[Term]) -> Iterator[object]:
    for term in terms:
        spend(1)
        if invocation.unify(index, term):
            yield term


# --- what there is for all of them


def _create_empty(invocation: Invocation, expected: type[CollectionTerm]) -> Outcome:
    return _create(invocation, expected(term_order))


def _clear(invocation: Invocation, expected: type[CollectionTerm]) -> Outcome:
    _collection(invocation, expected).content.clear()
    return _note_change(invocation)


def _copy(invocation: Invocation, expected: type[CollectionTerm]) -> Outcome:
    return invocation.unify(1, _collection(invocation, expected).copy())


def _to_list(invocation: Invocation, expected: type[CollectionTerm]) -> Outcome:
    return invocation.unify(1, ListTerm(_collection(invocation, expected).items()))


for _type in (SetTerm, MapTerm, QueueTerm):
    _collection_action(f"{_type.NAME}.clear", 1)(partial(_clear, expected=_type))
    _collection_action(f"{_type.NAME}.copy", 2)(partial(_copy, expected=_type))
    if _type is not QueueTerm:
        _collection_action(f"{_type.NAME}.create", 1)(partial(_create_empty, expected=_type))
    if _type is not MapTerm:
        _collection_action(f"{_type.NAME}.to_list", 2)(partial(_to_list, expected=_type))


# --- sets


@_collection_action("set.add", 2)
def _set_add(invocation: Invocation) -> Outcome:
    _collection(invocation, SetTerm).add([invocation.value(1)])
    return _note_change(invocation)


@_collection_action("set.add_all", 2)
@_collection_action("set.union", 2)
def _set_add_all(invocation: Invocation) -> Outcome:
    _collection(invocation, SetTerm).add(_terms(invocation, 1))
    return _note_change(invocation)


@_collection_action("set.intersection", 2)
def _set_intersection(invocation: Invocation) -> Outcome:
    return _keep(invocation, lambda term, terms: term in terms)


@_collection_action("set.difference", 2)
def _set_difference(invocation: Invocation) -> Outcome:
    return _keep(invocation, lambda term, terms: term not in terms)


def _keep(invocation: Invocation, is_wanted: Callable[[Term, frozenset[Term]], bool]) -> bool:
    terms = frozenset(_terms(invocation, 1))
    _collection(invocation, SetTerm).keep(lambda term: is_wanted(term, terms))
    return _note_change(invocation)


@_collection_action("set.remove", 2)
def _set_remove(invocation: Invocation) -> Outcome:
    _collection(invocation, SetTerm).content.pop(invocation.value(1), None)
    return _note_change(invocation)


# --- maps


@_collection_action("map.put", 3)
def _map_put(invocation: Invocation) -> Outcome:
    spend(1)
    _collection(invocation, MapTerm).content[invocation.value(1)] = invocation.value(2)
    return _note_change(invocation)


@_collection_action("map.get", 3, 4)
def _map_get(invocation: Invocation) -> Outcome:
    """``.map.get(M, Key, Value)``; the fourth argument is the value where there is no such key."""
    value: Term | None = _collection(invocation, MapTerm).content.get(invocation.value(1))
    if value is None and len(invocation.args) == 4:
        value = invocation.value(3)
    return value is not None and invocation.unify(2, value)


@_collection_action("map.remove", 3)
def _map_remove(invocation: Invocation) -> Outcome:
    value: Term | None = _collection(invocation, MapTerm).content.pop(invocation.value(1), None)
    _note_change(invocation)
    return value is not None and invocation.unify(2, value)


@_collection_action("map.key", 2)
def _map_key(invocation: Invocation) -> Iterator[object]:
    return _any_of(invocation, 1, _collection(invocation, MapTerm).items())


@_collection_action("map.value", 2)
def _map_value(invocation: Invocation) -> Iterator[object]:
    entries = _collection(invocation, MapTerm)
    return _any_of(invocation, 1, [entries.content[key] for key in entries.items()])


# --- queues


@_collection_action("queue.create", 1, 2)
def _queue_create(invocation: Invocation) -> Outcome:
    """``.queue.create(Q)``, or ``.queue.create(Q, priority)`` for one in which the least term is the first."""
    priority = len(invocation.args) == 2 and invocation.text(1) == "priority"
    return _create(invocation, QueueTerm(term_order if priority else None))


@_collection_action("queue.add", 2)
def _queue_add(invocation: Invocation) -> Outcome:
    _collection(invocation, QueueTerm).add(invocation.value(1))
    return _note_change(invocation)


@_collection_action("queue.add_all", 2)
def _queue_add_all(invocation: Invocation) -> Outcome:
    for item in invocation.items(1):
        _collection(invocation, QueueTerm).add(item)
    return _note_change(invocation)


@_collection_action("queue.head", 2)
def _queue_head(invocation: Invocation) -> Outcome:
    items = _collection(invocation, QueueTerm).content
    return bool(items) and invocation.unify(1, items[0])


@_collection_action("queue.remove", 2)
def _queue_remove(invocation: Invocation) -> Outcome:
    queue = _collection(invocation, QueueTerm)
    if not queue.content:
        return False
    first: Term = queue.remove()
    _note_change(invocation)
    return invocation.unify(1, first)
