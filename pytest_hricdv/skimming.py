"""Skimming: when only generated tests are wanted, files that cannot have any are not imported.

A project may have thousands of other tests, and importing them takes longer than learning a suite. A file's text
decides, so every worker decides alike. In doubt a file is collected as ever: where a test, a class or a fixture that
asks for `hri_case` may come from elsewhere.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

CASE = "hri_case"
_KEPT = ("__init__.py", "conftest.py")

# Tests from elsewhere: under any name, from a base class, or imported under the name of a test.
_ELSEWHERE = re.compile(
    r"\bimport\s*\*|^\s*class\s+\w+\s*\(\s*\w|\bimport\b[^\n]*\b[Tt]est\w*\s*(?:,|\)|#|$)|^\s+[Tt]est\w*\s*,?\s*$"
    r"|\bpytest_generate_tests\b|\bpytest_plugins\b",
    re.MULTILINE,
)


class Skimming:
    """Tells files that cannot have generated tests by their text."""

    def __init__(self) -> None:
        self._wrapped = False

    def look_at(self, plugin: object) -> None:
        """Look at a plugin, or a conftest.py, for a fixture that asks for the case: then any file may use that.

        pytest loads the conftest.py of a folder before it looks at the folder's files.
        """
        names = {**vars(type(plugin)), **getattr(plugin, "__dict__", {})}
        self._wrapped = self._wrapped or any(CASE in _asks_for(value) for value in names.values())

    def is_without_cases(self, path: Path) -> bool:
        """Whether a file that pytest is about to collect can be left out."""
        if self._wrapped or path.suffix != ".py" or path.name in _KEPT:
            return False
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            return False  # what pytest says of it is clearer
        return CASE not in text and _ELSEWHERE.search(text) is None


def _asks_for(value: object) -> tuple[str, ...]:
    """The names of a fixture's arguments; nothing for what is no fixture: these wrap their function."""
    if not hasattr(value, "__wrapped__") or not callable(value):
        return ()
    try:
        return tuple(inspect.signature(value).parameters)
    except (TypeError, ValueError):
        return ()
