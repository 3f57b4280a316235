"""Builds statements and bodies of plans from the parse tree; needs lark."""

from __future__ import annotations

from lark import v_args
from lark.tree import Meta

from pytest_hricdv.bdi.language.errors import NO_LOCATION, Location
from pytest_hricdv.bdi.language.syntax import (
    TRUE,
    AchievementGoal,
    BeliefUpdate,
    Body,
    ConditionStatement,
    ExternalAction,
    For,
    ForkStatement,
    Formula,
    GoalTerm,
    If,
    InternalActionCall,
    Statement,
    TestGoal,
    While,
)
from pytest_hricdv.bdi.language.term_transformer import Children, TermTransformer
from pytest_hricdv.bdi.language.terms import AnnotatedVariable, Call, PlanTerm, Structure, Variable


@v_args(meta=True)
class StatementTransformer(TermTransformer):
    """One method for each grammar rule of a statement or a body."""

    _NOTHING = ConditionStatement(TRUE, NO_LOCATION)

    def body(self, meta: Meta, items: Children) -> Body:
        # 'true' as a statement is how an empty body is written out.
        return tuple(item for item in items if item is not None and item != self._NOTHING)

    block_body = body
    body_text = body

    def achieve(self, meta: Meta, items: Children) -> Statement:
        return AchievementGoal(self._hand_over(items[0]), False, self._at(meta))

    def achieve_later(self, meta: Meta, items: Children) -> Statement:
        return AchievementGoal(self._hand_over(items[0]), True, self._at(meta))

    def test(self, meta: Meta, items: Children) -> Statement:
        return TestGoal(self._formula(meta, items[0]), self._at(meta))

    def believe(self, meta: Meta, items: Children) -> Statement:
        # '+<' adds what queries find first: a belief that is added always is.
        return BeliefUpdate(str(items[0]).removesuffix("<"), self._hand_over(items[1]), self._at(meta))

    def add_plan(self, meta: Meta, items: Children) -> Statement:
        sign, _, plan, _ = items
        place = Structure("end" if sign == "+>" else "begin")
        return InternalActionCall(
            Call(".add_plan", (PlanTerm(plan), Structure("self"), place), self._at(meta)), self._at(meta)
        )

    def believe_rule(self, meta: Meta, items: Children) -> Statement:
        sign, _, rule, _ = items
        return BeliefUpdate(str(sign), PlanTerm(rule), self._at(meta))

    def fork_all(self, meta: Meta, items: Children) -> Statement:
        return ForkStatement(tuple((item,) for item in items), True, self._at(meta))

    def fork_one(self, meta: Meta, items: Children) -> Statement:
        return ForkStatement(tuple((item,) for item in items), False, self._at(meta))

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


def as_block(call: Call, place: Location) -> Statement | None:
    """The block that an internal action of old stands for, as ``.foreach(p(X), { act(X) })`` for a ``for``."""
    condition, *blocks = call.args or (None,)
    bodies = [block.plan for block in blocks if isinstance(block, PlanTerm) and isinstance(block.plan, tuple)]
    if not isinstance(condition, Formula) or not bodies or len(bodies) < len(blocks):
        return None
    if call.name == ".fork" and str(condition) in ("and", "or"):
        return ForkStatement(tuple(bodies), str(condition) == "and", place)
    if call.name == ".foreach" and len(bodies) == 1:
        return For(condition, bodies[0], place)
    if call.name == ".loop" and len(bodies) == 1:
        return While(condition, bodies[0], place)
    if call.name == ".if_then_else" and len(bodies) <= 2:
        return If(condition, bodies[0], bodies[1] if len(bodies) == 2 else (), place)
    return None
