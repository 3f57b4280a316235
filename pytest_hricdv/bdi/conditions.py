"""Conditions made ready to be asked often: a function for each, made once, that finds its first solution.

Such a function gives what :func:`~.inference.first` gives, and looks up what can be looked up: beliefs known by
predicate and arguments, the one belief there is of a predicate, comparisons of numbers. What takes a choice, a rule or
anything else is left to the machine, from the part of the condition on that takes it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import TYPE_CHECKING

from .comparison import compare
from .formulas import And, Comparison, Formula, Not
from .inference import first
from .substitution import Bindings
from .terms import Number, Structure, Term, Variable, is_ground
from .unify import Trail, unify
from .values import value_of

if TYPE_CHECKING:
    from .agent import Agent

Condition = Callable[["Agent", Bindings], Bindings | None]
"""Gives the first solution as bindings that extend the given ones; None if there is none."""
Part = Callable[["Agent", Bindings], bool | None]
"""Whether a part of a condition holds, in one way at most; adds to the bindings. None, with nothing added: it takes the
machine to know."""

_RELATIONS: dict[str, Callable[[Number, Number], bool]] = {
    "<": operator.lt,
    ">": operator.gt,
    # Not the opposite order: a number that is none is neither below nor above any other.
    "<=": lambda x, y: not x > y,
    ">=": lambda x, y: not x < y,
    "==": operator.eq,
    "\\==": operator.ne,
}


def condition_of(formula: Formula, own: bool = False) -> Condition:
    """How to find the first solution of a formula.

    Args:
        formula: what is asked.
        own: whether the bindings given may be changed, whatever the answer.
    """
    parts = formula.parts if isinstance(formula, And) else (formula,)
    if all(isinstance(part, Structure) and _is_proposition(part) for part in parts):
        return _propositions(formula, parts)  # type: ignore[arg-type]
    decided = [_part(part) for part in parts]
    if decided[0] is None:
        return lambda agent, bindings: first(agent, formula, bindings)
    copied = not own and any(_may_bind(part) for part in parts)
    if len(parts) == 1:
        return _single(formula, decided[0], copied)
    return _conjunction(formula, parts, decided, copied)


def _is_proposition(literal: Structure) -> bool:
    """Whether a literal is one of those that beliefs are looked up by, whatever their sources."""
    return literal.ground and not literal.annots and literal.functor not in ("true", "false")


def _may_bind(part: Formula) -> bool:
    if isinstance(part, Comparison):
        return part.operator[0] == "="
    return not isinstance(part, Not) and not (isinstance(part, Structure) and part.ground)


def _propositions(formula: Formula, literals: tuple[Structure, ...]) -> Condition:
    wanted = [(literal.key, literal.args, index) for index, literal in enumerate(literals)]

    def condition(agent: Agent, bindings: Bindings) -> Bindings | None:
        beliefs = agent.beliefs
        buckets = beliefs.buckets
        for key, args, index in wanted:
            bucket = buckets.get(key)
            if not bucket:
                return None
            if args not in bucket:
                if key in beliefs.open:
                    return first(agent, And(literals[index:]) if index else formula, bindings)
                return None
        return bindings

    return condition


def _single(formula: Formula, decide: Part, copied: bool) -> Condition:
    def condition(agent: Agent, bindings: Bindings) -> Bindings | None:
        extended = dict(bindings) if copied else bindings
        holds = decide(agent, extended)
        if holds:
            return extended
        return None if holds is False else first(agent, formula, bindings)

    return condition


def _conjunction(formula: Formula, parts: tuple[Formula, ...], decided: list[Part | None], copied: bool) -> Condition:
    # The rest of the formula from each part on, for the machine.
    steps = [(decide or _unknown, And(parts[index:]) if index else formula) for index, decide in enumerate(decided)]

    def condition(agent: Agent, bindings: Bindings) -> Bindings | None:
        if copied:
            bindings = dict(bindings)
        for decide, rest in steps:
            holds = decide(agent, bindings)
            if not holds:
                return None if holds is False else first(agent, rest, bindings)
        return bindings

    return condition


def _unknown(agent: Agent, bindings: Bindings) -> bool | None:
    return None


def _part(part: Formula) -> Part | None:
    """How to decide a part of a condition; None if it always takes the machine."""
    if isinstance(part, Structure):
        if part.functor in ("true", "false"):
            return None
        if part.ground:
            return _ground(part)
        if part.evaluable or part.annots_tail is not None or not all(map(is_ground, part.annots)):
            return None
        return _only_belief(part)
    if isinstance(part, Not):
        return _negation(part)
    if isinstance(part, Comparison):
        return comparison_of(part)
    return None


def _ground(literal: Structure) -> Part:
    key, args, annots = literal.key, literal.args, literal.annots

    def decide(agent: Agent, bindings: Bindings) -> bool | None:
        bucket = agent.beliefs.buckets.get(key)
        if not bucket:
            return False
        held = bucket.get(args)
        if held is not None:
            for annot in annots:
                if annot not in held.annots:  # type: ignore[union-attr]
                    break
            else:
                return True
        return None if key in agent.beliefs.open else False

    return decide


def _only_belief(literal: Structure) -> Part:
    """A literal with variables: decided if there is no belief or one, which is no rule."""
    key, annots = literal.key, literal.annots
    match = _variable_match(literal.args[0]) if len(literal.args) == 1 else None
    if match is None:
        match = _match(literal.args)

    def decide(agent: Agent, bindings: Bindings) -> bool | None:
        bucket = agent.beliefs.buckets.get(key)
        if not bucket:
            return False
        if len(bucket) != 1:
            return None
        (entry,) = bucket.values()
        if not isinstance(entry, Structure):
            return None
        if not match(entry, bindings):
            return False
        return not annots or all(annot in entry.annots for annot in annots)

    return decide


Match = Callable[[Structure, Bindings], bool]
"""Whether the arguments of a literal unify with those of a belief of its predicate; adds to the bindings."""


def _variable_match(variable: Term) -> Match | None:
    """For the commonest case, a single variable."""
    if type(variable) is not Variable:
        return None

    def match(belief: Structure, bindings: Bindings) -> bool:
        (value,) = belief.args
        if variable in bindings or not belief.ground:
            return unify(variable, value, bindings, [])
        bindings[variable] = value
        return True

    return match


def _match(args: tuple[Term, ...]) -> Match:
    def match(belief: Structure, bindings: Bindings) -> bool:
        trail: Trail = []
        for left, right in zip(args, belief.args):  # noqa: B905 - of the same predicate, so of the same length
            if type(left) is Variable and left not in bindings and is_ground(right):
                bindings[left] = right
            elif not unify(left, right, bindings, trail):
                return False
        return True

    return match


def _negation(formula: Not) -> Part:
    condition = condition_of(formula.part)

    def decide(agent: Agent, bindings: Bindings) -> bool | None:
        return condition(agent, bindings) is None

    return decide


def comparison_of(formula: Comparison) -> Part:
    """How to decide a comparison; ``=`` and ``=..`` bind variables, and may do so before they fail."""
    relation = _RELATIONS.get(formula.operator)
    left, right = value_of(formula.left), value_of(formula.right)
    if relation is None or left is None or right is None:
        return lambda agent, bindings: compare(agent, formula, bindings, [])

    def decide(agent: Agent, bindings: Bindings) -> bool | None:
        x, y = left(bindings), right(bindings)
        if type(x) is Number and type(y) is Number:
            return relation(x, y)
        return compare(agent, formula, bindings, [])

    return decide
