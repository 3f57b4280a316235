"""`TermTransformer` builds terms and formulas from the parse tree that lark makes of a source.

A term is data, such as `leg(2)` or `X + 1`; a formula is a condition, such as `bored & X > 1`. The parser uses the
subclass `AgentSpeakTransformer`, which adds plans and whole programs.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, cast

from lark import v_args
from lark.tree import Meta
from lark.visitors import Transformer_NonRecursive

from pytest_hricdv.bdi.language.errors import BdiSyntaxError, Location
from pytest_hricdv.bdi.language.syntax import And, Comparison, Formula, GoalTerm, Not, Or
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import (
    VALUE_BY_RULE,
    AnnotatedVariable,
    Arithmetic,
    Call,
    FormulaTerm,
    ListTerm,
    Number,
    PlanTerm,
    QualifiedLiteral,
    String,
    Structure,
    Term,
    Variable,
    is_name,
    source,
    unescape,
)

_NUMBERED = re.compile(r"\b_(\d{1,9})\b")
"""A variable that the author has named `_1`, `_2` and so on."""
_FORMULA_ONLY = (And, Or, Not, Comparison)
"""Formulas that cannot be terms, unlike a literal."""
Children = list[Any]
"""What the transformer made of the parts of a grammar rule."""


@v_args(meta=True)
class TermTransformer(Transformer_NonRecursive):  # type: ignore[type-arg]
    """A method for each grammar rule of a term or formula; it gets the position in the text, and the rule's parts."""

    def __init__(self) -> None:
        super().__init__()
        self.begin("", "")

    def begin(self, text: str, file: str) -> None:
        """Start a new source: errors refer to it, and the numbers of anonymous variables start again."""
        self._text = text
        self._file = file
        self.warnings: list[str] = []
        """Warnings for the author of the source, with their places."""
        self.has_spaces = False
        """Whether the source names namespaces."""
        self._functions: dict[tuple[str, int], str] = {}
        """Functions that a directive registers, and the predicates of their rules."""
        self._anonymous = 0
        self._conditions: list[FormulaTerm] = []
        """The conditions found in the place of a term: what hands none over must not have any."""
        self._numbered = {int(number) for number in _NUMBERED.findall(text)} if "_" in text else set()
        """The numbers of variables that the author has named so, as `_1`: they are not given to other ones."""

    @property
    def last_number(self) -> int:
        """The greatest number of a variable `_n`, or more."""
        return max(self._anonymous, *self._numbered, 0)

    def _at(self, meta: Meta) -> Location:
        return Location(self._file, getattr(meta, "line", 1), getattr(meta, "column", 1))

    def _error(self, meta: Meta, message: str) -> BdiSyntaxError:
        return BdiSyntaxError.at(message, self._at(meta), self._text)

    # --- formulas

    def disjoin(self, meta: Meta, items: Children) -> Formula:
        return Or(tuple(self._formula(meta, item) for item in items))

    def conjoin(self, meta: Meta, items: Children) -> Formula:
        return And(tuple(self._formula(meta, item) for item in items))

    def negate(self, meta: Meta, items: Children) -> Formula:
        return Not(self._formula(meta, items[0]))

    def compare(self, meta: Meta, items: Children) -> Formula:
        left, operator, right = items
        return Comparison(str(operator), self._term(meta, left), self._term(meta, right))

    def _formula(self, meta: Meta, value: Any) -> Formula:
        if not isinstance(value, Formula):
            raise self._error(meta, f"expected a condition or an action, found {value}")
        return value

    # --- terms

    def _argument(self, meta: Meta, value: Any) -> Term:
        """A term, or a condition, as long as the literal may turn out to be a goal."""
        if not isinstance(value, _FORMULA_ONLY):
            return cast(Term, value)
        self._conditions.append(FormulaTerm(value, self._at(meta)))
        return self._conditions[-1]

    def _hand_over(self, goal: GoalTerm) -> GoalTerm:
        """The literal of a goal, whose arguments may be conditions."""
        if self._conditions:
            own = [part for part in parts_of(goal) if isinstance(part, FormulaTerm)]
            self._conditions = [condition for condition in self._conditions if all(condition is not o for o in own)]
        return goal

    def _without_conditions(self) -> None:
        """See that no condition is left in the place of a term where only a goal may have one."""
        if self._conditions:
            first = self._conditions[0]
            raise BdiSyntaxError.at(f"expected a term, found the condition {first}", first.location, self._text)

    def _term(self, meta: Meta, value: Any) -> Term:
        if isinstance(value, _FORMULA_ONLY):
            raise self._error(meta, f"expected a term, found the condition {value}")
        term: Term = value
        return term

    def binary(self, meta: Meta, items: Children) -> Term:
        left, operator, right = items
        return Arithmetic(str(operator), (self._operand(meta, left), self._operand(meta, right)))

    def _operand(self, meta: Meta, value: Any) -> Term:
        term = self._term(meta, value)
        if isinstance(term, (String, Structure, ListTerm, PlanTerm)):  # refused as in Jason: it can never be a number
            raise self._error(meta, f"expected a number or a variable in arithmetic, found {term}")
        return term

    def minus(self, meta: Meta, items: Children) -> Term:
        operand = self._operand(meta, items[0])
        # A negative number is a constant, which matches without being computed.
        return Number(-operand) if isinstance(operand, Number) else Arithmetic("-", (operand,))

    def number(self, meta: Meta, items: Children) -> Term:
        return Number(items[0])

    def string(self, meta: Meta, items: Children) -> Term:
        return String(unescape(items[0][1:-1]))

    def call(self, meta: Meta, items: Children) -> Term:
        name, args = str(items[0]), tuple(items[1] or ())
        if (name, len(args)) in self._functions:
            return Call(VALUE_BY_RULE, (Structure(self._functions[name, len(args)], args),), self._at(meta))
        return Call(name, args, self._at(meta))

    def list(self, meta: Meta, items: Children) -> Term:
        terms, tail = self._items(meta, items)
        return ListTerm(terms, tail)

    def group(self, meta: Meta, items: Children) -> Any:
        return items[0]

    def empty_body(self, meta: Meta, items: Children) -> Term:
        return PlanTerm(())

    def plan_term(self, meta: Meta, items: Children) -> Term:
        return PlanTerm(items[0])

    def literal(self, meta: Meta, items: Children) -> Structure | QualifiedLiteral:
        space, negation, functor, arguments, annotations = items
        args = tuple(self._argument(meta, argument) for argument in arguments or ())
        annots, tail = annotations or ((), None)
        if (
            functor == "source"
            and not annotations
            and not negation
            and not space
            and len(args) == 1
            and is_name(args[0])
        ):
            # The same object as in messages and beliefs: comparing it is fast.
            return source(str(args[0]))
        qualifier = self._space(space)
        name = functor if qualifier is None or isinstance(qualifier, Variable) else f"{qualifier.functor}::{functor}"
        literal = Structure(str(name), args, (), negation is not None).with_annotations(annots, tail)
        return QualifiedLiteral(qualifier, literal) if isinstance(qualifier, Variable) else literal

    def _space(self, token: str | None) -> Structure | Variable | None:
        """The namespace before a literal, as written: without a name, it is that of the source."""
        if token is None:
            return None
        self.has_spaces = True
        name = token.removesuffix("::").strip()
        if name[:1].isupper() or name[:1] == "_":
            return Variable(name if name != "_" else self._new_name())
        return Structure(name)

    def variable(self, meta: Meta, items: Children) -> GoalTerm:
        space, negation, token, annotations = items
        name = str(token)
        if name[0] == "_" and not name[1:2].isdigit():
            # Each is a variable of its own, in Jason also those with a name, `_q`; numbered from 1, as are
            # those that runs make. Only `_1` is the same variable wherever it stands in a plan.
            name = self._new_name()
        annots, tail = annotations or ((), None)
        variable: Variable | AnnotatedVariable = Variable(name)
        if negation is not None or annotations is not None:
            variable = AnnotatedVariable(Variable(name), annots, tail, negation is not None)
        qualifier = self._space(space)
        return variable if qualifier is None else QualifiedLiteral(qualifier, variable)

    def _new_name(self) -> str:
        self._anonymous += 1
        while self._anonymous in self._numbered:
            self._anonymous += 1
        return f"_{self._anonymous}"

    def arguments(self, meta: Meta, items: Children) -> Children:
        return items

    def annotations(self, meta: Meta, items: Children) -> tuple[tuple[Term, ...], Variable | None]:
        annots, tail = self._items(meta, items)
        if tail is not None and not isinstance(tail, Variable):
            raise self._error(meta, "expected a variable after '|' in annotations")
        return annots, tail

    def tail(self, meta: Meta, items: Children) -> _Tail:
        if not isinstance(items[0], (Variable, ListTerm)):
            raise self._error(meta, f"expected a variable or a list after '|', found {items[0]}")
        return _Tail(items[0])

    def _items(self, meta: Meta, items: Children) -> tuple[tuple[Term, ...], Term | None]:
        parts = [item for item in items if item is not None]
        tail = parts.pop().term if parts and isinstance(parts[-1], _Tail) else None
        return tuple(self._term(meta, part) for part in parts), tail


@dataclass(frozen=True, slots=True)
class _Tail:
    """The term after ``|`` in a list or in annotations."""

    term: Variable | ListTerm
