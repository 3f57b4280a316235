"""Agents that only look again and again: ``+!w : not x <- !w``.

As long as nothing comes to such an agent from outside, it selects the same plan in every cycle. It is left alone until
then; the cycles that it would have done meanwhile are made up for when somebody wants to know.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from pytest_hricdv.bdi.language.formulas import And, Comparison, Formula, Not, Or
from pytest_hricdv.bdi.language.syntax import Plan
from pytest_hricdv.bdi.language.terms import Structure, is_evaluable

if TYPE_CHECKING:
    from .participant import Participant


class Spin(NamedTuple):
    """What an agent does all the time.

    Args:
        label: of the plan that it selects in every cycle.
        since: the first round whose cycle is still to be made up for.
    """

    label: str
    since: int


def is_steady(relevant: tuple[Plan, ...]) -> bool:
    """Whether it depends on beliefs alone which of the plans for an event is selected, and to select one does nothing.

    It could depend on the source of the event, too, and looking at a context could draw a random number or warn.
    """
    for plan in relevant:
        goal = plan.trigger.literal
        if not isinstance(goal, Structure) or goal.annots or goal.annots_tail is not None:
            return False
        if plan.context is not None and not _only_looks(plan.context):
            return False
    return True


def _only_looks(formula: Formula) -> bool:
    if isinstance(formula, (And, Or)):
        return all(map(_only_looks, formula.parts))
    if isinstance(formula, Not):
        return _only_looks(formula.part)
    if isinstance(formula, Comparison):
        return not is_evaluable(formula.left) and not is_evaluable(formula.right)
    return isinstance(formula, Structure) and not formula.evaluable


def leave_alone(agent: Participant, label: str, since: int) -> None:
    """An agent will do nothing from a round on but select a plan that pursues itself."""
    agent.spin = Spin(label, since)
    agent.run.spinning[agent.name] = agent
    if agent.run.leaves_alone:
        agent.awake = False


def make_up(agent: Participant) -> None:
    """Make up for the cycles that an agent would have done before this round."""
    if agent.spin is not None:
        label, since = agent.spin
        now = agent.run.rounds
        agent.executed += [label] * (now - since)
        agent.spin = Spin(label, now)


def count_from(agent: Participant, now: int) -> None:
    """Another count of rounds begins, after an agent's cycles have been made up for."""
    if agent.spin is not None:
        agent.spin = Spin(agent.spin.label, now)


def take_up(agent: Participant) -> None:
    """Let an agent that was left alone do its cycles by itself again, from this round on."""
    make_up(agent)
    agent.spin = None
    agent.run.spinning.pop(agent.name, None)


def is_busy(agent: Participant) -> bool:
    """Whether an agent will ever do anything but look again and again, even if nothing more comes to it."""
    if agent.waits or agent.questions:
        return True
    return agent.awake if agent.spin is None else agent.has_news()
