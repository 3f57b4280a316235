"""Python source under construction: indented lines, and the objects that they name."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

MAX_DEPTH = 15
"""Nested blocks; Python itself allows twenty."""


class UnsupportedError(Exception):
    """A part of a program that has no compiled form: it is left to the interpreter."""


class Names:
    """The objects that generated code names."""

    def __init__(self) -> None:
        self.objects: dict[str, object] = {}
        self._constants: dict[tuple[type, object], str] = {}
        self._numbered = 0

    def fresh(self, stem: str) -> str:
        """A name not used before."""
        self._numbered += 1
        return f"{stem}{self._numbered}"

    def constant(self, value: object) -> str:
        """A name for an object; the same for equal terms."""
        key = (type(value), value)
        if key not in self._constants:
            name = self.fresh("k")
            self._constants[key] = name
            self.objects[name] = value
        return self._constants[key]


class Writer:
    """Lines of Python.

    Args:
        names: the objects that they name, shared by all code of a program.
        functions: where functions go that are needed besides, as finished lines.
    """

    def __init__(self, names: Names, functions: list[str]) -> None:
        self.lines: list[str] = []
        self.names = names
        self.functions = functions
        self._depth = 0

    def line(self, text: str) -> None:
        """Add a line."""
        self.lines.append("    " * self._depth + text)

    def take(self) -> list[str]:
        """Take the lines out."""
        lines, self.lines = self.lines, []
        return lines

    def include(self, lines: list[str]) -> None:
        """Add lines inside the current block."""
        self.lines += ["    " * self._depth + line for line in lines]

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Add a line and indent what follows below it."""
        if self._depth >= MAX_DEPTH:
            raise UnsupportedError("nested too deeply")
        self.line(head)
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1

    def beside(self) -> Writer:
        """A writer for another function."""
        return Writer(self.names, self.functions)

    @contextmanager
    def attempt(self) -> Iterator[None]:
        """Take back the lines added inside if there is no compiled form for what they were to do."""
        lines, depth = len(self.lines), self._depth
        try:
            yield
        except UnsupportedError:
            del self.lines[lines:]
            self._depth = depth
            raise
