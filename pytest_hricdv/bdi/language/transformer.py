"""Builds the beliefs, goals, plans and directives of a program from the parse tree; needs lark."""

from __future__ import annotations

from typing import cast

from lark import v_args
from lark.tree import Meta

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.plan_patterns import PlanPattern, expand_pattern, plans_in
from pytest_hricdv.bdi.language.statement_transformer import StatementTransformer
from pytest_hricdv.bdi.language.syntax import (
    GOAL_STATE,
    GOAL_STATES,
    STATE,
    TRUE,
    Formula,
    GoalTerm,
    Include,
    InitialGoal,
    NameSpaceBlock,
    Plan,
    Rule,
    Trigger,
)
from pytest_hricdv.bdi.language.syntax_tree import variables_of, with_constants_evaluated
from pytest_hricdv.bdi.language.term_transformer import Children
from pytest_hricdv.bdi.language.terms import Qualified, Structure, Term, Variable, is_name

_NO_NAME = "_plan"
"""The label of a plan without a name until it gets an automatic one: no source can contain it."""


@v_args(meta=True)
class AgentSpeakTransformer(StatementTransformer):
    """One method for each grammar rule of a program; those of its terms and statements are inherited."""

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
        # A condition may be believed, and be asked where a variable for it is a condition.
        self._hand_over(items[0])
        self._without_conditions()
        literal = self._evaluate(meta, self._of_known_space(meta, items[0]))
        free = variables_of(literal)
        # As in Jason, an initial belief with variables holds for any value of them: a rule without conditions.
        return Rule(literal, TRUE, self._at(meta), tuple(sorted(free))) if free else literal

    def rule(self, meta: Meta, items: Children) -> Rule:
        self._without_conditions()
        rule: Rule = items[0]
        return rule

    def rule_text(self, meta: Meta, items: Children) -> Rule:
        head, body = self._of_known_space(meta, items[0]), self._formula(meta, items[1])
        return Rule(head, body, self._at(meta), tuple(sorted(variables_of((head, body)))))

    def goal(self, meta: Meta, items: Children) -> InitialGoal:
        self._without_conditions()
        if not isinstance(items[0], Structure):
            raise self._error(meta, f"expected a literal as an initial goal, found {items[0]}")
        return InitialGoal(self._evaluate(meta, items[0]))

    def _of_known_space(self, meta: Meta, literal: GoalTerm) -> Structure:
        if not isinstance(literal, Structure):
            raise self._error(meta, f"expected a literal with a name as its name space, found {literal}")
        return literal

    def _evaluate(self, meta: Meta, literal: Structure) -> Structure:
        """An initial belief or goal with the values of expressions without variables: ``p(1 + 2)`` is ``p(3)``."""
        try:
            return cast(Structure, with_constants_evaluated(literal))
        except EvaluationError as error:
            raise self._error(meta, str(error)) from None

    def include(self, meta: Meta, items: Children) -> Include:
        return Include(self._unquote(items[0]), self._at(meta), None if items[1] is None else str(items[1]))

    def declaration(self, meta: Meta, items: Children) -> NameSpaceBlock:
        return self._name_space(meta, Structure("namespace", tuple(items[0])), None)

    def _name_space(self, meta: Meta, directive: Structure, items: Children | None) -> NameSpaceBlock:
        name, *kinds = directive.args
        scopes = [{"local": True, "global": False}.get(str(kind)) for kind in kinds]
        if not is_name(name) or len(scopes) > 1 or None in scopes:
            raise self._error(meta, f"expected namespace(name), or namespace(name, local), found {directive}")
        self.has_spaces = True
        scope = scopes[0] if scopes else None
        return NameSpaceBlock(str(name), scope, None if items is None else tuple(items), self._at(meta))

    def function(self, meta: Meta, items: Children) -> None:
        name = self._unquote(items[0])
        if items[1] is None:
            if "." in name:
                return  # a class of Java, which there is none of: as that of an action, an error where it is called
            raise self._error(
                meta,
                f"{name} is a function in Java; expected one of a rule: "
                f'{{ register_function("{name}", 1, "p") }} for a rule p(X, Value)',
            )
        self._functions[name, int(items[1])] = self._unquote(items[2])

    def pattern(self, meta: Meta, items: Children) -> PlanPattern | NameSpaceBlock:
        directive, *parts = items
        if directive.functor == "namespace" and directive.args:
            return self._name_space(meta, directive, parts)
        if not all(isinstance(part, (Plan, PlanPattern)) for part in parts):
            raise self._error(meta, f"expected plans only in {{ begin {directive} }}")
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
        label = self._of_known_space(meta, items[0])
        if label.args or label.negated:
            raise self._error(meta, f"expected a name as a plan's label, found {label}")
        return label

    def label_without_name(self, meta: Meta, items: Children) -> Structure:
        annots, tail = items[0]
        return Structure(_NO_NAME).with_annotations(annots, tail)

    def trigger(self, meta: Meta, items: Children) -> Trigger:
        sign = str(items[0]) + ("" if items[1] is None else str(items[1]))
        if sign == GOAL_STATE:
            self._see_whether_it_may_come(meta, items[2])
        return Trigger(sign, items[2])

    def _see_whether_it_may_come(self, meta: Meta, goal: GoalTerm) -> None:
        """Warn of a plan for the event of a goal's state that never comes."""
        literal = goal.literal if isinstance(goal, Qualified) else goal
        annots = () if isinstance(literal, Variable) else literal.annots
        states = [annot.args[0] for annot in annots if isinstance(annot, Structure) and annot.key == STATE]
        for state in states:
            if not isinstance(state, Variable) and str(state) not in GOAL_STATES:
                self.warnings.append(
                    f"{self._at(meta)}: the state {state} of a goal never comes here, so this plan is never executed; "
                    f"those that come are {', '.join(GOAL_STATES)}"
                )

    def context(self, meta: Meta, items: Children) -> Formula | None:
        return None if items[0] is None else self._formula(meta, items[0])
