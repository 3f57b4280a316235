"""`AgentSpeakTransformer` builds the plans, beliefs, goals and directives of a program from lark's parse tree.

The parser (`bdi.language.parser`) applies it to each source; its base class builds terms and formulas.
"""

from __future__ import annotations

from typing import cast

from lark import v_args
from lark.tree import Meta

from pytest_hricdv.bdi.language import syntax
from pytest_hricdv.bdi.language.errors import NO_LOCATION, EvaluationError, Location
from pytest_hricdv.bdi.language.namespaces import NamespaceBlock
from pytest_hricdv.bdi.language.plan_patterns import PlanPattern, expand_pattern, plans_in
from pytest_hricdv.bdi.language.syntax_tree import variables_of, with_constants_evaluated
from pytest_hricdv.bdi.language.term_transformer import Children, TermTransformer
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Call,
    PlanTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
    is_name,
    unescape,
)

_NO_NAME = "_plan"
"""The label of a plan without a name until it gets an automatic one: no source can contain it."""


@v_args(meta=True)
class AgentSpeakTransformer(TermTransformer):
    """One method for each grammar rule of a program; methods for its terms are inherited."""

    def start(self, meta: Meta, items: Children) -> Children:
        self._without_conditions()
        return items

    def one_term(self, meta: Meta, items: Children) -> Term:
        self._without_conditions()
        return self._term(meta, items[0])

    def one_trigger(self, meta: Meta, items: Children) -> syntax.PlanTrigger:
        self._without_conditions()
        trigger: syntax.PlanTrigger = items[0]
        return trigger

    def one_plan(self, meta: Meta, items: Children) -> syntax.Plan:
        self._without_conditions()
        plan: syntax.Plan = items[0]
        return plan

    def belief(self, meta: Meta, items: Children) -> Structure | syntax.Rule:
        # A condition may be believed, and be asked where a variable for it is a condition.
        self._hand_over(items[0])
        self._without_conditions()
        literal = self._evaluate(meta, self._require_known_space(meta, items[0]))
        free = variables_of(literal)
        # As in Jason, an initial belief with variables holds for any value of them: a rule without conditions.
        return syntax.Rule(literal, syntax.TRUE, self._at(meta), tuple(sorted(free))) if free else literal

    def rule(self, meta: Meta, items: Children) -> syntax.Rule:
        self._without_conditions()
        rule: syntax.Rule = items[0]
        return rule

    def rule_text(self, meta: Meta, items: Children) -> syntax.Rule:
        head, body = self._require_known_space(meta, items[0]), self._formula(meta, items[1])
        return syntax.Rule(head, body, self._at(meta), tuple(sorted(variables_of((head, body)))))

    def goal(self, meta: Meta, items: Children) -> syntax.InitialGoal:
        self._without_conditions()
        if not isinstance(items[0], Structure):
            raise self._error(meta, f"expected a literal as an initial goal, found {items[0]}")
        return syntax.InitialGoal(self._evaluate(meta, items[0]))

    def _require_known_space(self, meta: Meta, literal: syntax.GoalTerm) -> Structure:
        if not isinstance(literal, Structure):
            raise self._error(meta, f"expected a literal with a name as its namespace, found {literal}")
        return literal

    def _evaluate(self, meta: Meta, literal: Structure) -> Structure:
        """An initial belief or goal with the values of expressions without variables: ``p(1 + 2)`` is ``p(3)``."""
        try:
            return cast(Structure, with_constants_evaluated(literal))
        except EvaluationError as error:
            raise self._error(meta, str(error)) from None

    def include(self, meta: Meta, items: Children) -> syntax.Include:
        return syntax.Include(unescape(items[0][1:-1]), self._at(meta), None if items[1] is None else str(items[1]))

    def declaration(self, meta: Meta, items: Children) -> NamespaceBlock:
        return self._namespace(meta, Structure("namespace", tuple(items[0])), None)

    def _namespace(self, meta: Meta, directive: Structure, items: Children | None) -> NamespaceBlock:
        name, *kinds = directive.args
        scopes = [{"local": True, "global": False}.get(str(kind)) for kind in kinds]
        if not is_name(name) or len(scopes) > 1 or None in scopes:
            raise self._error(meta, f"expected namespace(name), or namespace(name, local), found {directive}")
        self.has_spaces = True
        scope = scopes[0] if scopes else None
        return NamespaceBlock(str(name), scope, None if items is None else tuple(items), self._at(meta))

    def function(self, meta: Meta, items: Children) -> None:
        name = unescape(items[0][1:-1])
        if items[1] is None:
            if "." in name:
                return  # a class of Java, which there is none of: as that of an action, an error where it is called
            raise self._error(
                meta,
                f"{name} is a function in Java; expected one of a rule: "
                f'{{ register_function("{name}", 1, "p") }} for a rule p(X, Value)',
            )
        self._functions[name, int(items[1])] = unescape(items[2][1:-1])

    def pattern(self, meta: Meta, items: Children) -> PlanPattern | NamespaceBlock:
        directive, *parts = items
        if directive.functor == "namespace" and directive.args:
            return self._namespace(meta, directive, parts)
        if not all(isinstance(part, (syntax.Plan, PlanPattern)) for part in parts):
            raise self._error(meta, f"expected plans only in {{ begin {directive} }}")
        try:
            return expand_pattern(directive, plans_in(parts), self._at(meta))
        except EvaluationError as error:
            raise self._error(meta, str(error)) from None

    def plan(self, meta: Meta, items: Children) -> syntax.Plan:
        self._without_conditions()
        plan: syntax.Plan = items[0]
        return plan

    def plan_text(self, meta: Meta, items: Children) -> syntax.Plan:
        label, trigger, context, body = items
        name, annots = (_NO_NAME, ()) if label is None else (label.functor, label.annots)
        return syntax.Plan(name, trigger, context, body, self._at(meta), annots)

    def label(self, meta: Meta, items: Children) -> Structure:
        label = self._require_known_space(meta, items[0])
        if label.args or label.negated:
            raise self._error(meta, f"expected a name as a plan's label, found {label}")
        return label

    def label_without_name(self, meta: Meta, items: Children) -> Structure:
        annots, tail = items[0]
        return Structure(_NO_NAME).with_annotations(annots, tail)

    def trigger(self, meta: Meta, items: Children) -> syntax.PlanTrigger:
        sign = str(items[0]) + ("" if items[1] is None else str(items[1]))
        if sign == syntax.GOAL_STATE:
            self._see_whether_it_may_come(meta, items[2])
        return syntax.PlanTrigger(sign, items[2])

    def _see_whether_it_may_come(self, meta: Meta, goal: syntax.GoalTerm) -> None:
        """Warn of a plan for the event of a goal's state that never comes."""
        literal = goal.literal if isinstance(goal, QualifiedLiteral) else goal
        annots = () if isinstance(literal, Variable) else literal.annots
        states = [annot.args[0] for annot in annots if isinstance(annot, Structure) and annot.key == syntax.STATE]
        for state in states:
            if not isinstance(state, Variable) and str(state) not in syntax.GOAL_STATES:
                self.warnings.append(
                    f"{self._at(meta)}: the state {state} of a goal never comes here, so this plan is never executed; "
                    f"those that come are {', '.join(syntax.GOAL_STATES)}"
                )

    def context(self, meta: Meta, items: Children) -> syntax.Formula | None:
        return None if items[0] is None else self._formula(meta, items[0])

    # --- statements and bodies

    _NOTHING = syntax.ConditionStatement(syntax.TRUE, NO_LOCATION)

    def body(self, meta: Meta, items: Children) -> syntax.Body:
        # 'true' as a statement is how an empty body is written out.
        return tuple(item for item in items if item is not None and item != self._NOTHING)

    block_body = body
    body_text = body

    def achieve(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.AchievementGoal(self._hand_over(items[0]), False, self._at(meta))

    def achieve_later(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.AchievementGoal(self._hand_over(items[0]), True, self._at(meta))

    def test(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.TestGoal(self._formula(meta, items[0]), self._at(meta))

    def believe(self, meta: Meta, items: Children) -> syntax.Statement:
        # '+<' adds what queries find first: a belief that is added always is.
        return syntax.BeliefUpdate(str(items[0]).removesuffix("<"), self._hand_over(items[1]), self._at(meta))

    def add_plan(self, meta: Meta, items: Children) -> syntax.Statement:
        sign, _, plan, _ = items
        place = Structure("end" if sign == "+>" else "begin")
        return syntax.InternalActionCall(
            Call(".add_plan", (PlanTerm(plan), Structure("self"), place), self._at(meta)), self._at(meta)
        )

    def believe_rule(self, meta: Meta, items: Children) -> syntax.Statement:
        sign, _, rule, _ = items
        return syntax.BeliefUpdate(str(sign), PlanTerm(rule), self._at(meta))

    def fork_all(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.ForkStatement(tuple((item,) for item in items), True, self._at(meta))

    def fork_one(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.ForkStatement(tuple((item,) for item in items), False, self._at(meta))

    def literal_group(self, meta: Meta, items: Children) -> syntax.GoalTerm:
        if not isinstance(items[0], syntax.GoalTerm):
            raise self._error(meta, f"expected a literal in the parentheses, found {items[0]}")
        return items[0]

    def perform(self, meta: Meta, items: Children) -> syntax.Statement:
        formula = self._formula(meta, items[0])
        place = self._at(meta)
        if isinstance(formula, Call):
            return as_block(formula, place) or syntax.InternalActionCall(formula, place)
        truth = isinstance(formula, Structure) and formula.functor in ("true", "false") and not formula.args
        if isinstance(formula, (Structure, Variable, AnnotatedVariable)) and not truth:
            return syntax.ExternalAction(formula, place)
        return syntax.ConditionStatement(formula, place)

    def if_block(self, meta: Meta, items: Children) -> syntax.Statement:
        condition, then, otherwise = items
        if isinstance(otherwise, syntax.If):
            otherwise = (otherwise,)
        return syntax.If(self._formula(meta, condition), then, otherwise or (), self._at(meta))

    def else_body(self, meta: Meta, items: Children) -> syntax.Body:
        body: syntax.Body = items[0]
        return body

    def while_block(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.While(self._formula(meta, items[0]), items[1], self._at(meta))

    def for_block(self, meta: Meta, items: Children) -> syntax.Statement:
        return syntax.For(self._formula(meta, items[0]), items[1], self._at(meta))


def _body_of(block: object) -> syntax.Body | None:
    """The body that a block stands for: ``{ +p }`` alone is a plan's event as well; None for any other plan."""
    match block:
        case PlanTerm(plan=tuple(body)):
            return body
        case PlanTerm(plan=syntax.Plan(trigger=event, context=None, body=(), label=label) as plan):
            if event.sign in ("+", "-") and label.startswith("_") and isinstance(event.literal, Structure):
                return (syntax.BeliefUpdate(event.sign, event.literal, plan.location),)
    return None


def as_block(call: Call, place: Location) -> syntax.Statement | None:
    """The block that an internal action of old stands for, as ``.foreach(p(X), { act(X) })`` for a ``for``."""
    condition, *blocks = call.args or (None,)
    bodies = [body for body in map(_body_of, blocks) if body is not None]
    if not isinstance(condition, syntax.Formula) or not bodies or len(bodies) < len(blocks):
        return None
    if call.name == ".fork" and str(condition) in ("and", "or"):
        return syntax.ForkStatement(tuple(bodies), str(condition) == "and", place)
    if call.name == ".foreach" and len(bodies) == 1:
        return syntax.For(condition, bodies[0], place)
    if call.name == ".loop" and len(bodies) == 1:
        return syntax.While(condition, bodies[0], place)
    if call.name == ".if_then_else" and len(bodies) <= 2:
        return syntax.If(condition, bodies[0], bodies[1] if len(bodies) == 2 else (), place)
    return None
