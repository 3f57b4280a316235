"""The terms of AgentSpeak: numbers, strings, variables, structures, lists, expressions, calls and plan terms.

Terms are immutable values, but for sets, maps and queues. ``str(term)`` is AgentSpeak text that parses back to an equal
term. Structures and lists are not dataclasses, because an agent creates and compares them in every step: their hash,
groundness and text are computed once. They are copied and pickled without these, since hashes differ between processes.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from operator import neg

from pytest_hricdv.bdi.language.arithmetic import OPERATIONS
from pytest_hricdv.bdi.language.arithmetic import Number as Number
from pytest_hricdv.bdi.language.collection import CollectionTerm
from pytest_hricdv.bdi.language.errors import NO_LOCATION, EvaluationError, Location
from pytest_hricdv.bdi.language.limits import CHARACTERS, ITEMS, MAX_SIZE, spend, too_large

Key = tuple[bool, str, int]
"""The predicate of a literal, the index of beliefs and plans: strongly negated?, functor, arity."""
_KEYS: dict[Key, Key] = {}
"""Each key once: equal keys are the same object, which a dictionary finds without comparing them."""


class Variable(str):
    """A logical variable, identified by its name."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"Variable({self!s})"


@dataclass(frozen=True, slots=True)
class String:
    """A quoted string."""

    value: str

    def __str__(self) -> str:
        return '"' + self.value.replace('"', '\\"').replace("\n", "\\n") + '"'


class Structure:
    """An atom, structure or literal: ``functor(args)[annots]``, strongly negated or not.

    Args:
        functor: its name.
        args: its terms; an atom has none.
        annots: its annotations, kept in term order as Jason keeps them.
        negated: whether it is strongly negated (``~p``).
        annots_tail: the variable after ``|`` in the annotations, if any.
    """

    __slots__ = (
        "_hash",
        "_text",
        "annots",
        "annots_tail",
        "args",
        "evaluable",
        "functor",
        "ground",
        "key",
        "negated",
        "size",
    )

    def __init__(
        self,
        functor: str,
        args: tuple[Term, ...] = (),
        annots: tuple[Term, ...] = (),
        negated: bool = False,
        annots_tail: Variable | None = None,
    ) -> None:
        self.functor = functor
        self.args = args
        self.annots = annots
        self.negated = negated
        self.annots_tail = annots_tail
        key = (negated, functor, len(args))
        self.key: Key = _KEYS.setdefault(key, key)
        ground, size = annots_tail is None, 1  # the size in one loop with it: structures are made in every step
        for term in args + annots:
            # The frequent kinds first, without a call.
            kind = type(term)
            if kind is Number:
                continue
            if kind is Structure:
                size += term.size  # type: ignore[union-attr]
                if not term.ground:  # type: ignore[union-attr]
                    ground = False
            elif kind is Variable:
                ground = False
            else:
                size += size_of(term)
                ground = ground and is_ground(term)
        if size > MAX_SIZE:
            raise too_large()
        self.size: int = size
        """The terms in it, each as often as it occurs, but for numbers and variables."""
        self.ground: bool = ground
        self.evaluable = not ground and any(map(is_evaluable, args + annots))
        self._hash: int | None = None
        self._text: str | None = None

    def without_annotations(self) -> Structure:
        """The same literal without annotations."""
        if not self.annots and self.annots_tail is None:
            return self
        return Structure(self.functor, self.args, (), self.negated)

    def with_annotations(self, annots: tuple[Term, ...], tail: Variable | None = None) -> Structure:
        """The same literal with exactly these annotations, which are put in order."""
        ordered = sort_terms(annots) if len(annots) > 1 else annots
        return Structure(self.functor, self.args, ordered, self.negated, tail)

    def with_own_source(self) -> Structure:
        """The same literal, from the agent itself if it has no source."""
        return self if self.has_source() else self.with_annotations((*self.annots, SOURCE_SELF))

    def has_source(self) -> bool:
        """Whether some annotation is a ``source(...)``."""
        for annot in self.annots:
            if isinstance(annot, Structure) and annot.functor == "source" and len(annot.args) == 1:
                return True
        return False

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        # Different hashes decide at once; they are computed once for each term, the comparison below walks through it.
        if not isinstance(other, Structure) or self.key != other.key or hash(self) != hash(other):
            return False
        return self.args == other.args and self.annots == other.annots and self.annots_tail == other.annots_tail

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash((self.key, self.args, self.annots))
        return self._hash

    def __str__(self) -> str:
        if self._text is not None:
            return self._text
        text = self._write()
        if not holds_collection(self):
            self._text = text
        return text

    def _write(self) -> str:
        text = self.functor if not self.negated else negate_text(self.functor)
        if self.args:
            text += f"({','.join(map(str, self.args))})"
        if self.annots or self.annots_tail is not None:
            tail = "" if self.annots_tail is None else f"|{self.annots_tail}"
            text += f"[{','.join(map(str, self.annots))}{tail}]"
        return text

    def __repr__(self) -> str:
        return f"Structure({self})"

    def __reduce__(self) -> tuple[object, ...]:
        return Structure, (self.functor, self.args, self.annots, self.negated, self.annots_tail)


def negate_text(functor: str) -> str:
    """A functor with the sign of strong negation, which stands behind its namespace: ``ns::~p``."""
    space, separator, name = functor.partition("::")
    return f"{space}::~{name}" if separator and not functor.startswith("'") else f"~{functor}"


class ListTerm:
    """A list ``[a,b|Tail]``; a proper list has no tail."""

    __slots__ = ("_hash", "evaluable", "ground", "items", "size", "tail")

    def __init__(self, items: tuple[Term, ...] = (), tail: Term | None = None) -> None:
        self.items: tuple[Term, ...] = items
        self.tail: Term | None = tail
        if isinstance(tail, ListTerm):
            # One form for each list, so that `[a|[b]]` equals `[a,b]`.
            self.items, self.tail = items + tail.items, tail.tail
        ground, size = self.tail is None or is_ground(self.tail), len(self.items) + size_of(self.tail)
        if len(self.items) > ITEMS:
            spend(len(self.items) // ITEMS)
        for item in self.items:
            if type(item) is not Number:
                size += size_of(item)
                ground = ground and is_ground(item)
        if size > MAX_SIZE:
            raise too_large()
        self.size: int = size
        """The terms in it, each as often as it occurs, and the number of its items."""
        self.ground = ground
        self.evaluable = not self.ground and any(map(is_evaluable, self.items))
        self._hash: int | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ListTerm) and self.items == other.items and self.tail == other.tail

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(("list", self.items, self.tail))
        return self._hash

    def __str__(self) -> str:
        spend(len(self.items))
        tail = "" if self.tail is None else f"|{self.tail}"
        return f"[{','.join(map(str, self.items))}{tail}]"

    def __repr__(self) -> str:
        return f"ListTerm({self})"

    def __reduce__(self) -> tuple[object, ...]:
        return ListTerm, (self.items, self.tail)


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """An arithmetic expression not yet evaluated; a unary minus has one operand."""

    operator: str
    operands: tuple[Term, ...]
    size: int = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        size = 1 + sum(map(size_of, self.operands))
        if size > MAX_SIZE:
            raise too_large()
        object.__setattr__(self, "size", size)

    def value(self, operands: tuple[Term, ...]) -> Number | Arithmetic | Call:
        """Its value with these operands in place of its own; an expression, if an operand has no value yet.

        If an operand is not a number, the call of a function that says so.

        Raises:
            EvaluationError: the result is not defined.
        """
        for operand in operands:
            if type(operand) is Number:
                continue
            if isinstance(operand, Variable) or is_evaluable(operand):
                return Arithmetic(self.operator, operands)
            return Call(NOT_NUMERIC, (operand, String(str(self))), NO_LOCATION)
        operation: Callable[..., float] = neg if len(operands) == 1 else OPERATIONS[self.operator]
        try:
            return Number(operation(*operands))
        except (ArithmeticError, ValueError):
            raise EvaluationError(f"{Arithmetic(self.operator, operands)} has no value") from None

    def __str__(self) -> str:
        if len(self.operands) == 1:
            return f"({self.operator}{self.operands[0]})"
        operator = f" {self.operator} " if self.operator.isalpha() else self.operator
        right = str(self.operands[1])
        # A negative right operand would fuse with the operator into another token (``1--2``, ``2*-1``).
        return f"({self.operands[0]}{operator}{f'({right})' if right.startswith('-') else right})"


NOT_NUMERIC = ".not_numeric"
"""The function that stands for arithmetic with a term that is not a number, which has none as its value."""
VALUE_BY_RULE = ".value_by_rule"
"""The function that stands for those which a source registers: the value of the last argument of a rule."""


@dataclass(frozen=True, slots=True)
class Call:
    """An internal action: a statement of a body, a condition of a context, or a function in an expression.

    Its arguments may be formulas (``.findall(X, p(X) & X > 2, L)``); its location is for error messages.
    """

    name: str
    args: tuple[object, ...]
    location: Location = field(compare=False)
    size: int = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        size = 1 + sum(map(size_of, self.args))
        if size > MAX_SIZE:
            raise too_large()
        object.__setattr__(self, "size", size)

    def __str__(self) -> str:
        return f"{self.name}({','.join(map(str, self.args))})" if self.args else self.name


@dataclass(frozen=True, slots=True)
class AnnotatedVariable:
    """A variable with annotations, ``X[source(S)]``: stands for a literal once X is bound."""

    variable: Variable
    annots: tuple[Term, ...] = ()
    annots_tail: Variable | None = None
    negated: bool = False

    def __str__(self) -> str:
        sign = "~" if self.negated else ""
        if not self.annots and self.annots_tail is None:
            return f"{sign}{self.variable}"
        tail = "" if self.annots_tail is None else f"|{self.annots_tail}"
        return f"{sign}{self.variable}[{','.join(map(str, self.annots))}{tail}]"


@dataclass(frozen=True, slots=True)
class QualifiedLiteral:
    """A literal of a namespace that is a variable, ``NS::p(X)``, or a variable for a literal of one, ``ns::G``.

    Literals of a namespace that is a name are structures with the functor ``ns::p``.
    """

    space: Variable | Structure
    literal: Structure | Variable | AnnotatedVariable

    def __str__(self) -> str:
        return f"{self.space}::{self.literal}"


@dataclass(frozen=True, slots=True)
class PlanTerm:
    """A plan or event as a term, ``{ +!g : c <- b }``, or a body, ``{ a; b }``; ``plan`` is its syntax tree."""

    plan: object

    def __str__(self) -> str:
        text = "; ".join(map(str, self.plan)) if isinstance(self.plan, tuple) else str(self.plan)
        return f"{{ {text} }}"


@dataclass(frozen=True, slots=True)
class FormulaTerm:
    """A condition as an argument of a goal, ``!check(X > 3)``; ``formula`` is its syntax tree."""

    formula: object
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.formula)


Term = (
    Number
    | String
    | Variable
    | Structure
    | ListTerm
    | Arithmetic
    | Call
    | AnnotatedVariable
    | QualifiedLiteral
    | PlanTerm
    | FormulaTerm
    | CollectionTerm
)
"""A term of AgentSpeak."""

_ESCAPE = re.compile(r'\\([n"])')


def unescape(text: str) -> str:
    """The text that is written so within quotes: as in Jason 3.3, a line end is ``\\n`` and a quote ``\\"``."""
    return _ESCAPE.sub(lambda match: match[1].replace("n", "\n"), text)


def render(term: Term) -> str:
    """A term as Jason prints it: a text without quotes, and those in a term without escapes."""
    if isinstance(term, String):
        return term.value
    return unescape(str(term))


def size_of(term: object) -> int:
    """The terms in a term, each as often as it occurs; long texts count as several, plans and variables as none."""
    if isinstance(term, (Structure, ListTerm, Arithmetic, Call)):
        return term.size
    return len(term.value) // CHARACTERS if isinstance(term, String) else 0


def is_ground(term: Term) -> bool:
    """Whether a term has neither variables nor expressions to evaluate."""
    if type(term) is Structure or type(term) is ListTerm:
        return term.ground
    return isinstance(term, (Number, String, CollectionTerm))


def holds_collection(term: Term | None) -> bool:
    """Whether a set, map or queue is in a term, so that its text may change."""
    if isinstance(term, Structure):
        # A structure without collections keeps its text; those of its parts were computed just before.
        return term._text is None and any(map(holds_collection, term.args + term.annots))
    if isinstance(term, ListTerm):
        return holds_collection(term.tail) or any(map(holds_collection, term.items))
    return isinstance(term, CollectionTerm)


def is_evaluable(term: Term) -> bool:
    """Whether a term contains expressions that have a value when their variables are bound."""
    if isinstance(term, (Structure, ListTerm)):
        return term.evaluable
    return isinstance(term, (Arithmetic, Call))


def is_name(term: Term) -> bool:
    """Whether a term is a plain name: no arguments, no annotations, not negated."""
    return isinstance(term, Structure) and not term.args and not term.annots and not term.negated and term.ground


@lru_cache(maxsize=4096)  # more than there are agents: one object for each, which is compared by identity first
def source(agent: str) -> Structure:
    """The annotation ``source(agent)``."""
    return Structure("source", (Structure(agent),))


SOURCE_SELF = source("self")
SOURCE_PERCEPT = source("percept")


def sort_terms(terms: tuple[Term, ...]) -> tuple[Term, ...]:
    """The terms in term order, each once."""
    if len(terms) < 2:
        return terms
    ordered: list[Term] = []
    for term in sorted(terms, key=term_order):
        if not ordered or ordered[-1] != term:
            ordered.append(term)
    return tuple(ordered)


def term_order(term: Term) -> tuple[object, ...]:
    """Sort key of Jason's term order: numbers, strings, lists, literals, negated literals, variables.

    Lists go by length, then by their items; literals by arity, functor, arguments, annotations.
    """
    if isinstance(term, Number):
        return (0, float(term))
    if isinstance(term, String):
        return (1, term.value)
    if isinstance(term, ListTerm):
        return (2, len(term.items), *map(term_order, term.items))
    if isinstance(term, Structure):
        annots = tuple(map(term_order, term.annots))
        return (4 if term.negated else 3, len(term.args), term.functor, tuple(map(term_order, term.args)), annots)
    return (6 if isinstance(term, Variable) else 5, str(term))
