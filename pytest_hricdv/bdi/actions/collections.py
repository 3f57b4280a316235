"""Internal actions on sets, maps and queues, as in Jason 3."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from pytest_hricdv.bdi.actions.registry import WRONG, Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.language.collection import Collection, MapTerm, QueueTerm, SetTerm
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import ITEMS, spend
from pytest_hricdv.bdi.language.terms import ListTerm, Term, Variable, term_order

Kind = TypeVar("Kind", bound=Collection)


def _changed(invocation: Invocation) -> bool:
    """What waits for a condition may hold now."""
    invocation.agent.run.progress += 1
    invocation.agent.beliefs.version += 1
    return True


def _create(invocation: Invocation, collection: Collection) -> bool:
    return invocation.is_free(0) and invocation.unify(0, collection)


def _collection(invocation: Invocation, kind: type[Kind], new: Callable[[], Kind] | None = None) -> Kind:
    """The first argument; a variable without a value is bound to a new one, where there may be one.

    Raises:
        EvaluationError: it is something else.
    """
    value = invocation.value(0)
    if isinstance(value, Variable) and new is not None:
        value = new()
        invocation.unify(0, value)
    if not isinstance(value, kind):
        name = kind.__name__.removesuffix("Term").lower()
        # As in Jason, where nothing checks the kind: a failure of no kind of its own.
        raise EvaluationError(f"{invocation.call}: argument 1 is not a {name} but {value}", "unknown")
    return value


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


def _set(invocation: Invocation) -> SetTerm:
    return _collection(invocation, SetTerm, lambda: SetTerm(term_order))


def _map(invocation: Invocation) -> MapTerm:
    return _collection(invocation, MapTerm, lambda: MapTerm(term_order))


def _queue(invocation: Invocation) -> QueueTerm:
    return _collection(invocation, QueueTerm)


# --- sets


@internal_action("set.create", 1, inspects=True)
def _set_create(invocation: Invocation) -> Outcome:
    return _create(invocation, SetTerm(term_order))


@internal_action("set.add", 2, inspects=True)
def _set_add(invocation: Invocation) -> Outcome:
    _set(invocation).add([invocation.value(1)])
    return _changed(invocation)


@internal_action("set.add_all", 2, inspects=True)
def _set_add_all(invocation: Invocation) -> Outcome:
    _set(invocation).add(_terms(invocation, 1))
    return _changed(invocation)


@internal_action("set.union", 2, inspects=True)
def _set_union(invocation: Invocation) -> Outcome:
    return _set_add_all(invocation)


@internal_action("set.intersection", 2, inspects=True)
def _set_intersection(invocation: Invocation) -> Outcome:
    wanted = frozenset(_terms(invocation, 1))
    _set(invocation).keep(lambda term: term in wanted)
    return _changed(invocation)


@internal_action("set.difference", 2, inspects=True)
def _set_difference(invocation: Invocation) -> Outcome:
    unwanted = frozenset(_terms(invocation, 1))
    _set(invocation).keep(lambda term: term not in unwanted)
    return _changed(invocation)


@internal_action("set.remove", 2, inspects=True)
def _set_remove(invocation: Invocation) -> Outcome:
    _set(invocation).content.pop(invocation.value(1), None)
    return _changed(invocation)


@internal_action("set.clear", 1, inspects=True)
def _set_clear(invocation: Invocation) -> Outcome:
    _set(invocation).content.clear()
    return _changed(invocation)


@internal_action("set.copy", 2, inspects=True)
def _set_copy(invocation: Invocation) -> Outcome:
    return invocation.unify(1, _set(invocation).copy())


@internal_action("set.to_list", 2, inspects=True)
def _set_to_list(invocation: Invocation) -> Outcome:
    return invocation.unify(1, ListTerm(_set(invocation).items()))


# --- maps


@internal_action("map.create", 1, inspects=True)
def _map_create(invocation: Invocation) -> Outcome:
    return _create(invocation, MapTerm(term_order))


@internal_action("map.put", 3, inspects=True)
def _map_put(invocation: Invocation) -> Outcome:
    spend(1)
    _map(invocation).content[invocation.value(1)] = invocation.value(2)
    return _changed(invocation)


@internal_action("map.get", 3, 4, inspects=True)
def _map_get(invocation: Invocation) -> Outcome:
    """``.map.get(M, Key, Value)``; the fourth argument is the value where there is no such key."""
    value: Term | None = _map(invocation).content.get(invocation.value(1))
    if value is None and len(invocation.args) == 4:
        value = invocation.value(3)
    return value is not None and invocation.unify(2, value)


@internal_action("map.remove", 3, inspects=True)
def _map_remove(invocation: Invocation) -> Outcome:
    value: Term | None = _map(invocation).content.pop(invocation.value(1), None)
    _changed(invocation)
    return value is not None and invocation.unify(2, value)


@internal_action("map.key", 2, inspects=True)
def _map_key(invocation: Invocation) -> Iterator[object]:
    return _any_of(invocation, 1, _map(invocation).items())


@internal_action("map.value", 2, inspects=True)
def _map_value(invocation: Invocation) -> Iterator[object]:
    entries = _map(invocation)
    return _any_of(invocation, 1, [entries.content[key] for key in entries.items()])


@internal_action("map.clear", 1, inspects=True)
def _map_clear(invocation: Invocation) -> Outcome:
    _map(invocation).content.clear()
    return _changed(invocation)


@internal_action("map.copy", 2, inspects=True)
def _map_copy(invocation: Invocation) -> Outcome:
    return invocation.unify(1, _map(invocation).copy())


# --- queues


@internal_action("queue.create", 1, 2, inspects=True)
def _queue_create(invocation: Invocation) -> Outcome:
    """``.queue.create(Q)``, or ``.queue.create(Q, priority)`` for one in which the least term is the first."""
    priority = len(invocation.args) == 2 and invocation.text(1) == "priority"
    return _create(invocation, QueueTerm(term_order if priority else None))


@internal_action("queue.add", 2, inspects=True)
def _queue_add(invocation: Invocation) -> Outcome:
    _queue(invocation).add(invocation.value(1))
    return _changed(invocation)


@internal_action("queue.add_all", 2, inspects=True)
def _queue_add_all(invocation: Invocation) -> Outcome:
    for item in invocation.items(1):
        _queue(invocation).add(item)
    return _changed(invocation)


@internal_action("queue.head", 2, inspects=True)
def _queue_head(invocation: Invocation) -> Outcome:
    items = _queue(invocation).content
    return bool(items) and invocation.unify(1, items[0])


@internal_action("queue.remove", 2, inspects=True)
def _queue_remove(invocation: Invocation) -> Outcome:
    queue = _queue(invocation)
    if not queue.content:
        return False
    first: Term = queue.remove()
    _changed(invocation)
    return invocation.unify(1, first)


@internal_action("queue.clear", 1, inspects=True)
def _queue_clear(invocation: Invocation) -> Outcome:
    _queue(invocation).content.clear()
    return _changed(invocation)


@internal_action("queue.copy", 2, inspects=True)
def _queue_copy(invocation: Invocation) -> Outcome:
    return invocation.unify(1, _queue(invocation).copy())


@internal_action("queue.to_list", 2, inspects=True)
def _queue_to_list(invocation: Invocation) -> Outcome:
    return invocation.unify(1, ListTerm(_queue(invocation).items()))
