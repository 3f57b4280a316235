"""Changed values: in a fork, constants of a module and of its classes get those of a changed text."""

from __future__ import annotations

import ast
import gc
import sys
from abc import ABCMeta
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from types import FunctionType, ModuleType


def set_values(module: ModuleType, before: str, text: str) -> bool:
    """Give constants their new values, everywhere; whether there is one that has changed.

    Args:
        module: that was imported.
        before: its text.
        text: the changed one.
    """
    has_changed = False
    for name, value in _changed(ast.parse(before), ast.parse(text)):
        if name in vars(module):
            old = vars(module)[name]
            for other in [*sys.modules.values()]:
                if vars(other).get(name) is old:
                    setattr(other, name, value)
            has_changed = True
    new_classes = dict(_classes(text))
    for class_name, tree in _classes(before):
        kind = vars(module).get(class_name)
        # Classes of other metaclasses, as enumerations, look at what they are given.
        if isinstance(kind, type) and type(kind) in (type, ABCMeta) and class_name in new_classes:
            for name, value in _changed(tree, new_classes[class_name]):
                _set_of_class(kind, name, value)
                has_changed = True
    return has_changed


def _classes(text: str) -> Iterator[tuple[str, ast.ClassDef]]:
    return ((node.name, node) for node in ast.parse(text).body if isinstance(node, ast.ClassDef))


def _changed(before: ast.Module | ast.ClassDef, after: ast.Module | ast.ClassDef) -> Iterator[tuple[str, object]]:
    """Names that both give a literal, and not the same, with the new one."""
    old, new = _constants(before), _constants(after)
    return ((name, new[name]) for name in old.keys() & new.keys() if old[name] != new[name])


def _constants(tree: ast.Module | ast.ClassDef) -> dict[str, object]:
    """The names that are given a literal."""
    values: dict[str, object] = {}
    for statement in tree.body:
        if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            for target in targets:
                values |= dict(_literals(target, statement.value))
    return values


def _literals(target: ast.expr, value: ast.expr) -> Iterator[tuple[str, object]]:
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for inner, part in zip(target.elts, value.elts, strict=False):
            yield from _literals(inner, part)
    elif isinstance(target, ast.Name):
        try:
            yield target.id, ast.literal_eval(value)
        except (ValueError, TypeError, SyntaxError, RecursionError):
            return


def _set_of_class(kind: type, name: str, value: object) -> None:
    """Of the class; of a data class also for what will be made with the default, and for what was made with it."""
    if not is_dataclass(kind):
        setattr(kind, name, value)
        return
    old = next((field.default for field in fields(kind) if field.name == name), vars(kind).get(name))
    if vars(kind).get(name) is old:  # slots hide the default
        setattr(kind, name, value)
    for made in gc.get_objects():
        if isinstance(made, type):
            if issubclass(made, kind):
                _set_default(made.__init__, old, name, value)
        elif issubclass(type(made), kind) and getattr(made, name, None) is old:
            object.__setattr__(made, name, value)


def _set_default(init: object, old: object, name: str, value: object) -> None:
    if not isinstance(init, FunctionType):
        return
    if init.__kwdefaults__ and init.__kwdefaults__.get(name) is old:
        init.__kwdefaults__[name] = value
    defaults = init.__defaults__ or ()
    names = init.__code__.co_varnames[: init.__code__.co_argcount][-len(defaults) :] if defaults else ()
    init.__defaults__ = tuple(
        value if other == name and default is old else default for other, default in zip(names, defaults, strict=True)
    )
