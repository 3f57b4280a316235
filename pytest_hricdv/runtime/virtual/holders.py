"""Finds the references that containers, methods and the like hold, so that `modules` can replace what they refer to.

A mutable container gets another item (`items_of`); a tuple, a method and the like are made anew (`with_others`).
"""

from __future__ import annotations

import types
import weakref
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from operator import is_
from types import BuiltinMethodType
from typing import Any

from pytest_hricdv.runtime.virtual.reach import is_module

MAX_ITEMS = 1000
"""Maximum number of items of a container that are inspected; longer ones are data."""

_PLAIN_KEYS = frozenset({str, bytes, int, float, bool, type(None)})

Reference = tuple[object, Callable[[object], object]]
"""An object, and the function that puts another one in its place."""

Items = Sequence[Any]

_KINDS: dict[type, tuple[Callable[[Any], Items], Callable[[Any, Items], Any]]] = {
    frozenset: (tuple, lambda held, items: frozenset(items)),
    types.MethodType: (lambda held: (held.__func__, held.__self__), lambda held, items: _method(held, *items)),
    **dict.fromkeys(
        (BuiltinMethodType, types.MethodWrapperType),
        (
            lambda held: () if is_module(held.__self__) else (held.__self__,),
            lambda held, items: getattr(items[0], held.__name__),
        ),
    ),
    **dict.fromkeys(
        (staticmethod, classmethod),
        (lambda held: (held.__func__,), lambda held, items: type(held)(*items)),
    ),
    property: (
        lambda held: (held.fget, held.fset, held.fdel),
        lambda held, items: property(items[0], items[1], items[2], held.__doc__),
    ),
    weakref.ref: (lambda held: (held(),), lambda held, items: weakref.ref(*items)),
}
"""Class -> functions that list what an instance holds, and that make an instance with other contents."""


def contents_of(value: Any) -> Items | None:
    """What an immutable object holds; None for an object of another kind."""
    kind = type(value)
    if issubclass(kind, tuple):
        return tuple.__getitem__(value, slice(None))
    return _KINDS[kind][0](value) if kind in _KINDS else None


def with_others(value: Any, other: Callable[[Any], Any]) -> Any:
    """An object like this one, with its items replaced; the object itself if none differs.

    Args:
        other: maps an item to its replacement, or to itself.
    """
    held = contents_of(value)
    if held is None:
        return value
    items, kind = [*map(other, held)], type(value)
    if all(map(is_, items, held)):
        return value
    return tuple.__new__(kind, items) if issubclass(kind, tuple) else _KINDS[kind][1](value, items)


def _method(method: types.MethodType, function: Any, owner: Any) -> Any:
    """The method of this name of another owner; for the same owner, a method of another function."""
    return types.MethodType(function, owner) if owner is method.__self__ else getattr(owner, method.__name__)


def items_of(value: Any) -> Iterator[Reference]:
    """The items of a dictionary, list, deque or set, and the keys of a dictionary."""
    if isinstance(value, defaultdict):
        yield value.default_factory, partial(setattr, value, "default_factory")
    if isinstance(value, dict):
        for key, item in [*islice(dict.items(value), MAX_ITEMS)]:
            yield item, partial(dict.__setitem__, value, key)
            if type(key) not in _PLAIN_KEYS:
                yield key, _put_key(value, key)
    elif isinstance(value, list | deque):
        kind: Any = list if isinstance(value, list) else deque
        for n, item in enumerate([*islice(kind.__iter__(value), MAX_ITEMS)]):
            yield item, partial(kind.__setitem__, value, n)
    elif isinstance(value, set):
        for item in [*islice(set.__iter__(value), MAX_ITEMS)]:
            yield item, _put_item(value, item)


def _put_key(value: dict[Any, Any], key: object) -> Callable[[object], object]:
    def put(other: object) -> None:
        nonlocal key
        items = [(other if each is key else each, item) for each, item in value.items()]
        value.clear()
        value.update(items)
        key = other

    return put


def _put_item(value: set[Any], item: object) -> Callable[[object], object]:
    def put(other: object) -> None:
        nonlocal item
        value.discard(item)
        value.add(other)
        item = other

    return put
