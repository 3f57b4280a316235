"""Base classes of the nodes of formulas, and what each operator defines about itself.

A `Term` is a number, a `TextTerm` a text, a `PastFormula` a condition; `past_formula` and `terms` have their
subclasses. A formula is about a run in dense time: signals are constant between updates, and a message exists for one
instant. Nodes are frozen dataclasses that compare by value, so equal requirements share one compiled program.
`str(node)` is its text in the requirement language, which is parsed to an equal node. Times are in seconds.

Traversal, analysis and compilation ask the nodes, so a new operator is a new class and nothing else here changes.
Names are those of signals, of fields as `topic.field`, and of a field's value in the message before.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum, IntEnum, auto
from typing import Any, ClassVar, Protocol, Self

Kind = type[bool] | type[float] | type[str]
"""The type of a signal, field or expression."""

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def last_of(field: str) -> str:
    """The name of the value that a field, `topic.field`, had in the message before the present one."""
    return f"last({field})"


def field_of(name: str) -> str:
    """`topic.field` of a field, or of its value in the message before; empty for a signal."""
    return name.removeprefix("last(").removesuffix(")") if "." in name else ""


def source_of(name: str) -> str:
    """The source whose updates change `name` (a signal, a field, or its value in the message before)."""
    topic, dot, _ = field_of(name).partition(".")
    return f"on({topic})" if dot else name


def is_optional(name: str, kind: Kind) -> bool:
    """Whether a missing value is not an error: of the text of a message, and of a field in the message before."""
    return "." in name and (kind is str or name != field_of(name))


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


class HysteresisScope(Enum):
    """Since when a comparison with hysteresis remembers that it was violated."""

    RUN = auto()
    TRIGGER = auto()
    NEVER = auto()


class Compiler(Protocol):
    """The interface for compiling formulas and terms (`compiler.ExpressionCompiler`)."""

    def output(self, formula: Any, make: Callable[..., Any], *operands: Any) -> str:
        """The output of an operator over conditions; `make` constructs it from its number and their functions."""

    def number_output(self, number: Any, make: Callable[..., Any], *operands: Any) -> str:
        """The output of an operator over occurrences: messages, or instants at which an operand becomes true."""

    def comparison(self, formula: Any, scope: HysteresisScope) -> str:
        """A comparison of numbers without duration: its expression, or the output of its hysteresis."""

    def comparison_text(self, formula: Any) -> str:
        """The expression of a comparison, without memory."""

    def distance(self, formula: Any) -> str:
        """The expression of a comparison's signed distance to its bound."""


class FormulaNode:
    """Any part of a formula. A subclass whose text is not an atom sets `PRECEDENCE`."""

    PRECEDENCE: ClassVar[Precedence] = Precedence.ATOM

    @property
    def precedence(self) -> Precedence:
        """How strongly the text of this node binds."""
        return self.PRECEDENCE

    @property
    def parts(self) -> tuple[FormulaNode, ...]:
        """The nodes directly inside this one, in the order of the text."""
        return tuple(part for part in vars(self).values() if isinstance(part, FormulaNode))

    @property
    def children(self) -> tuple[PastFormula, ...]:
        """The conditions directly inside this node, also those in its terms."""
        children: list[PastFormula] = []
        for part in self.parts:
            children += (part,) if isinstance(part, PastFormula) else part.children
        return tuple(children)

    @property
    def own_names(self) -> dict[str, Kind]:
        """Name -> type of the signals and fields that it reads itself, not in the conditions inside it."""
        names: dict[str, Kind] = {}
        for part in self.parts:
            if not isinstance(part, PastFormula):
                names.update(part.own_names)
        return names

    def with_operands(self, change: Callable[[Any], Any]) -> Self:
        """The same operator with other operands."""
        operands = {name: change(part) for name, part in vars(self).items() if isinstance(part, FormulaNode)}
        return replace(self, **operands)  # type: ignore[type-var]

    def operand_text(self, minimum: Precedence) -> str:
        """The text as an operand; in parentheses if it binds more weakly than `minimum`."""
        return str(self) if self.precedence >= minimum else f"({self})"


class Term(FormulaNode, ABC):
    """A number at each time."""

    MAY_BE_MISSING: ClassVar[bool] = False
    """Whether it may be without a value; a comparison with it is then false."""

    @property
    def is_right_continuous(self) -> bool:
        """Whether the number at each instant is also the one right after it."""
        return all(part.is_right_continuous for part in self.parts if isinstance(part, Term))

    @abstractmethod
    def expression(self, compiler: Compiler) -> str:
        """The Python expression of the number."""


class TextTerm(FormulaNode, ABC):
    """A text at each time."""

    @abstractmethod
    def expression(self, compiler: Compiler) -> str:
        """The Python expression of the text."""


class PastFormula(FormulaNode, ABC):
    """A formula about the present and the past: a condition, an antecedent, or what a response is made of."""

    @property
    def is_instantaneous(self) -> bool:
        """Whether it can be true only at isolated instants, never for a length of time."""
        return False

    @property
    def is_right_continuous(self) -> bool:
        """Whether the value at each instant is also the value right after it, so that only instants need evaluation.

        Signals and formulas over signals are. Messages, edges and `previously` differ at single instants.
        """
        return all(child.is_right_continuous for child in self.children)

    @property
    def sources(self) -> frozenset[str]:
        """The sources whose updates can change the value.

        A source is what is fed: the name of a signal, or `on(topic)` for a topic.
        """
        own = frozenset(map(source_of, self.own_names))
        return own.union(*(child.sources for child in self.children))

    @abstractmethod
    def expression(self, compiler: Compiler, scope: HysteresisScope) -> str:
        """The Python expression of the truth; inside operators with memory, the scope of a hysteresis is the run."""

    def robustness(self, compiler: Compiler) -> str | None:
        """The Python expression of the signed distance to the bounds; None if nothing is compared.

        The quantitative semantics of signal temporal logic (Donze and Maler, "Robust satisfaction of temporal logic
        over real-valued signals", FORMATS 2010): min for `&`, max for `|`, plus or minus infinity for a formula
        without a comparison, such as past operators, `time_since` and `[for d]`. A hysteresis does not move the bound.
        """
        return None


@dataclass(frozen=True)
class _Label(FormulaNode):
    name: str

    def __str__(self) -> str:
        return self.name


def text_with_names(node: FormulaNode, names: Mapping[FormulaNode, str]) -> str:
    """The text of a formula in which names replace parts; of nested parts with names, the outermost is replaced."""

    def label(part: Any) -> Any:
        return _Label(names[part]) if part in names else part.with_operands(label)

    return str(label(node))


def number_text(value: float) -> str:
    """A number as short as it can be read back: `10`, `0.15`."""
    return repr(value).removesuffix(".0")


def window_text(start_s: float, end_s: float) -> str:
    """A window of time in seconds: `[0:10]`."""
    return f"[{number_text(start_s)}:{number_text(end_s)}]"
