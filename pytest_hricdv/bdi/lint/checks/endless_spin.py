"""A goal that is pursued over and over, and that nothing can end."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.syntax import (
    AchievementGoal,
    Body,
    InternalActionCall,
    Plan,
    Statement,
    While,
    children,
)
from pytest_hricdv.bdi.language.terms import Call, Key, Structure
from pytest_hricdv.bdi.logic.unify import unify

from ..model import AgentModel, System

ENDING = frozenset(
    {
        ".drop_all_desires",
        ".drop_all_events",
        ".drop_all_intentions",
        ".drop_desire",
        ".drop_event",
        ".drop_intention",
        ".fail_goal",
        ".stopMAS",
        ".succeed_goal",
        ".suspend",
    }
)
"""Actions of the agent that may end a goal from outside."""
CHANGING = frozenset({".random", ".time", ".desire", ".intend", ".abolish"})
"""Actions in conditions that may come out otherwise the next time."""


class EndlessSpin:
    """Plans and loops that only look again, at what can never change."""

    name = "endless-spin"
    why = "Once begun it goes on for ever: the goal is never achieved, and a run ends only because it is noticed."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each such plan or loop."""
        for agent in system.agents:
            if agent.actions & ENDING or _is_told_to_stop(system, agent):
                continue
            changing = _Changing(system, agent)
            for index, plan in enumerate(agent.plans):
                if _only_repeats(plan) and not changing.way_out(agent.plans[:index], plan):
                    yield plan.location, f"nothing can end the pursuit of {plan.trigger}"
                for loop in _loops(plan.body):
                    if all(map(_only_waits, loop.body)) and not changing.may_change(loop.condition):
                        yield loop.location, f"nothing can end the loop while ({loop.condition})"


def _is_told_to_stop(system: System, agent: AgentModel) -> bool:
    return any(message.force == "unachieve" for sender in system.agents for message in sender.sent)


def _only_repeats(plan: Plan) -> bool:
    """Whether a plan for a goal does nothing but pursue the goal again, after waiting at most."""
    if plan.trigger.sign != "+!" or not plan.body:
        return False
    *before, last = plan.body
    return isinstance(last, AchievementGoal) and last.literal == plan.trigger.literal and all(map(_only_waits, before))


def _only_waits(statement: Statement) -> bool:
    return isinstance(statement, InternalActionCall) and statement.call.name == ".wait"


def _loops(body: Body) -> Iterator[While]:
    for statement in body:
        if isinstance(statement, While):
            yield statement
        for block in ("then", "otherwise", "body"):
            yield from _loops(getattr(statement, block, ()))


class _Changing:
    """Knows which conditions of an agent may come out otherwise in the course of a run."""

    def __init__(self, system: System, agent: AgentModel) -> None:
        self._agent = agent
        self._added = [addition for addition in system.comes_to_hold(agent) if addition.later]
        self._deleted = {mention.literal.key for mention in agent.deletions}
        self._deleted |= {
            message.content.key
            for sender in system.agents
            for message in sender.sent
            if message.force == "untell" and isinstance(message.content, Structure)
        }

    def way_out(self, earlier: tuple[Plan, ...], plan: Plan) -> bool:
        """Whether a plan may cease to be applicable, or an earlier one become so."""
        if plan.context is not None and self.may_change(plan.context):
            return True
        return any(
            other.context is not None and self.may_change(other.context)
            for other in earlier
            if other.trigger.sign == plan.trigger.sign and unify(other.trigger.literal, plan.trigger.literal, {}, [])
        )

    def may_change(self, formula: Formula) -> bool:
        """Whether a condition may come out otherwise."""
        return any(
            self._predicate_may_change(part.key, set())
            if isinstance(part, Structure)
            else isinstance(part, Call) and part.name in CHANGING
            for part in _literals(formula)
        )

    def _predicate_may_change(self, key: Key, seen: set[Key]) -> bool:
        if key in seen:
            return False
        seen.add(key)
        if key in self._deleted or any(addition.may_be(key) for addition in self._added):
            return True
        return any(
            isinstance(part, Call) or self._predicate_may_change(part.key, seen)
            for rule in self._agent.rules
            if rule.head.key == key
            for part in _literals(rule.body)
        )


def _literals(formula: object) -> Iterator[Structure | Call]:
    """The literals and internal actions in a condition, those within its arguments too."""
    pending: list[object] = [formula]
    while pending:
        part = pending.pop()
        if isinstance(part, (Structure, Call)):
            yield part
        if not isinstance(part, Structure):
            pending.extend(children(part))
