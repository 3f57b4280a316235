"""One step of a query: the beliefs, rules, internal actions and values of variables that can make its next goal true.

`inference` tries the `alternatives` of each goal in turn. A `Reasoner` is the agent, as far as queries need it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import WORK
from pytest_hricdv.bdi.language.namespaces import DEFAULT, LOCAL, split
from pytest_hricdv.bdi.language.syntax import Formula, Or, Rule
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Call,
    FormulaTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
)
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.substitution import Bindings, rename_formula, substitute, substitute_only
from pytest_hricdv.bdi.logic.unify import Trail, match_annotations, stands_for, undo, unify


class Reasoner(Protocol):
    """The interface of an agent that a query needs."""

    name: str
    beliefs: BeliefBase
    rule: Rule | None
    """The rule that was used last, for error messages."""

    def function(self, call: Call, bindings: Bindings) -> Term:
        """The value of a function in an expression."""

    def call(self, call: Call, bindings: Bindings, trail: Trail) -> bool | Iterator[object]:
        """The outcome of an internal action as a condition; an iterator binds variables anew for each solution."""

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""

    def enter_query(self, formula: Formula) -> None:
        """Count a query inside another; raises a BdiError if there are too many."""

    def leave_query(self) -> None:
        """The end of a query."""

    def activity(self) -> str:
        """A description of the agent's activity, for error messages."""


Goals = tuple[Formula, Any] | None
"""The goals left to show, the next one first."""


def alternatives(
    agent: Reasoner, goal: Formula, rest: Goals, env: Bindings, trail: Trail, renamed: set[Variable]
) -> Iterator[Goals]:
    """The goals left to show for each way to show this one, with its bindings made."""
    if isinstance(goal, Or):
        for part in goal.parts:
            yield (part, rest)
        return
    if not isinstance(goal, (Structure, Call)):
        goal = _meaning(agent, goal, env)  # type: ignore[assignment]
    if isinstance(goal, FormulaTerm):
        yield (goal.formula, rest)
        return
    if isinstance(goal, (Variable, AnnotatedVariable)):
        yield from _by_any_belief(agent, goal, rest, env, trail)
        return
    if isinstance(goal, QualifiedLiteral):
        yield from _in_any_space(agent, goal, rest, env, trail)
        return
    if isinstance(goal, Call):
        outcome = agent.call(goal, env, trail)
        if isinstance(outcome, bool):
            if outcome:
                yield rest
        else:
            for _ in outcome:
                yield rest
        return
    literal = _literal(agent, goal, env)  # type: ignore[arg-type]
    if literal.functor in ("true", "false") and not literal.args:
        if literal.functor == "true":
            yield rest
        return
    for entry in agent.beliefs.candidates(literal.key):
        WORK.left -= 1  # those that do not match are counted nowhere else
        if isinstance(entry, Rule):
            yield from _by_rule(agent, literal, entry, rest, env, trail, renamed)
        else:
            yield from _by_belief(literal, entry, rest, env, trail)


def _meaning(agent: Reasoner, goal: Formula, env: Bindings) -> Formula | FormulaTerm:
    """The value of a variable in the place of a condition: the term that was passed, or itself if it has none."""
    value = substitute(goal, env, agent.function)  # type: ignore[arg-type]
    if not isinstance(value, (Structure, Call, FormulaTerm, Variable, AnnotatedVariable, QualifiedLiteral)):
        raise EvaluationError(f"{goal} is not a literal but {value}")
    return value


def _literal(agent: Reasoner, goal: Structure, env: Bindings) -> Structure:
    if not goal.evaluable:
        return goal
    value = substitute(goal, env, agent.function)
    assert isinstance(value, Structure)
    return value


def _by_any_belief(
    agent: Reasoner, variable: Variable | AnnotatedVariable, rest: Goals, env: Bindings, trail: Trail
) -> Iterator[Goals]:
    """As in Jason, a variable without a value asks for every belief, of one predicate after the other."""
    mark = len(trail)
    for key in list(agent.beliefs.buckets):
        if split(key[1])[0] != DEFAULT:  # those of other namespaces are asked for with their name
            continue
        for entry in agent.beliefs.candidates(key):
            if isinstance(entry, Rule):
                continue
            if isinstance(variable, Variable):
                if unify(variable, entry, env, trail):
                    yield rest
            elif variable.negated <= entry.negated:
                env[variable.variable] = stands_for(variable, entry)
                trail.append(variable.variable)
                yield from _with_annotations(variable, entry.annots, rest, env, trail, mark)
            undo(env, trail, mark)


def _in_any_space(agent: Reasoner, goal: QualifiedLiteral, rest: Goals, env: Bindings, trail: Trail) -> Iterator[Goals]:
    """A literal whose namespace is not known asks for those of all, that without a name first."""
    mark = len(trail)
    for key in sorted(agent.beliefs.buckets, key=lambda key: "::" in key[1]):
        negated, functor, arity = key
        space, name = split(functor)
        literal = goal.literal
        if space.startswith(LOCAL) and goal.space != Structure(space):
            continue  # seen by its name only
        if not isinstance(literal, Structure):
            for entry in agent.beliefs.candidates(key):
                if isinstance(entry, Structure) and unify(goal, entry, env, trail):
                    yield rest
                undo(env, trail, mark)
        elif (negated, name, arity) == literal.key and unify(goal.space, Structure(space), env, trail):
            yield (Structure(functor, literal.args, literal.annots, negated, literal.annots_tail), rest)
        undo(env, trail, mark)


def _by_belief(literal: Structure, belief: Structure, rest: Goals, env: Bindings, trail: Trail) -> Iterator[Goals]:
    mark = len(trail)
    for left, right in zip(literal.args, belief.args, strict=True):
        if not unify(left, right, env, trail):
            undo(env, trail, mark)
            return
    if not literal.annots and literal.annots_tail is None:
        yield rest
    else:
        yield from _with_annotations(literal, belief.annots, rest, env, trail, mark)


def _with_annotations(
    literal: Structure | AnnotatedVariable,
    annots: tuple[Term, ...],
    goals: Goals,
    env: Bindings,
    trail: Trail,
    mark: int,
) -> Iterator[Goals]:
    """Continue once for each way the annotations match; each way rebinds what was bound since ``mark``."""
    # Collect all ways first: a suspended generator would have to find the bindings as it left them.
    ways = [
        [(variable, env[variable]) for variable in trail[mark:]] for _ in match_annotations(literal, annots, env, trail)
    ]
    # The arguments of this belief must not stay bound for the next one, also where no way is left.
    undo(env, trail, mark)
    for way in ways:
        for variable, value in way:
            env[variable] = value
            trail.append(variable)
        yield goals


def _by_rule(
    agent: Reasoner, literal: Structure, rule: Rule, rest: Goals, env: Bindings, trail: Trail, renamed: set[Variable]
) -> Iterator[Goals]:
    agent.rule = rule
    # New variables in each use: a rule that calls itself has those of its caller still bound.
    renaming: Bindings = {variable: agent.fresh() for variable in rule.variables}
    renamed.update(renaming.values())  # type: ignore[arg-type]
    head = substitute_only(rule.head, renaming) if renaming else rule.head
    mark = len(trail)
    if isinstance(head, Structure) and all(
        unify(left, right, env, trail) for left, right in zip(literal.args, head.args, strict=True)
    ):
        body = rename_formula(rule.body, renaming) if renaming else rule.body
        if not literal.annots and literal.annots_tail is None:
            yield (body, rest)
        else:
            yield from _with_annotations(literal, head.annots, (body, rest), env, trail, mark)
    else:
        undo(env, trail, mark)
