"""Imports code under test with a seeded fault, in a process of its own."""

from __future__ import annotations

import ast
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType


@dataclass(frozen=True)
class SeededFault:
    """A fault that can be put into the code under test.

    Args:
        name: of the fault.
        path: of the changed file.
        text: of this file with the fault.
    """

    name: str
    path: str
    text: str = field(repr=False)


class FaultyImport(MetaPathFinder):
    """Finds the module of a file, by whichever finder has it, and loads another text in its place.

    To be set before the module is imported: `sys.meta_path.insert(0, FaultyImport(path, text))`. Nothing is written.

    Args:
        path: of the file.
        text: to be loaded, or its syntax tree.
    """

    def __init__(self, path: Path, text: str | ast.Module) -> None:
        self._path = path.resolve()
        self._text = text

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder`; None for every other module."""
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            spec = finder.find_spec(fullname, path, target)
            if spec is not None:
                return self._change(spec, fullname) if self._is_wanted(spec) else None
        return None

    def _is_wanted(self, spec: ModuleSpec) -> bool:
        return spec.has_location and spec.origin is not None and Path(spec.origin).resolve() == self._path

    def _change(self, spec: ModuleSpec, fullname: str) -> ModuleSpec:
        spec.loader = _FaultyLoader(fullname, str(self._path), self._text)
        return spec


class _FaultyLoader(SourceFileLoader):
    def __init__(self, fullname: str, path: str, text: str | ast.Module) -> None:
        super().__init__(fullname, path)
        self._text = text

    def get_code(self, fullname: str) -> CodeType:
        """The code of the other text; neither read from the cache nor written to it."""
        code = compile(self._text, self.path, "exec", dont_inherit=True)
        assert isinstance(code, CodeType), "a module compiles to code"
        return code
