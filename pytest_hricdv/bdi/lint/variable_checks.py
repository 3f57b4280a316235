"""Lint's checks of variables, which `lint` runs: variables without a value, and repeated anonymous ones."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language import syntax
from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax_tree import children, variables_of
from pytest_hricdv.bdi.language.terms import Arithmetic, Call, Number, Variable
from pytest_hricdv.bdi.lint.model import Problem, System, check
from pytest_hricdv.bdi.lint.model_builder import FORMULA_ARGUMENTS, files_of, location_of, repeats_of_anonymous


@check(
    "unbound-comparison",
    "An unbound variable is greater than any number and equal to nothing; arithmetic with it fails.",
)
def find_unbound_comparisons(system: System) -> Iterator[Problem]:
    """Comparisons and expressions with variables that nothing before them can bind."""
    for agent in system.agents:
        for rule in agent.rules:
            # A query may bind the variables of the head.
            yield from _BindingAnalysis(rule.location).formula(rule.body, set(variables_of(rule.head)))
        for plan in agent.plans:
            yield from _plan(plan)


@check(
    "repeated-anonymous",
    "As in Jason, `_name` is a new variable at each occurrence: binding one does not bind another.",
)
def find_repeated_anonymous(system: System) -> Iterator[Problem]:
    """Names that begin with ``_`` and occur twice in a plan or rule: each occurrence is a new variable."""
    for file in dict.fromkeys(file for agent in system.agents for file in files_of(agent)):
        yield from repeats_of_anonymous(file)


def _plan(plan: syntax.Plan) -> Iterator[Problem]:
    walk = _BindingAnalysis(plan.location)
    bound = set(variables_of(plan.trigger))
    if plan.context is not None:
        yield from walk.formula(plan.context, bound)
    yield from walk.body(plan.body, bound)


class _BindingAnalysis:
    """Goes through a plan in the order of execution; ``bound`` collects the variables that may have a value."""

    def __init__(self, place: Location) -> None:
        self._place = place

    def formula(self, formula: object, bound: set[Variable]) -> Iterator[Problem]:
        """The problems in a condition."""
        if isinstance(formula, syntax.And):
            for part in formula.parts:
                yield from self.formula(part, bound)
        elif isinstance(formula, syntax.Or):
            branches = [set(bound) for _ in formula.parts]
            for part, branch in zip(formula.parts, branches, strict=True):
                yield from self.formula(part, branch)
            bound.update(*branches)
        elif isinstance(formula, syntax.Not):
            yield from self.formula(formula.part, set(bound))
        elif isinstance(formula, syntax.Comparison):
            yield from self._comparison(formula, bound)
        else:
            bound.update(variables_of(formula))

    def _comparison(self, comparison: syntax.Comparison, bound: set[Variable]) -> Iterator[Problem]:
        unifies = comparison.operator[0] == "=" and comparison.operator != "=="
        for side in (comparison.left, comparison.right):
            used = _used(side) if not unifies or isinstance(side, Arithmetic) else set()
            for variable in sorted(used - bound):
                kind = "expression" if unifies else "comparison"
                name = "_" if variable[1:].isdigit() else str(variable)
                yield (
                    location_of(name, self._place),
                    f"{name} has no value yet in the {kind} {_text(comparison)}",
                )
        if unifies:
            bound.update(variables_of(comparison))

    def body(self, body: syntax.Body, bound: set[Variable]) -> Iterator[Problem]:
        """The problems in statements."""
        for statement in body:
            self._place = statement.location
            yield from self._statement(statement, bound)

    def _statement(self, statement: syntax.Statement, bound: set[Variable]) -> Iterator[Problem]:
        if isinstance(statement, syntax.If):
            inside = set(bound)
            yield from self.formula(statement.condition, inside)
            yield from self.body(statement.then, inside)
            yield from self.body(statement.otherwise, bound)
            bound.update(inside)
        elif isinstance(statement, syntax.ForkStatement):
            for branch in statement.branches:
                yield from self.body(branch, bound)
        elif isinstance(statement, (syntax.For, syntax.While)):
            # Bindings made in a loop do not hold after it.
            inside = set(bound)
            yield from self.formula(statement.condition, inside)
            yield from self.body(statement.body, inside)
        elif isinstance(statement, (syntax.TestGoal, syntax.ConditionStatement)):
            yield from self.formula(statement.formula, bound)
        elif isinstance(
            statement, (syntax.AchievementGoal, syntax.InternalActionCall, syntax.ExternalAction, syntax.BeliefUpdate)
        ):
            if not isinstance(statement, syntax.InternalActionCall):
                yield from self._expressions(statement, bound)
            bound.update(variables_of(statement))

    def _expressions(self, statement: syntax.Statement, bound: set[Variable]) -> Iterator[Problem]:
        pending: list[object] = list(children(statement))
        while pending:
            part = pending.pop()
            if isinstance(part, Arithmetic):
                for variable in sorted(_used(part) - bound):
                    yield (
                        location_of(str(variable), self._place),
                        f"{variable} has no value yet in the expression {part}",
                    )
            elif not isinstance(part, (Variable, Number)):
                pending.extend(children(part))


def _used(term: object) -> set[Variable]:
    """The variables whose values a term needs, without those in the condition of a function such as ``.count``."""
    variables: set[Variable] = set()
    pending = [term]
    while pending:
        part = pending.pop()
        if isinstance(part, Variable):
            variables.add(part)
        elif isinstance(part, Call) and part.name in FORMULA_ARGUMENTS:
            continue
        elif not isinstance(part, Number):
            pending.extend(children(part))
    return variables


def _text(formula: syntax.Formula) -> str:
    return str(formula)[1:-1]
