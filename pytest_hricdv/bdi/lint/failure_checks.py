"""Checks of failure plans: those for failures that cannot occur."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language import syntax
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Arithmetic, Call, Key, Structure, Variable
from pytest_hricdv.bdi.lint.model import AgentModel, Problem, System, check


@check("dead-timeout", "The plan never runs: nothing handles the time-out.")
def find_dead_timeouts(system: System) -> Iterator[Problem]:
    """Plans for a time-out that no statement of the agent can have."""
    for agent in system.agents:
        if system.may_receive_plans(agent) or ".fail" in agent.actions or ".fail_goal" in agent.actions:
            continue
        causes = _timeouts(agent)
        for plan in agent.plans:
            error = _error_of(plan)
            if plan.trigger.sign == "-!" and error in _TIMEOUTS and error not in causes:
                yield plan.location, f"nothing in {agent.name} fails with {error}: {_TIMEOUTS[error]}"


_TIMEOUTS = {
    "wait_timeout": "only .wait(event or condition, time) does, without a third argument",
    "deadline_reached": "only a goal with hard_deadline(time) does",
}


def _error_of(plan: syntax.Plan) -> str:
    """The error that a failure plan asks for by name, as in ``-!g[error(wait_timeout)]``."""
    for annot in getattr(plan.trigger.literal, "annots", ()):
        if isinstance(annot, Structure) and annot.functor == "error" and len(annot.args) == 1:
            return str(annot.args[0])
    return ""


def _timeouts(agent: AgentModel) -> set[str]:
    """The errors of time-outs that some statement of an agent may cause."""
    causes: set[str] = set()
    for part in parts_of((agent.plans, tuple(goal.literal for goal in agent.goals))):
        if isinstance(part, Call) and part.name == ".wait" and len(part.args) == 2:
            causes.add("wait_timeout")
        elif isinstance(part, Structure) and part.functor == "hard_deadline":
            causes.add("deadline_reached")
    return causes


@check(
    "dead-failure-plan",
    "The plan never runs: nothing handles a failure of the goal, or its deadline.",
)
def find_dead_failure_plans(system: System) -> Iterator[Problem]:
    """Plans for the failure of a goal that always has a plan to run, of statements that cannot fail."""
    for agent in system.agents:
        if system.may_receive_plans(agent) or agent.actions & {".fail", ".fail_goal"}:
            continue
        for_any_goal = any(plan.trigger.sign == "+!" and plan.trigger.key is None for plan in agent.plans)
        if for_any_goal or "deadline_reached" in _timeouts(agent):
            continue
        goals = _Goals(system, agent)
        for plan in agent.plans:
            goal = plan.trigger.literal
            if plan.trigger.sign != "-!" or not isinstance(goal, Structure) or _error_of(plan) in _TIMEOUTS:
                continue
            if not goals.may_fail(goal.key, frozenset()):
                yield plan.location, f"!{goal.without_annotations()} never fails: no statement of its plans can"


_NEVER_FAIL = frozenset({".print", ".println", ".log"})
_TELLING = frozenset({"tell", "untell", "achieve", "unachieve"})


class _Goals:
    """The goals of an agent that may fail; uncertain ones count as such."""

    def __init__(self, system: System, agent: AgentModel) -> None:
        self._agents = {other.name for other in system.agents}
        self._plans: dict[Key, list[syntax.Plan]] = {}
        for plan in agent.plans:
            if plan.trigger.sign == "+!" and isinstance(plan.trigger.literal, Structure):
                self._plans.setdefault(plan.trigger.literal.key, []).append(plan)

    def may_fail(self, goal: Key, outer: frozenset[Key]) -> bool:
        """Whether a goal may fail while these ones wait for it."""
        if goal in outer:  # one that pursues itself fails only where something else does
            return False
        plans = self._plans.get(goal, [])
        if not any(map(_is_always_applicable, plans)):
            return True
        return any(self._body_may_fail(plan.body, outer | {goal}) for plan in plans)

    def _body_may_fail(self, body: syntax.Body, outer: frozenset[Key]) -> bool:
        return any(self._statement_may_fail(statement, outer) for statement in body)

    def _statement_may_fail(self, statement: syntax.Statement, outer: frozenset[Key]) -> bool:
        if isinstance(statement, (syntax.If, syntax.While, syntax.For)):
            bodies = (statement.then, statement.otherwise) if isinstance(statement, syntax.If) else (statement.body,)
            return _computes(statement.condition) or any(self._body_may_fail(body, outer) for body in bodies)
        if _computes(statement):
            return True
        if isinstance(statement, syntax.BeliefUpdate):
            return not isinstance(statement.literal, Structure)
        if isinstance(statement, syntax.AchievementGoal):
            if not isinstance(statement.literal, Structure):
                return True
            return not statement.new_intention and self.may_fail(statement.literal.key, outer)
        return not isinstance(statement, syntax.InternalActionCall) or self._call_may_fail(statement.call)

    def _call_may_fail(self, call: Call) -> bool:
        if call.name in _NEVER_FAIL:
            return False
        if call.name == ".wait":
            return len(call.args) == 2 or isinstance(call.args[0], Variable)
        if call.name == ".send" and len(call.args) == 3:
            receiver, force, _ = call.args
            is_telling = isinstance(force, Structure) and force.functor in _TELLING
            return not (is_telling and isinstance(receiver, Structure) and receiver.functor in self._agents)
        return True


def _is_always_applicable(plan: syntax.Plan) -> bool:
    goal = plan.trigger.literal
    if not isinstance(goal, Structure) or goal.annots or plan.context not in (None, Structure("true")):
        return False
    return all(isinstance(arg, Variable) for arg in goal.args) and len({*goal.args}) == len(goal.args)


def _computes(part: object) -> bool:
    """Whether there is an expression in it, which has no value where an operand is no number."""
    inner = part.call.args if isinstance(part, syntax.InternalActionCall) else part
    return any(isinstance(term, (Arithmetic, Call)) for term in parts_of(inner))
