"""The check for goals without a plan."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.terms import Structure, Term, Variable, is_evaluable
from pytest_hricdv.bdi.lint.model import AgentModel, Mention, System, predicate_text
from pytest_hricdv.bdi.lint.spelling import one_letter_away
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_only
from pytest_hricdv.bdi.logic.unify import unify


class GoalWithoutPlan:
    """Initial goals, goals in plans and goals in messages for which their agent has no plan."""

    name = "goal-without-plan"
    why = "The goal always fails, and with it the plan that pursues it."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each occurrence of such a goal."""
        for agent in system.agents:
            for mention, fits_by_name in goals_without_plan(system, agent):
                key = mention.literal.key
                if fits_by_name:
                    yield (
                        mention.location,
                        f"no plan of {agent.name} for +!{predicate_text(key)} fits {mention.literal}",
                    )
                elif suggestion(agent, mention) is None:
                    yield mention.location, f"{agent.name} has no plan for +!{predicate_text(key)}"
        for mention in system.goals_for_unknown_receivers():
            if system.closed and not any(has_plan(system, agent, mention) for agent in system.agents):
                yield mention.location, f"no agent has a plan for +!{predicate_text(mention.literal.key)}"


def goals_without_plan(system: System, agent: AgentModel) -> Iterator[tuple[Mention, bool]]:
    """The goals without a plan, and whether there are plans for goals of that name and arity."""
    for mention in (*agent.goals, *system.requested_goals(agent)):
        if not has_plan(system, agent, mention):
            yield mention, any(plan.trigger.key == ("+!", mention.literal.key) for plan in agent.plans)


def has_plan(system: System, agent: AgentModel, mention: Mention) -> bool:
    """Whether some plan of the agent may be relevant for a goal."""
    goal = _generalized(mention.literal)
    triggers = [plan.trigger.literal for plan in agent.plans if plan.trigger.sign == "+!"]
    return system.may_receive_plans(agent) or any(
        not isinstance(literal, Structure) or unify(_renamed(literal), goal, {}, []) for literal in triggers
    )


def suggestion(agent: AgentModel, mention: Mention) -> str | None:
    """The name of a goal with a plan that differs by one letter."""
    triggers = [plan.trigger for plan in agent.plans if plan.trigger.sign == "+!"]
    known = {trigger.literal.functor for trigger in triggers if isinstance(trigger.literal, Structure)}
    return one_letter_away(mention.literal.functor, known)


def _generalized(goal: Structure) -> Structure:
    """The goal with variables in place of computed arguments, from any source."""
    args = tuple(Variable(f"_Any{n}") if is_evaluable(arg) else arg for n, arg in enumerate(goal.args))
    any_source: Term = Structure("source", (Variable("_AnySource"),))
    return Structure(goal.functor, args, (*goal.annots, any_source), goal.negated)


def _renamed(literal: Structure) -> Term:
    renaming: Bindings = {variable: Variable(f"_Plan{variable}") for variable in free_variables(literal)}
    return substitute_only(literal, renaming)
