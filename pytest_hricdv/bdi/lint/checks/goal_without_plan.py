"""A goal that no plan is for."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.terms import Structure, Term, Variable, is_evaluable
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_only
from pytest_hricdv.bdi.logic.unify import unify

from ..model import AgentModel, Mention, System, name_of
from ..names import nearest


class GoalWithoutPlan:
    """Goals in plans, at the start, and in messages, that no plan of their agent is for."""

    name = "goal-without-plan"
    why = "The goal fails whenever it comes up, and with it whatever it was pursued for."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each goal at each place."""
        for agent in system.agents:
            for mention, fits_by_name in without_plan(system, agent):
                key = mention.literal.key
                if fits_by_name:
                    yield mention.location, f"no plan of {agent.name} for +!{name_of(key)} fits {mention.literal}"
                elif suggestion(agent, mention) is None:
                    yield mention.location, f"{agent.name} has no plan for +!{name_of(key)}"
        for mention in system.goals_for_somebody():
            if system.closed and not any(has_plan(system, agent, mention) for agent in system.agents):
                yield mention.location, f"no agent has a plan for +!{name_of(mention.literal.key)}"


def without_plan(system: System, agent: AgentModel) -> Iterator[tuple[Mention, bool]]:
    """The goals that no plan is for, and whether there are plans for goals of that name and arity."""
    for mention in (*agent.goals, *system.told_goals(agent)):
        if not has_plan(system, agent, mention):
            yield mention, any(plan.trigger.key == ("+!", mention.literal.key) for plan in agent.plans)


def has_plan(system: System, agent: AgentModel, mention: Mention) -> bool:
    """Whether some plan of the agent may be for a goal."""
    goal = _opened(mention.literal)
    triggers = [plan.trigger.literal for plan in agent.plans if plan.trigger.sign == "+!"]
    return system.learns_plans(agent) or any(
        not isinstance(literal, Structure) or unify(_own_variables(literal), goal, {}, []) for literal in triggers
    )


def suggestion(agent: AgentModel, mention: Mention) -> str | None:
    """The name of a goal the agent does have a plan for that is one letter away."""
    triggers = [plan.trigger for plan in agent.plans if plan.trigger.sign == "+!"]
    known = {trigger.literal.functor for trigger in triggers if isinstance(trigger.literal, Structure)}
    return nearest(mention.literal.functor, known)


def _opened(goal: Structure) -> Structure:
    """The goal with anything for what is computed in it, and from anybody."""
    args = tuple(Variable(f"_Any{n}") if is_evaluable(arg) else arg for n, arg in enumerate(goal.args))
    anybody: Term = Structure("source", (Variable("_Anybody"),))
    return Structure(goal.functor, args, (*goal.annots, anybody), goal.negated)


def _own_variables(literal: Structure) -> Term:
    renaming: Bindings = {variable: Variable(f"_Plan{variable}") for variable in free_variables(literal)}
    return substitute_only(literal, renaming)
