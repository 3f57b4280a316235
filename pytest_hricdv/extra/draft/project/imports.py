"""Names of the code in a drafted file: each is imported once, under a name that nothing else has."""

from __future__ import annotations

import builtins
import json
import re
from collections.abc import Iterable
from keyword import iskeyword

from pytest_hricdv.extra.draft.code.naming import camel
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Imports


def _is_name(module: str) -> bool:
    """Whether an import statement can name a module."""
    return all(part.isidentifier() and not iskeyword(part) for part in module.split("."))


WIDTH = 88
"""Longer imports are one name a line, as ruff has them where nothing else is configured."""


class ImportTable:
    """The imports of a file.

    Args:
        taken: names that the file has already.
    """

    def __init__(self, taken: Iterable[str]) -> None:
        self._taken = {*taken, *dir(builtins)}
        self._names: dict[tuple[str, str], str] = {}

    def use(self, module: str, name: str) -> str:
        """The local name of a name of a module."""
        key = module, name
        if key not in self._names:
            local = name
            if local in self._taken:
                local = camel(module.rpartition(".")[2]) + name[:1].upper() + name[1:]
            while local in self._taken:
                local += "_"
            self._taken.add(local)
            self._names[key] = local
        return self._names[key]

    def text(self, source: str, imports: Imports) -> str:
        """A piece of source text, with the local names in place of those that it needs."""
        for module, name in imports:
            local = self.use(module, name)
            if local != name:
                source = re.sub(rf"(?<![\w.'\"]){re.escape(name)}\b", local, source)
        return source

    def lines(self, indent: str = "    ") -> list[str]:
        """The import statements, sorted; the draft's own module last."""
        by_module: dict[str, list[str]] = {}
        for (module, name), local in self._names.items():
            if not _is_name(module):
                continue
            by_module.setdefault(module, []).append(name if local == name else f"{name} as {local}")
        lines = [f"{indent}{local} = import_module({json.dumps(module)}).{name}"
                 for (module, name), local in self._names.items() if not _is_name(module)]  # fmt: skip
        for module in sorted(by_module, key=lambda module: (module == OWN_MODULE, module)):
            names = sorted(by_module[module])
            line = f"{indent}from {module} import {', '.join(names)}"
            lines += [line] if len(line) <= WIDTH else [
                f"{indent}from {module} import (", *(f"{indent}    {name}," for name in names), f"{indent})"
            ]  # fmt: skip
        return lines
