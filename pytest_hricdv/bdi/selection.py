"""Plans made ready to be selected often: whether a plan is for an event, and applicable."""

from __future__ import annotations

from collections.abc import Callable
from itertools import takewhile

from pytest_hricdv.bdi.language.formulas import And, Formula
from pytest_hricdv.bdi.language.syntax import Plan, Trigger
from pytest_hricdv.bdi.language.terms import Key, Number, String, Structure, Variable, is_ground
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import unify

from .conditions import Condition, condition_of

Match = Callable[[Structure], Bindings | None]
"""Gives what a trigger's variables are bound to by the literal of an event; None if the trigger is not for it."""
Option = tuple[Plan, frozenset[Key], Match | None, Condition | None]
"""A plan; the predicates of which something must be believed, or its context cannot hold; how its trigger is matched,
unless it is for every event with its key; and its context, if it has one."""


def option_of(plan: Plan) -> Option:
    """A plan, ready to be selected."""
    match = None if plan.matches_every_event else _match(plan.trigger)
    if plan.context is None:
        return plan, frozenset(), match, None
    return plan, _needed(plan.context), match, condition_of(plan.context)


def _needed(context: Formula) -> frozenset[Key]:
    """Of the literals that a context begins with: nothing else is asked before them, which might be noticed."""
    parts = context.parts if isinstance(context, And) else (context,)
    literals = takewhile(_is_asked_plainly, parts)
    return frozenset(literal.key for literal in literals)  # type: ignore[union-attr]


def _is_asked_plainly(part: Formula) -> bool:
    return isinstance(part, Structure) and part.functor not in ("true", "false") and not part.evaluable


def _match(trigger: Trigger) -> Match:
    wanted = trigger.literal

    def match(literal: Structure) -> Bindings | None:
        bindings: Bindings = {}
        return bindings if unify(wanted, literal, bindings, []) else None

    if isinstance(wanted, Structure) and _is_simple(wanted):
        return _simple(wanted, match)
    return match


def _is_simple(wanted: Structure) -> bool:
    """Whether the arguments are variables, each once, numbers and texts, and the annotations known."""
    names = [arg for arg in wanted.args if type(arg) is Variable]
    values = [arg for arg in wanted.args if isinstance(arg, (Number, String))]
    if len({*names}) + len(values) < len(wanted.args):
        return False
    return wanted.annots_tail is None and all(map(is_ground, wanted.annots))


def _simple(wanted: Structure, otherwise: Match) -> Match:
    """For most triggers: parts of a ground literal are given names, others compared, and its sources looked up."""
    names = {arg: index for index, arg in enumerate(wanted.args) if isinstance(arg, Variable)}
    values = [(index, arg) for index, arg in enumerate(wanted.args) if not isinstance(arg, Variable)]
    all_names: tuple[Variable, ...] | None = None if values else wanted.args  # type: ignore[assignment]
    annots = wanted.annots

    def match(literal: Structure) -> Bindings | None:
        if not literal.ground:
            return otherwise(literal)
        args = literal.args
        for annot in annots:
            if annot not in literal.annots:
                return otherwise(literal)
        if not args:
            return {}
        if all_names is not None:
            return dict(zip(all_names, args, strict=True))
        for index, value in values:
            if args[index] != value:
                return None
        return {name: args[index] for name, index in names.items()}

    return match
