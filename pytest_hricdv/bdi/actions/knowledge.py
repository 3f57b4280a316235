"""Internal actions on beliefs and plans (``.findall`` ...), which plans call; `internal_action` registers them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from pytest_hricdv.bdi.actions.registry import MANY, Invocation, check_calls, internal_action
from pytest_hricdv.bdi.agent.intentions import Outcome
from pytest_hricdv.bdi.language.errors import BdiError, EvaluationError
from pytest_hricdv.bdi.language.limits import limit_answers, spend
from pytest_hricdv.bdi.language.parser import parse_plan, parse_trigger
from pytest_hricdv.bdi.language.syntax import Plan, PlanTrigger, Rule
from pytest_hricdv.bdi.language.syntax_tree import parts_of, with_values
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    ListTerm,
    Number,
    PlanTerm,
    QualifiedLiteral,
    String,
    Structure,
    Term,
    Variable,
    source,
    term_order,
)
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings, rename_apart, substitute_only
from pytest_hricdv.bdi.logic.unify import undo, unify


def _values_of_solutions(invocation: Invocation) -> list[Term]:
    """The first argument's value for every solution of the second."""
    agent = invocation.agent
    agent.enter_query(invocation.formula(1))
    try:
        solutions = solve(agent, invocation.formula(1), invocation.bindings)
        return [agent.value(invocation.args[0], solution) for solution in limit_answers(solutions)]
    finally:
        agent.leave_query()


@internal_action("findall", 3)
def _findall(invocation: Invocation) -> Outcome:
    return invocation.unify(2, ListTerm(tuple(_values_of_solutions(invocation))))


@internal_action("setof", 3)
def _setof(invocation: Invocation) -> Outcome:
    return invocation.unify(2, ListTerm(tuple(sorted(set(_values_of_solutions(invocation)), key=term_order))))


@internal_action("count", 2)
def _count(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    agent.enter_query(invocation.formula(0))
    try:
        number = sum(1 for _ in solve(agent, invocation.formula(0), invocation.bindings))
    finally:
        agent.leave_query()
    return invocation.unify(1, Number(number))


@internal_action("eval", 2)
def _eval(invocation: Invocation) -> Outcome:
    holds = first(invocation.agent, invocation.formula(1), invocation.bindings) is not None
    return invocation.unify(0, Structure("true" if holds else "false"))


@internal_action("belief", 1)
def _belief(invocation: Invocation) -> Iterator[object]:
    literal = invocation.literal(0)
    for entry in invocation.agent.beliefs.candidates(literal.key):
        spend(1)
        if not isinstance(entry, Rule) and invocation.unify(0, entry):
            yield entry


@internal_action("abolish", 1)
def _abolish(invocation: Invocation) -> Outcome:
    """Remove every belief that matches, with all its sources; a variable matches all.

    As in Jason, the events that say so have no annotations.
    """
    agent = invocation.agent
    pattern = invocation.value(0)
    if isinstance(pattern, (Variable, AnnotatedVariable, QualifiedLiteral)):
        entries = [entry for key in list(agent.beliefs.buckets) for entry in agent.beliefs.candidates(key)]
    else:
        entries = list(agent.beliefs.candidates(invocation.literal(0).key))
    for entry in entries:
        if isinstance(entry, Rule):
            continue
        trail: list[object] = []
        matches = unify(pattern, entry, invocation.bindings, trail)  # type: ignore[arg-type]
        undo(invocation.bindings, trail, 0)  # type: ignore[arg-type]
        if matches and agent.beliefs.remove(entry):
            agent.run.progress += 1
            agent.post("-", entry.without_annotations(), None)
    return True


@internal_action("asserta", 1)
def _asserta(invocation: Invocation) -> Outcome:
    """Add a belief that queries find first."""
    invocation.agent.believe(invocation.literal(0).with_own_source())
    return True


@internal_action("assertz", 1)
def _assertz(invocation: Invocation) -> Outcome:
    """Add a belief that queries find last."""
    agent, belief = invocation.agent, invocation.literal(0).with_own_source()
    agent.believe(belief)
    agent.beliefs.find_last(belief)
    return True


@internal_action("namespace", 1)
def _namespace(invocation: Invocation) -> Iterator[object]:
    """The namespaces of the agent's beliefs."""
    functors = [functor for _, functor, _ in invocation.agent.beliefs.buckets]
    spaces = dict.fromkeys(["default", *(functor.partition("::")[0] for functor in functors if "::" in functor)])
    for space in spaces:
        if invocation.unify(0, Structure(space)):
            yield space


@internal_action("list_rules", 0)
def _list_rules(invocation: Invocation) -> Outcome:
    """Print the rules, one a line."""
    agent = invocation.agent
    for bucket in list(agent.beliefs.buckets.values()):
        for entry in bucket.values():
            if isinstance(entry, Rule):
                agent.run.print(agent.name, str(entry))
    return True


@internal_action("relevant_rules", 2)
def _relevant_rules(invocation: Invocation) -> Outcome:
    """``.relevant_rules(Head, Rules)``: the list of the rules whose head unifies."""
    literal = invocation.literal(0)
    rules = [
        PlanTerm(entry)
        for entry in invocation.agent.beliefs.candidates(literal.key)
        if isinstance(entry, Rule) and unify(literal, rename_apart(entry.head, "_rule_"), {}, [])
    ]
    return invocation.unify(1, ListTerm(tuple(rules)))


@internal_action("save_agent", 1, 2)
@internal_action("save_stats", 0, MANY)
def _save(invocation: Invocation) -> Outcome:
    """It would write a file; runs write none."""
    return invocation.ignore()


@internal_action("perceive", 0)
def _perceive(invocation: Invocation) -> Outcome:
    return True


def _plan(invocation: Invocation, term: Term) -> Plan:
    if isinstance(term, String):
        return invocation.read(term.value, parse_plan, "unknown")
    if isinstance(term, PlanTerm) and isinstance(term.plan, Plan):
        return term.plan
    raise EvaluationError(f"{term} is not a plan")


@internal_action("add_plan", 1, 3, inspects=True)
def _add_plan(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    value = invocation.value(0)
    origin = _source_of_plans(invocation)
    first = len(invocation.args) == 3 and str(invocation.value(2)) == "begin"
    for term in value.items if isinstance(value, ListTerm) else (value,):
        spend(1 + len(agent.library.plans))
        plan = _plan(invocation, term)
        try:
            check_calls(plan)
        except BdiError as error:
            raise BdiError(f"{invocation.call.location}: in the plan that is added here: {error}") from None
        if not plan.has_label:
            plan = replace(plan, label=f"{AUTOMATIC}{1 + sum(map(_is_numbered, agent.library.plans))}")
        agent.library = agent.library.with_plan(plan, origin, at_the_beginning=first)
        agent.run.progress += 1
    return True


@internal_action("remove_plan", 1, 2, inspects=True)
def _remove_plan(invocation: Invocation) -> Outcome:
    """The plans are labels, or plans that have one; a plan with several sources loses the one given, else ``self``."""
    agent = invocation.agent
    value = invocation.value(0)
    origin = _source_of_plans(invocation)
    for term in value.items if isinstance(value, ListTerm) else (value,):
        spend(1 + len(agent.library.plans))
        plan = _find_plan(invocation, term)
        agent.library = agent.library if plan is None else agent.library.without(plan.label, origin)
        agent.run.progress += 1
    return True


AUTOMATIC = "l__"
"""Prefix of the name in terms of a plan without a label; its number follows."""


def _is_numbered(plan: Plan) -> bool:
    return not plan.builtin and (not plan.has_label or plan.label.startswith(AUTOMATIC))


def _label_term(invocation: Invocation, plan: Plan) -> Structure:
    """The label of one of the agent's plans."""
    label = plan.label
    if not plan.has_label:
        numbered = [own.label for own in invocation.agent.library.plans if _is_numbered(own)]
        label = f"{AUTOMATIC}{1 + numbered.index(label)}"
    return Structure(label, annots=plan.annots)


def _plan_term(invocation: Invocation, plan: Plan) -> PlanTerm:
    """One of the agent's plans as a term that shares no variable with the plan that asks for it."""
    literal = plan.trigger.literal
    parts = parts_of((literal.annots if isinstance(literal, Structure) else (), plan))
    own: Bindings = {part: invocation.agent.fresh() for part in dict.fromkeys(parts) if isinstance(part, Variable)}
    named = PlanTerm(replace(plan, label=_label_term(invocation, plan).functor))
    return with_values(named, partial(substitute_only, bindings=own))


def _source_of_plans(invocation: Invocation) -> Structure:
    return source(invocation.text(1) if len(invocation.args) > 1 else "self")


def _label(term: Term) -> str:
    """The label that a term names: an atom, with annotations or without, a text, or a plan that has one."""
    if isinstance(term, PlanTerm) and isinstance(term.plan, Plan):
        return term.plan.label
    if isinstance(term, Structure):
        return str(term.without_annotations())
    return term.value if isinstance(term, String) else str(term)


def _find_plan(invocation: Invocation, term: Term) -> Plan | None:
    """The agent's plan that a term names."""
    label = _label(term)
    plans = (plan for plan in invocation.agent.library.plans if not plan.builtin)
    return next((plan for plan in plans if label in (plan.label, _label_term(invocation, plan).functor)), None)


@internal_action("relevant_plan", 2, inspects=True)
def _relevant_plan(invocation: Invocation) -> Iterator[object]:
    """Like ``.relevant_plans``, one plan a solution."""
    for plan in _plans_for(invocation):
        if invocation.unify(1, _plan_term(invocation, plan)):
            yield plan


@internal_action("list_plans", 0, 1, inspects=True)
def _list_plans(invocation: Invocation) -> Outcome:
    """Print the plans, or those for an event, one a line."""
    agent = invocation.agent
    own = [plan for plan in agent.library.plans if not plan.builtin]
    for plan in _plans_for(invocation) if invocation.args else own:
        agent.run.print(agent.name, f"{plan}.")
    return True


def _plans_for(invocation: Invocation) -> list[Plan]:
    """The plans for the event that is the first argument."""
    value = invocation.value(0)
    if isinstance(value, PlanTerm):
        trigger = _plan(invocation, value).trigger
    else:
        trigger = invocation.read(invocation.text(0), parse_trigger)
    return [plan for plan in invocation.agent.library.plans if not plan.builtin and _is_for(plan, trigger)]


@internal_action("relevant_plans", 2, 3, inspects=True)
def _relevant_plans(invocation: Invocation) -> Outcome:
    plans = _plans_for(invocation)
    labels = ListTerm(tuple(_label_term(invocation, plan) for plan in plans))
    return invocation.unify(1, ListTerm(tuple(_plan_term(invocation, plan) for plan in plans))) and (
        len(invocation.args) == 2 or invocation.unify(2, labels)
    )


def _is_for(plan: Plan, trigger: PlanTrigger) -> bool:
    return plan.trigger.sign == trigger.sign and unify(plan.trigger.literal, trigger.literal, {}, [])


@internal_action("plan_label", 2, inspects=True)
def _plan_label(invocation: Invocation) -> Outcome:
    plan = _find_plan(invocation, invocation.value(1))
    return plan is not None and invocation.unify(0, _plan_term(invocation, plan))
