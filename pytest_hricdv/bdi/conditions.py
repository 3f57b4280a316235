"""Conditions made ready to be asked often: a function for each, made once, that decides it.

Such a function finds what :func:`~.inference.first` finds, by looking up what can be looked up: beliefs known by
predicate and arguments, the one belief there is of a predicate, comparisons of numbers. What takes a choice, a rule or
anything else is left to ``first``, from the part of the condition on that takes it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.formulas import And, Comparison, Formula, Not
from pytest_hricdv.bdi.language.terms import Key, Number, Structure, Term, Variable, is_ground
from pytest_hricdv.bdi.logic.comparison import compare
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import Trail, unify

from .intentions import Frame
from .values import Value, value_of

if TYPE_CHECKING:
    from .agent import Agent

Condition = Callable[["Agent", Bindings], bool | None]
"""Whether a condition holds; adds to the bindings what its first solution adds, or, if it does not hold, anything.
None, with nothing added: it has to be asked of :func:`first`."""

_RELATIONS: dict[str, Callable[[Number, Number], bool]] = {
    "<": operator.lt,
    ">": operator.gt,
    # Not the opposite order: a number that is none is neither below nor above any other.
    "<=": lambda x, y: not x > y,
    ">=": lambda x, y: not x < y,
    "==": operator.eq,
    "\\==": operator.ne,
}


def question_of(formula: Formula) -> Callable[[Agent, Frame], bool]:
    """How to ask for a formula in a plan: if it holds, the plan's variables are bound as its first solution says."""
    condition, binds = condition_of(formula), _may_bind(formula)

    def question(agent: Agent, frame: Frame) -> bool:
        bindings = dict(frame.unifier) if binds else frame.unifier
        decided = condition(agent, bindings)
        if decided is None:
            decided = ask(agent, formula, bindings)
        if decided:
            frame.unifier = bindings
        return decided

    return question


def solutions_of(formula: Formula) -> Callable[[Agent, Bindings], list[Bindings]]:
    """How to find all solutions of a formula."""
    if isinstance(formula, Structure) and not formula.annots and formula.annots_tail is None:
        names = formula.args
        if names and _are_names(names) and formula.functor not in _CONSTANTS:
            return _every_belief(formula, names)  # type: ignore[arg-type]
    return lambda agent, bindings: list(solve(agent, formula, bindings))


def _every_belief(literal: Structure, names: tuple[Variable, ...]) -> Callable[[Agent, Bindings], list[Bindings]]:
    """Every belief of a predicate is a solution."""
    key = literal.key

    def solutions(agent: Agent, bindings: Bindings) -> list[Bindings]:
        if key in agent.beliefs.open or not bindings.keys().isdisjoint(names):
            return list(solve(agent, literal, bindings))
        return [
            bindings | dict(zip(names, belief.args, strict=True))  # type: ignore[union-attr]
            for belief in reversed(agent.beliefs.bucket(key).values())
        ]

    return solutions


def _are_names(args: tuple[Term, ...]) -> bool:
    """Whether these are variables, each once."""
    return all(isinstance(arg, Variable) for arg in args) and len({*args}) == len(args)


def ask(agent: Agent, formula: Formula, bindings: Bindings) -> bool:
    """Whether a formula holds; adds to the bindings what its first solution adds."""
    solution = first(agent, formula, bindings)
    if solution is None:
        return False
    if solution is not bindings:
        bindings.update(solution)
    return True


def _may_bind(formula: Formula) -> bool:
    """Whether deciding a formula may change the bindings, even if it does not hold then."""
    if isinstance(formula, And):
        only_compares = all(isinstance(part, (Comparison, Not)) and not _may_bind(part) for part in formula.parts)
        return not (only_compares or _are_propositions(formula.parts))
    if isinstance(formula, Comparison):
        return formula.operator[0] == "="
    return not isinstance(formula, Not) and not (isinstance(formula, Structure) and formula.ground)


def condition_of(formula: Formula) -> Condition:
    """How to decide a formula."""
    if isinstance(formula, And):
        return _conjunction(formula)
    if isinstance(formula, Structure):
        return _literal(formula)
    if isinstance(formula, Not):
        return _negation(formula)
    if isinstance(formula, Comparison):
        return comparison_of(formula)
    return _undecided


def _undecided(agent: Agent, bindings: Bindings) -> bool | None:
    return None


def _conjunction(formula: And) -> Condition:
    if _are_propositions(formula.parts):
        return _propositions(formula.parts)  # type: ignore[arg-type]
    # Each with what is to be shown from there on.
    parts = [(_part(part), And(formula.parts[index:])) for index, part in enumerate(formula.parts)]

    def condition(agent: Agent, bindings: Bindings) -> bool | None:
        for decide, rest in parts:
            decided = decide(agent, bindings)
            if not decided:
                return decided if decided is False else ask(agent, rest, bindings)
        return True

    return condition


def _part(formula: Formula) -> Condition:
    """For a part of a conjunction, which may have to be shown in another way for what comes after it."""
    return _undecided if isinstance(formula, And) else condition_of(formula)


def _are_propositions(parts: tuple[Formula, ...]) -> bool:
    """Whether these are literals that can be looked up, whatever their sources."""
    return all(
        isinstance(part, Structure) and part.ground and not part.annots and part.functor not in _CONSTANTS
        for part in parts
    )


_CONSTANTS = ("true", "false")


def _propositions(literals: tuple[Structure, ...]) -> Condition:
    wanted = [(literal.key, literal.args) for literal in literals]

    def condition(agent: Agent, bindings: Bindings) -> bool | None:
        buckets = agent.beliefs.buckets
        for key, args in wanted:
            bucket = buckets.get(key)
            if not bucket or args not in bucket:
                # Only now it matters whether there are other ways to answer.
                others = agent.beliefs.open
                return None if others and not others.isdisjoint(keys) else False
        return True

    keys = [key for key, _ in wanted]
    return condition


def _literal(literal: Structure) -> Condition:
    if literal.functor in _CONSTANTS or literal.evaluable or literal.annots_tail is not None:
        return _undecided
    if literal.ground:
        return _known(literal)
    if not all(map(is_ground, literal.annots)):
        return _undecided
    return _only_belief(literal)


def _known(literal: Structure) -> Condition:
    """For a ground literal."""
    key, args, annots = literal.key, literal.args, literal.annots

    def condition(agent: Agent, bindings: Bindings) -> bool | None:
        bucket = agent.beliefs.buckets.get(key)
        if not bucket:
            return False
        held = bucket.get(args)
        if isinstance(held, Structure) and (not annots or _has_annotations(held, annots)):
            return True
        return None if key in agent.beliefs.open else False

    return condition


def _only_belief(literal: Structure) -> Condition:
    """For a literal with variables: decided if there is no belief or one, which is no rule."""
    key, args, annots = literal.key, literal.args, literal.annots
    only_names = _are_names(args)

    def condition(agent: Agent, bindings: Bindings) -> bool | None:
        bucket = agent.beliefs.buckets.get(key)
        if not bucket:
            return False
        if len(bucket) != 1:
            return None
        (belief,) = bucket.values()
        if not isinstance(belief, Structure):
            return None
        if only_names and belief.ground and bindings.keys().isdisjoint(args):
            bindings.update(zip(args, belief.args, strict=True))  # type: ignore[arg-type]
        elif not _unify_all(args, belief.args, bindings):
            return False
        return not annots or _has_annotations(belief, annots)

    if len(args) == 1 and isinstance(args[0], Variable) and not annots:
        return _only_value(key, args[0], condition)
    return condition


def _only_value(key: Key, name: Variable, otherwise: Condition) -> Condition:
    """For the commonest such literal: its only argument is a variable."""

    def condition(agent: Agent, bindings: Bindings) -> bool | None:
        beliefs = agent.beliefs
        bucket = beliefs.buckets.get(key)
        if not bucket:
            return False
        if len(bucket) == 1 and not beliefs.open and name not in bindings:
            ((bindings[name],),) = bucket  # type: ignore[misc]
            return True
        return otherwise(agent, bindings)

    return condition


def _has_annotations(belief: Structure, annots: tuple[Term, ...]) -> bool:
    """Whether a belief has all of these ground annotations."""
    return belief.annots == annots or all(annot in belief.annots for annot in annots)


def _unify_all(args: tuple[Term, ...], others: tuple[Term, ...], bindings: Bindings) -> bool:
    """Whether each argument unifies with the other in its place."""
    trail: Trail = []
    return all(unify(left, right, bindings, trail) for left, right in zip(args, others, strict=True))


def _negation(formula: Not) -> Condition:
    part = formula.part
    condition, binds = condition_of(part), _may_bind(part)

    def negation(agent: Agent, bindings: Bindings) -> bool | None:
        own = dict(bindings) if binds else bindings
        decided = condition(agent, own)
        return first(agent, part, own) is None if decided is None else not decided

    return negation


def comparison_of(formula: Comparison) -> Callable[[Agent, Bindings], bool]:
    """How to decide a comparison; ``=`` and ``=..`` bind variables, and may do so before they fail."""
    left, right = value_of(formula.left), value_of(formula.right)
    if right is not None and formula.operator == "=" and isinstance(formula.left, Variable):
        return _assignment(formula, formula.left, right)
    relation = _RELATIONS.get(formula.operator)
    if relation is None or left is None or right is None:
        return lambda agent, bindings: compare(agent, formula, bindings, [])

    if isinstance(formula.left, Variable) and isinstance(formula.right, Number):
        return _with_number(formula, formula.left, formula.right)

    def comparison(agent: Agent, bindings: Bindings) -> bool:
        x, y = left(bindings), right(bindings)
        if type(x) is Number and type(y) is Number:
            return relation(x, y)
        return compare(agent, formula, bindings, [])

    return comparison


def _with_number(formula: Comparison, name: Variable, number: Number) -> Callable[[Agent, Bindings], bool]:
    """For the commonest of all comparisons, such as ``N > 1``."""
    relation = _RELATIONS[formula.operator]

    def comparison(agent: Agent, bindings: Bindings) -> bool:
        value = bindings.get(name)
        return relation(value, number) if type(value) is Number else compare(agent, formula, bindings, [])

    return comparison


def _assignment(formula: Comparison, name: Variable, value_of_right: Value) -> Callable[[Agent, Bindings], bool]:
    """For ``X = ...``, where X mostly has no value yet."""

    def assignment(agent: Agent, bindings: Bindings) -> bool:
        value = value_of_right(bindings)
        if value is None or name in bindings:
            return compare(agent, formula, bindings, [])
        bindings[name] = value
        return True

    return assignment
