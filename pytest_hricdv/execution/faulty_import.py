"""`FaultyImport` loads code under test with another text than that of its file.

The features mutation and suggestion use it to import code with a `SeededFault`, in processes of their own; `instrument`
uses it to load modules with calls of hooks.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType


def text_as_loaded(path: Path) -> str:
    """The text that a file is loaded as: its own, or the mutated one."""
    for finder in sys.meta_path:
        text = finder.text(path) if isinstance(finder, FaultyImport) else None
        if text is not None:
            return text
    return path.read_text(encoding="utf-8")


@dataclass(frozen=True)
class SeededFault:
    """A bug that can be seeded in the code under test.

    Args:
        path: the path of the changed file.
        text: the text of this file with the bug.
    """

    name: str
    path: str
    text: str = field(repr=False)


class FaultyImport(MetaPathFinder):
    """Finds the modules of some files, by whichever finder has them, and loads other texts in their place.

    Insert it before they are imported: `sys.meta_path.insert(0, FaultyImport({path: text}))`. No file is written. Use
    one instance for all files: each asks all finders behind it, so every further one doubles the time of an import.

    Args:
        texts: file -> the text to be loaded, or its syntax tree.
    """

    def __init__(self, texts: Mapping[Path, str | ast.Module]) -> None:
        self._texts = {path.resolve(): text for path, text in texts.items()}

    def text(self, path: Path) -> str | None:
        """The text that a file is loaded as; None if it is not one of this finder."""
        text = self._texts.get(path.resolve())
        return text if isinstance(text, str) else None

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder`; None for every other module."""
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            spec = finder.find_spec(fullname, path, target)
            if spec is not None:
                return self._change(spec, fullname)
        return None

    def _change(self, spec: ModuleSpec, fullname: str) -> ModuleSpec | None:
        path = Path(spec.origin).resolve() if spec.has_location and spec.origin is not None else None
        if path is None or path not in self._texts:
            return None
        spec.loader = _FaultyLoader(fullname, str(path), self._texts[path])
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
