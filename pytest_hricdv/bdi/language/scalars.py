"""Numbers and variables: the terms that are values of Python's own kinds."""

from __future__ import annotations

from pytest_hricdv.bdi.language.number_format import number_text


class Number(float):
    """A number; like Jason's, always a double, printed without a fraction when it has none."""

    __slots__ = ()

    def __str__(self) -> str:
        return number_text(float(self))

    def __repr__(self) -> str:
        return f"Number({number_text(float(self))})"


class Variable(str):
    """A logical variable, known by its name."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"Variable({self!s})"
