"""Copies of modules of Python's library in which some names, or imports, are replaced."""

from __future__ import annotations

import builtins
import importlib.util
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import Any


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
