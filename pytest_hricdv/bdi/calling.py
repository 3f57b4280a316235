"""Plans that call others, and what they get back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_only

from .intentions import Event, Frame, Intention

if TYPE_CHECKING:
    from .agent import Agent


def optimize_tail_recursion(intention: Intention, event: Event) -> None:
    """Drop a plan that ends by pursuing its own goal again, so that such loops need no memory."""
    top = intention.frames[-1]
    if (
        event.sign == "+!"
        and top.sign == "+!"
        and top.literal.key == event.literal.key
        and top.pc == len(top.body) - 1
        and not top.blocks
        and not top.plan.atomic
        and top.literal.ground
    ):
        intention.frames.pop()


def hand_back(agent: Agent, done: Frame, caller: Frame) -> None:
    """Bind the caller's variables that the goal's plan has bound."""
    asked = free_variables(done.literal)
    for variable in asked:
        value = agent.value(variable, done.unifier)
        if value == variable:
            continue
        # What the plan left unbound inside the value must not be taken for the caller's variable of that name.
        own: Bindings = {free: agent.fresh() for free in free_variables(value) if free not in asked}
        caller.unifier[variable] = substitute_only(value, own) if own else value
