"""Internal actions on the agent's own plans."""

from __future__ import annotations

from dataclasses import replace

from pytest_hricdv.bdi.actions.registry import Invocation, check_calls_of, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.language.errors import BdiError, EvaluationError
from pytest_hricdv.bdi.language.parser import parse_plan, parse_trigger
from pytest_hricdv.bdi.language.syntax import Plan, Trigger
from pytest_hricdv.bdi.language.terms import ListTerm, PlanTerm, String, Structure, Term
from pytest_hricdv.bdi.logic.unify import unify


def _plan(invocation: Invocation, term: Term) -> Plan:
    if isinstance(term, String):
        return invocation.read(term.value, parse_plan)
    if isinstance(term, PlanTerm) and isinstance(term.plan, Plan):
        return term.plan
    raise EvaluationError(f"{term} is not a plan")


@internal_action("add_plan", 1, 3, inspects=True)
def _add_plan(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    value = invocation.value(0)
    first = len(invocation) == 3 and str(invocation.value(2)) == "begin"
    for term in value.items if isinstance(value, ListTerm) else (value,):
        plan = _plan(invocation, term)
        try:
            check_calls_of(plan)
        except BdiError as error:
            raise BdiError(f"{invocation.call.location}: in the plan that is added here: {error}") from None
        if not plan.has_label:
            plan = replace(plan, label=f"_added{len(agent.library.plans) + 1}")
        agent.library = agent.library.with_plan(plan, at_the_beginning=first)
        agent.run.progress += 1
    return True


@internal_action("remove_plan", 1, 2, inspects=True)
def _remove_plan(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    value = invocation.value(0)
    for label in value.items if isinstance(value, ListTerm) else (value,):
        agent.library = agent.library.without(str(label))
        agent.run.progress += 1
    return True


@internal_action("relevant_plans", 2, 3, inspects=True)
def _relevant_plans(invocation: Invocation) -> Outcome:
    value = invocation.value(0)
    if isinstance(value, PlanTerm):
        trigger = _plan(invocation, value).trigger
    else:
        trigger = invocation.read(invocation.text(0), parse_trigger)
    plans = [plan for plan in invocation.agent.library.plans if not plan.builtin and _is_for(plan, trigger)]
    labels = ListTerm(tuple(Structure(plan.label) for plan in plans))
    return invocation.unify(1, ListTerm(tuple(PlanTerm(plan) for plan in plans))) and (
        len(invocation) == 2 or invocation.unify(2, labels)
    )


def _is_for(plan: Plan, trigger: Trigger) -> bool:
    return plan.trigger.sign == trigger.sign and unify(plan.trigger.literal, trigger.literal, {}, [])


@internal_action("plan_label", 2, inspects=True)
def _plan_label(invocation: Invocation) -> Outcome:
    label = str(invocation.value(1))
    for plan in invocation.agent.library.plans:
        if plan.label == label:
            return invocation.unify(0, PlanTerm(plan))
    return False
