"""What all parts of formulas share: how they are written as text, with no more parentheses than necessary."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any, ClassVar, Self


class Precedence(IntEnum):
    """How strongly the outermost operator of a text binds, from weak to strong, as in `requirement.lark`."""

    SINCE = 0
    OR = 1
    AND = 2
    NOT = 3
    COMPARISON = 4
    SUM = 5
    PRODUCT = 6
    UNARY = 7
    ATOM = 8


class Node:
    """Any part of a formula. A subclass whose text is not an atom sets `PRECEDENCE`."""

    PRECEDENCE: ClassVar[Precedence] = Precedence.ATOM

    @property
    def precedence(self) -> Precedence:
        """How strongly the text of this node binds."""
        return self.PRECEDENCE

    def changed(self, change: Callable[[Any], Any]) -> Self:
        """The same operator with other operands."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        changed = {name: change(part) for name, part in parts.items() if isinstance(part, Node)}
        return replace(self, **changed)  # type: ignore[type-var]

    def operand_text(self, minimum: Precedence) -> str:
        """The text as an operand; in parentheses if it binds more weakly than `minimum`."""
        return str(self) if self.precedence >= minimum else f"({self})"


@dataclass(frozen=True)
class _Named(Node):
    name: str

    def __str__(self) -> str:
        return self.name


def text_with_names(node: Node, names: Mapping[Node, str]) -> str:
    """The text of a formula, with the name that `names` has for a part in place of it, of nested ones the outermost."""

    def named(part: Any) -> Any:
        return _Named(names[part]) if part in names else part.changed(named)

    return str(named(node))


def number_text(value: float) -> str:
    """A number as short as it can be read back: `10`, `0.15`."""
    return repr(value).removesuffix(".0")


def window_text(start_s: float, end_s: float) -> str:
    """A window of time in seconds: `[0:10]`."""
    return f"[{number_text(start_s)}:{number_text(end_s)}]"
