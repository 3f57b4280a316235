"""Plans made ready to be selected often: whether a plan is for an event, and applicable."""

from __future__ import annotations

from collections.abc import Callable

from .conditions import Condition, condition_of
from .substitution import Bindings
from .syntax import Plan, Trigger
from .terms import Structure, Variable, is_ground
from .unify import unify

Match = Callable[[Structure], Bindings | None]
"""Gives what a trigger's variables are bound to by the literal of an event; None if the trigger is not for it."""
Option = tuple[Plan, Match | None, Condition | None]
"""A plan; how its trigger is matched, unless it is for every event with its key; and its context, if it has one."""


def option_of(plan: Plan) -> Option:
    """A plan, ready to be selected."""
    match = None if plan.plain else _match(plan.trigger)
    return plan, match, None if plan.context is None else condition_of(plan.context)


def _match(trigger: Trigger) -> Match:
    wanted = trigger.literal

    def match(literal: Structure) -> Bindings | None:
        bindings: Bindings = {}
        return bindings if unify(wanted, literal, bindings, []) else None

    if isinstance(wanted, Structure) and _only_names_arguments(wanted):
        return _naming(wanted, match)
    return match


def _only_names_arguments(wanted: Structure) -> bool:
    """Whether the arguments are variables, each once, and the annotations known."""
    if wanted.annots_tail is not None or not all(map(is_ground, wanted.annots)):
        return False
    return all(type(arg) is Variable for arg in wanted.args) and len(set(wanted.args)) == len(wanted.args)


def _naming(wanted: Structure, otherwise: Match) -> Match:
    """For the commonest triggers: the arguments of a ground literal are given names, and its sources looked up."""
    names: tuple[Variable, ...] = wanted.args  # type: ignore[assignment]
    annots = wanted.annots

    def match(literal: Structure) -> Bindings | None:
        if not literal.ground:
            return otherwise(literal)
        for annot in annots:
            if annot not in literal.annots:
                return otherwise(literal)
        return dict(zip(names, literal.args, strict=True))

    return match
