"""Finds references to objects that are to be replaced: globals, attributes, defaults, closures, containers.

`modules` replaces what `ReferenceSearch` finds. `stand_in` and `copy` make modules like those of Python's library, with
other names or imports.
"""

from __future__ import annotations

import builtins
import gc
import importlib.util
import sys
from collections import OrderedDict, defaultdict, deque
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from contextvars import ContextVar
from functools import partial
from types import (
    AsyncGeneratorType,
    BuiltinFunctionType,
    CellType,
    CoroutineType,
    FunctionType,
    GeneratorType,
    MappingProxyType,
    MemberDescriptorType,
    ModuleType,
)
from typing import Any

from pytest_hricdv.runtime.virtual.holders import MAX_ITEMS, Reference, contents_of, items_of
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError


def stand_in(real: ModuleType, names: Mapping[str, Any]) -> ModuleType:
    """A module like a real one, but for these names."""
    made = ModuleType(real.__name__, real.__doc__)
    vars(made).update({**vars(real), **names})
    return made


def copy(name: str, imports: Mapping[str, ModuleType]) -> ModuleType:
    """A module of Python's library, loaded once more from its source, for which these modules stand for others.

    So Python's own queues wait on our locks: nothing of them is written again, and they are those of its version.
    """
    spec = importlib.util.find_spec(name)
    assert spec is not None
    assert spec.loader is not None

    def import_module(
        wanted: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
    ) -> Any:
        return imports.get(wanted) or builtins.__import__(wanted, globals, locals, fromlist or (), level)

    made = importlib.util.module_from_spec(spec)
    vars(made)["__builtins__"] = {**vars(builtins), "__import__": import_module}
    spec.loader.exec_module(made)
    return made


_CONTAINERS = (dict, OrderedDict, defaultdict, list, deque, set)
_CLOSED = (GeneratorType, CoroutineType, AsyncGeneratorType, ContextVar, MappingProxyType)
"""Classes of objects whose contents nobody can replace; only Python's collector of garbage tells them."""
_PLAIN = frozenset({"builtins", "collections", "enum", "functools", "sched", "types", "weakref"})
"""Modules of Python's library whose objects are looked into. Others, as of `logging`, serve the session, too."""

MAX_DEPTH = 6
"""Objects in objects of a module's globals that are looked into: a client in a registry in a dataclass is at 4."""


class ReferenceSearch:
    """Looks for references in modules.

    Args:
        is_wanted: whether an object is to be replaced.
        modules: names of the modules whose functions, classes and objects are looked into; all others are left alone.
    """

    def __init__(self, is_wanted: Callable[[object], bool], modules: Container[object]) -> None:
        self._is_wanted = is_wanted
        self._modules = modules
        self._seen: dict[int, object] = {}
        """What was looked into, by identity: it is kept, as another object would get the identity."""
        self._holding: set[int] = set()
        """Identities of objects that keep what is wanted, and cannot be changed."""
        self._names: dict[str, Any] = {}
        self._name = ""

    def find(self, names: dict[str, Any]) -> Iterator[Reference]:
        """References in the globals of a module."""
        self._names = names
        for name, value in [*names.items()]:
            self._name = name
            yield from self._look(value, partial(names.__setitem__, name), 0)

    def _look(self, value: object, put: Callable[[object], object], depth: int) -> Iterator[Reference]:
        if self._is_wanted(value) or id(value) in self._holding:
            yield value, put
        elif depth <= MAX_DEPTH and id(value) not in self._seen:
            self._seen[id(value)] = value
            held, holds = contents_of(value), False
            for item, put_item in self._items(value) if held is None else ((item, _hold) for item in held[:MAX_ITEMS]):
                for found, put_found in self._look(item, put_item, depth + 1):
                    if put_found is _hold:
                        holds = True
                    else:
                        yield found, put_found
            if holds:
                self._holding.add(id(value))
                yield value, put

    def _items(self, value: Any) -> Iterable[Reference]:
        kind = type(value)
        if kind is FunctionType:
            return self._function_references(value) if self._is_searched(value) else ()
        if issubclass(kind, type):
            return self._class_references(value) if self._is_searched(value) else ()
        if kind is partial:
            return _partial_references(value)
        if kind in _CLOSED or (kind.__module__ in ("builtins", "itertools") and hasattr(kind, "__next__")):
            return ((item, self._make_refusal(value, item)) for item in gc.get_referents(value))
        if issubclass(kind, ModuleType) or not (kind.__module__ in _PLAIN or kind.__module__ in self._modules):
            return ()
        return (*items_of(value), *(() if kind in _CONTAINERS else _instance_references(value)))

    def _make_refusal(self, holder: object, item: Any) -> Callable[[object], object]:
        """Refuse to replace what nobody can reach, such as a variable of a generator."""
        name = f"{self._names.get('__name__')}.{self._name}"
        owner, own = getattr(item, "__module__", None), getattr(item, "__name__", f"a {type(item).__name__}")
        kept = f"{owner}.{own}" if owner and hasattr(item, "__name__") else own

        def refuse(value: object) -> None:
            if value is not item:
                raise ProhibitedError(
                    f"{name} keeps {kept} in a {type(holder).__name__}, where virtual "
                    "time cannot replace it: make it in a function of the code that is called in the run"
                )

        return refuse

    def _is_searched(self, value: Any) -> bool:
        """Whether a function or class is looked into here: not if another module has it, which is searched itself."""
        module = value.__module__
        if module not in self._modules and type(value) is FunctionType:
            module = value.__globals__.get("__name__")  # what `functools.wraps` has made says that it is of `time`
        if module not in self._modules:
            return False
        home = vars(sys.modules.get(module, sys))
        return home is self._names or home.get(value.__name__) is not value

    def _function_references(self, function: FunctionType) -> Iterator[Reference]:
        for index, value in enumerate(function.__defaults__ or ()):
            yield value, partial(_put_default, function, index)
        for name, value in (keywords := function.__kwdefaults__ or {}).items():
            yield value, partial(keywords.__setitem__, name)
        for cell in function.__closure__ or ():
            yield from _cell_references(cell)
        for name, value in [*vars(function).items()]:
            yield value, partial(vars(function).__setitem__, name)
        names = function.__globals__  # a method that attrs has made has its own
        if names is not self._names and names is not vars(sys.modules.get(function.__module__, sys)):
            for name, value in [*names.items()]:
                if self._is_wanted(value):
                    yield value, partial(names.__setitem__, name)

    def _class_references(self, kind: type) -> Iterator[Reference]:
        for index, base in enumerate(kind.__bases__):
            if self._is_wanted(base):
                yield base, partial(_put_base, kind, index)
        yield from _factory_references(kind)
        for name, value in [*_members(kind).items()]:
            yield value, partial(_put_attribute, kind, name)


def _members(kind: type) -> Mapping[str, Any]:
    names: Mapping[str, Any] = type.__getattribute__(kind, "__dict__")  # a metaclass may answer with anything
    return names


def _hold(value: object) -> None:
    """An item of an object that cannot be changed stays: who has the object gets another one instead."""


def _cell_references(cell: CellType) -> Iterator[Reference]:
    with suppress(ValueError):  # it is empty
        yield cell.cell_contents, partial(setattr, cell, "cell_contents")


def _partial_references(value: partial[Any]) -> Iterator[Reference]:
    def put(function: Any) -> None:
        value.__setstate__((function, value.args, value.keywords, vars(value)))  # type: ignore[attr-defined]

    def put_argument(index: int, argument: object) -> None:
        arguments = _with_item(value.args, index, argument)
        value.__setstate__((value.func, arguments, value.keywords, vars(value)))  # type: ignore[attr-defined]

    yield value.func, put
    yield value.keywords, _hold
    yield from ((argument, partial(put_argument, index)) for index, argument in enumerate(value.args))


def _with_item(items: tuple[object, ...], index: int, item: object) -> tuple[object, ...]:
    return (*items[:index], item, *items[index + 1 :])


def _instance_references(value: object) -> Iterator[Reference]:
    try:
        own = object.__getattribute__(value, "__dict__")  # an attribute hook of its class may raise anything
    except AttributeError:
        own = None
    if type(own) is dict:
        for name, item in [*own.items()]:
            yield item, partial(own.__setitem__, name)
    for kind in (kind for kind in type(value).__mro__ if "__slots__" in _members(kind)):
        for slot in [member for member in _members(kind).values() if type(member) is MemberDescriptorType]:
            try:
                item = slot.__get__(value)
            except AttributeError:
                continue  # nothing is in it
            yield item, partial(slot.__set__, value)


def _factory_references(kind: Any) -> Iterator[Reference]:
    """Functions that make the defaults of fields, where libraries keep them in code of their own."""
    if type(kind).__module__ == "msgspec._core":
        for default in (default for default in kind.__struct_defaults__ if hasattr(default, "factory")):
            yield default.factory, partial(_refuse_factory, kind, default.factory)
    fields = _members(kind).get("__pydantic_fields__")
    for field in [*fields.values()] if type(fields) is dict and hasattr(kind, "model_rebuild") else ():
        if field.default_factory is not None:
            yield field.default_factory, partial(_put_factory, kind, field)


def _refuse_factory(kind: type, factory: Any, value: object) -> None:
    if value is not factory:
        name = ".".join(filter(None, (factory.__module__, factory.__qualname__)))
        raise ProhibitedError(
            f"{kind.__module__}.{kind.__name__}: msgspec keeps {name} where virtual time cannot replace it: write "
            f"default_factory=lambda: {name}()"
        )


def _put_factory(kind: Any, field: Any, value: object) -> None:
    """Replace the factory of a field of pydantic. Validators of its model, and of its users, have it, too."""
    field.default_factory = value
    base = next(parent for parent in kind.__mro__ if parent.__module__ == "pydantic.main")
    pending, rebuilt = [kind], {kind}
    while pending:
        model = pending.pop(0)
        model.model_rebuild(force=True)
        users = [user for user in _models(base) if user not in rebuilt and _has_field_of(user, model)]
        rebuilt.update(users)
        pending += users


def _models(base: Any) -> Iterator[Any]:
    for model in base.__subclasses__():
        yield model
        yield from _models(model)


def _has_field_of(model: Any, kind: type) -> bool:
    pending = [field.annotation for field in vars(model).get("__pydantic_fields__", {}).values()]
    while pending:
        annotation = pending.pop()
        if annotation is kind:
            return True
        pending += getattr(annotation, "__args__", ())
    return False


def _put_default(function: FunctionType, index: int, value: object) -> None:
    defaults = list(function.__defaults__ or ())
    defaults[index] = value
    function.__defaults__ = tuple(defaults)


def _put_base(kind: type, index: int, value: Any) -> None:
    bases = [*kind.__bases__]
    bases[index] = value
    try:
        kind.__bases__ = tuple(bases)
    except TypeError as error:  # of a class in C, such as `queue.SimpleQueue`
        raise ProhibitedError(
            f"{kind.__module__}.{kind.__qualname__} is a subclass of {kind.__bases__[index].__qualname__}, which waits "
            "in real time: derive it from a class in Python, as queue.Queue is one"
        ) from error


def _put_attribute(kind: type, name: str, value: Any) -> None:
    is_bound = type(value) is FunctionType and type(_members(kind)[name]) is BuiltinFunctionType
    # A function in C is not a method of its class, but one in Python is.
    setattr(kind, name, staticmethod(value) if is_bound else value)
