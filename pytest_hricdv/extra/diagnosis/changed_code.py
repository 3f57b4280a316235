"""Changed code: a file of the code under test is given another text in a fork, whether it was imported already or not.

What was imported is not imported anew: objects of the old classes would be left everywhere. The functions get the code
of the changed text, and constants of modules their new values, in each module that has imported them; so do constants
of classes, as the defaults of a data class, with the objects that were made with them. Other changes to what was
imported cannot be made so.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

from pytest_hricdv.execution.faulty_import import FaultyImport
from pytest_hricdv.extra.diagnosis.changed_values import set_values


def put_in(path: Path, before: str, text: str) -> bool:
    """In a fork: from now on this process executes `text`. False where this cannot be done.

    Args:
        path: of the file.
        before: its text.
        text: the changed one.
    """
    modules = [module for module in [*sys.modules.values()] if _is_of(module, path)]
    if not modules:
        sys.meta_path.insert(0, FaultyImport(path, text))
        return True
    files = {module.__file__ for module in modules if module.__file__}
    gc.unfreeze()  # a fork freezes what was there before, and what is frozen is not found
    changed = [_exchange(file, before, text) for file in files]
    changed += [set_values(module, before, text) for module in modules]
    return any(changed)


def _is_of(module: ModuleType, path: Path) -> bool:
    file = getattr(module, "__file__", None)
    return isinstance(file, str) and Path(file).name == path.name and Path(file).resolve() == path.resolve()


def _exchange(file: str, before: str, text: str) -> bool:
    """Give functions the code of the changed text; whether there is one that has changed."""
    old, new = ([*_codes(compile(source, file, "exec", dont_inherit=True))] for source in (before, text))
    if [code.co_qualname for code in old] != [code.co_qualname for code in new]:
        return False
    pairs = {
        (code.co_qualname, code.co_firstlineno): other
        for code, other in zip(old, new, strict=True)
        if _content(code) != _content(other)
    }
    has_changed = False
    for function in gc.get_objects():
        if type(function) is FunctionType and function.__code__.co_filename == file:
            code = function.__code__
            other = pairs.get((code.co_qualname, code.co_firstlineno))
            if other is not None and code.co_freevars == other.co_freevars:
                function.__code__ = other
                has_changed = True
    return has_changed


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Of all functions, in the order of the text; not that of the module."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes(constant)


def _content(code: CodeType) -> tuple[object, ...]:
    constants = tuple(
        _content(constant) if isinstance(constant, CodeType) else (type(constant), repr(constant))
        for constant in code.co_consts
    )
    return code.co_code, constants, code.co_names, code.co_varnames
