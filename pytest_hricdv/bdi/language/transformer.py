"""Builds terms, formulas, statements and plans from the parse tree; needs lark."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, cast

from lark import v_args
from lark.tree import Meta
from lark.visitors import Transformer_NonRecursive

from pytest_hricdv.bdi.language.errors import NO_LOCATION, BdiSyntaxError, EvaluationError, Location
from pytest_hricdv.bdi.language.plan_patterns import PlanPattern, expand_pattern, plans_in
from pytest_hricdv.bdi.language.syntax import (
    GOAL_STATE,
    GOAL_STATES,
    STATE,
    TRUE,
    AchievementGoal,
    And,
    BeliefUpdate,
    Body,
    Comparison,
    ConditionStatement,
    ExternalAction,
    For,
    Fork,
    Formula,
    GoalTerm,
    If,
    Include,
    InitialGoal,
    InternalActionCall,
    Not,
    Or,
    Plan,
    Rule,
    Statement,
    TestGoal,
    Trigger,
    While,
)
from pytest_hricdv.bdi.language.syntax_tree import parts_of, variables_of, with_constants_evaluated
from pytest_hricdv.bdi.language.terms import (
    VALUE_BY_RULE,
    AnnotatedVariable,
    Arithmetic,
    Call,
    FormulaTerm,
    ListTerm,
    Number,
    PlanTerm,
    String,
    Structure,
    Term,
    Variable,
    is_name,
    source,
)

_NO_NAME = "_plan"
"""The label of a plan without a name until it gets an automatic one: no source can contain it."""
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r"}
_NUMBERED = re.compile(r"\b_(\d{1,9})\b")
_FORMULA_ONLY = (And, Or, Not, Comparison)
Children = list[Any]


@v_args(meta=True)
class AgentSpeakTransformer(Transformer_NonRecursive):  # type: ignore[type-arg]
    """One method for each grammar rule; it gets the position of the rule's text and the values of its parts."""

    _NOTHING = ConditionStatement(TRUE, NO_LOCATION)

    def __init__(self) -> None:
        super().__init__()
        self.begin("", "")

    def begin(self, text: str, file: str) -> None:
        """Start a new source: errors refer to it, and the numbers of anonymous variables start again."""
        self._text = text
        self._file = file
        self._functions: dict[tuple[str, int], str] = {}
        """Functions that a directive registers, and the predicates of their rules."""
        self._anonymous = 0
        self._conditions: list[FormulaTerm] = []
        """The conditions found in the place of a term: what hands none over must not have any."""
        self._numbered = {int(number) for number in _NUMBERED.findall(text)} if "_" in text else set()
        """The numbers of variables that the author has named so, as `_1`: they are not given to other ones."""

    def _at(self, meta: Meta) -> Location:
        return Location(self._file, getattr(meta, "line", 1), getattr(meta, "column", 1))

    def _error(self, meta: Meta, message: str) -> BdiSyntaxError:
        return BdiSyntaxError.at(message, self._at(meta), self._text)

    # --- the program

    def start(self, meta: Meta, items: Children) -> Children:
        self._without_conditions()
        return items

    def one_term(self, meta: Meta, items: Children) -> Term:
        self._without_conditions()
        return self._term(meta, items[0])

    def one_trigger(self, meta: Meta, items: Children) -> Trigger:
        self._without_conditions()
        trigger: Trigger = items[0]
        return trigger

    def one_plan(self, meta: Meta, items: Children) -> Plan:
        self._without_conditions()
        plan: Plan = items[0]
        return plan

    def belief(self, meta: Meta, items: Children) -> Structure | Rule:
        self._without_conditions()
        literal = self._computed(meta, items[0])
        free = variables_of(literal)
        # As in Jason, an initial belief with variables holds for any value of them: a rule without conditions.
        return Rule(literal, TRUE, self._at(meta), tuple(sorted(free))) if free else literal

    def rule(self, meta: Meta, items: Children) -> Rule:
        self._without_conditions()
        head, body = items[0], self._formula(meta, items[1])
        return Rule(head, body, self._at(meta), tuple(sorted(variables_of((head, body)))))

    def goal(self, meta: Meta, items: Children) -> InitialGoal:
        self._without_conditions()
        if not isinstance(items[0], Structure):
            raise self._error(meta, f"expected a literal as an initial goal, found {items[0]}")
        return InitialGoal(self._computed(meta, items[0]))

    def _computed(self, meta: Meta, literal: Structure) -> Structure:
        """An initial belief or goal with the values of expressions without variables: ``p(1 + 2)`` is ``p(3)``."""
        try:
            return cast(Structure, with_constants_evaluated(literal))
        except EvaluationError as error:
            raise self._error(meta, str(error)) from None

    def include(self, meta: Meta, items: Children) -> Include:
        return Include(self._unquoted(items[0]), self._at(meta))

    def function(self, meta: Meta, items: Children) -> None:
        name = self._unquoted(items[0])
        if items[1] is None:
            raise self._error(
                meta,
                f"{name} is a function in Java; expected one of a rule: "
                f'{{ register_function("{name}", 1, "p") }} for a rule p(X, Value)',
            )
        self._functions[name, int(items[1])] = self._unquoted(items[2])

    def pattern(self, meta: Meta, items: Children) -> PlanPattern:
        directive, *parts = items
        try:
            return expand_pattern(directive, plans_in(parts), self._at(meta))
        except EvaluationError as error:
            raise self._error(meta, str(error)) from None

    def plan(self, meta: Meta, items: Children) -> Plan:
        self._without_conditions()
        plan: Plan = items[0]
        return plan

    def plan_text(self, meta: Meta, items: Children) -> Plan:
        label, trigger, context, body = items
        name, annots = (_NO_NAME, ()) if label is None else (label.functor, label.annots)
        return Plan(name, trigger, context, body, self._at(meta), annots)

    def label(self, meta: Meta, items: Children) -> Structure:
        label: Structure = items[0]
        if label.args or label.negated:
            raise self._error(meta, f"expected a name as a plan's label, found {label}")
        return label

    def label_without_name(self, meta: Meta, items: Children) -> Structure:
        annots, tail = items[0]
        return Structure(_NO_NAME).with_annotations(annots, tail)

    def trigger(self, meta: Meta, items: Children) -> Trigger:
        sign = str(items[0]) + ("" if items[1] is None else str(items[1]))
        if sign == GOAL_STATE:
            self._see_that_it_may_come(meta, items[2])
        return Trigger(sign, items[2])

    def _see_that_it_may_come(self, meta: Meta, goal: GoalTerm) -> None:
        """See that an event of a goal's state names none that never comes."""
        annots = () if isinstance(goal, Variable) else goal.annots
        states = [annot.args[0] for annot in annots if isinstance(annot, Structure) and annot.key == STATE]
        for state in states:
            if not isinstance(state, Variable) and str(state) not in GOAL_STATES:
                raise self._error(meta, f"expected {', '.join(GOAL_STATES)} or a variable as the state, found {state}")

    def context(self, meta: Meta, items: Children) -> Formula | None:
        return None if items[0] is None else self._formula(meta, items[0])

    # --- bodies

    def body(self, meta: Meta, items: Children) -> Body:
        # 'true' as a statement is how an empty body is written out.
        return tuple(item for item in items if item is not None and item != self._NOTHING)

    block_body = body
    body_text = body

    def achieve(self, meta: Meta, items: Children) -> Statement:
        return AchievementGoal(self._handed_over(items[0]), False, self._at(meta))

    def achieve_later(self, meta: Meta, items: Children) -> Statement:
        return AchievementGoal(self._handed_over(items[0]), True, self._at(meta))

    def test(self, meta: Meta, items: Children) -> Statement:
        return TestGoal(self._formula(meta, items[0]), self._at(meta))

    def believe(self, meta: Meta, items: Children) -> Statement:
        # '+<' adds what queries find first: a belief that is added always is.
        return BeliefUpdate(str(items[0]).removesuffix("<"), items[1], self._at(meta))

    def fork_all(self, meta: Meta, items: Children) -> Statement:
        return Fork(tuple((item,) for item in items), True, self._at(meta))

    def fork_one(self, meta: Meta, items: Children) -> Statement:
        return Fork(tuple((item,) for item in items), False, self._at(meta))

    def literal_group(self, meta: Meta, items: Children) -> GoalTerm:
        if not isinstance(items[0], GoalTerm):
            raise self._error(meta, f"expected a literal in the parentheses, found {items[0]}")
        return items[0]

    def perform(self, meta: Meta, items: Children) -> Statement:
        formula = self._formula(meta, items[0])
        place = self._at(meta)
        if isinstance(formula, Call):
            return as_block(formula, place) or InternalActionCall(formula, place)
        truth = isinstance(formula, Structure) and formula.functor in ("true", "false") and not formula.args
        if isinstance(formula, (Structure, Variable, AnnotatedVariable)) and not truth:
            return ExternalAction(formula, place)
        return ConditionStatement(formula, place)

    def if_block(self, meta: Meta, items: Children) -> Statement:
        condition, then, otherwise = items
        if isinstance(otherwise, If):
            otherwise = (otherwise,)
        return If(self._formula(meta, condition), then, otherwise or (), self._at(meta))

    def else_body(self, meta: Meta, items: Children) -> Body:
        body: Body = items[0]
        return body

    def while_block(self, meta: Meta, items: Children) -> Statement:
        return While(self._formula(meta, items[0]), items[1], self._at(meta))

    def for_block(self, meta: Meta, items: Children) -> Statement:
        return For(self._formula(meta, items[0]), items[1], self._at(meta))

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

    def _handed_over(self, goal: GoalTerm) -> GoalTerm:
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
        return Arithmetic(str(operator), (self._term(meta, left), self._term(meta, right)))

    def minus(self, meta: Meta, items: Children) -> Term:
        operand = self._term(meta, items[0])
        # A negative number is a constant, which matches without being computed.
        return Number(-operand) if isinstance(operand, Number) else Arithmetic("-", (operand,))

    def number(self, meta: Meta, items: Children) -> Term:
        return Number(items[0])

    def string(self, meta: Meta, items: Children) -> Term:
        return String(self._unquoted(items[0]))

    @staticmethod
    def _unquoted(token: str) -> str:
        return re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), token[1:-1], flags=re.DOTALL)

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

    def quoted(self, meta: Meta, items: Children) -> Term:
        return PlanTerm(items[0])

    def literal(self, meta: Meta, items: Children) -> Structure:
        negation, functor, arguments, annotations = items
        args = tuple(self._argument(meta, argument) for argument in arguments or ())
        annots, tail = annotations or ((), None)
        if functor == "source" and not annotations and not negation and len(args) == 1 and is_name(args[0]):
            # The same object as in messages and beliefs: comparing it is fast.
            return source(str(args[0]))
        return Structure(_in_name_space(str(functor)), args, (), negation is not None).with_annotations(annots, tail)

    def variable(self, meta: Meta, items: Children) -> GoalTerm:
        negation, token, annotations = items
        name = str(token)
        if name[0] == "_" and not name[1:2].isdigit():
            # Each is a variable of its own, in Jason also those with a name, `_q`; numbered from 1 (see `FIRST_FRESH`
            # of the runs). Only `_1` is the same variable wherever it stands in a plan.
            name = self._new_name()
        annots, tail = annotations or ((), None)
        if negation is None and annotations is None:
            return Variable(name)
        return AnnotatedVariable(Variable(name), annots, tail, negation is not None)

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


def as_block(call: Call, place: Location) -> Statement | None:
    """The block that an internal action of old stands for, as ``.foreach(p(X), { act(X) })`` for a ``for``."""
    condition, *blocks = call.args or (None,)
    bodies = [block.plan for block in blocks if isinstance(block, PlanTerm) and isinstance(block.plan, tuple)]
    if not isinstance(condition, Formula) or not bodies or len(bodies) < len(blocks):
        return None
    if call.name == ".foreach" and len(bodies) == 1:
        return For(condition, bodies[0], place)
    if call.name == ".loop" and len(bodies) == 1:
        return While(condition, bodies[0], place)
    if call.name == ".if_then_else" and len(bodies) <= 2:
        return If(condition, bodies[0], bodies[1] if len(bodies) == 2 else (), place)
    return None


def _in_name_space(name: str) -> str:
    """A functor as it is kept: one of the default name space, ``default::p`` or ``::p``, without it."""
    return name.removeprefix("default").removeprefix("::") if "::" in name else name


@dataclass(frozen=True, slots=True)
class _Tail:
    """The term after ``|`` in a list or in annotations."""

    term: Variable | ListTerm
