"""For how many cycles an agent certainly keeps to itself when it reacts to an event.

An agent that sends something to another can go on at once for as long: nothing that the receiver does meanwhile
concerns it. What counts is the shortest way through the plans to a statement that anybody else could notice.
"""

from __future__ import annotations

from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.syntax import (
    AchievementGoal,
    BeliefUpdate,
    ConditionStatement,
    EventKey,
    ExternalAction,
    For,
    If,
    InternalActionCall,
    Plan,
    Statement,
    TestGoal,
    While,
)
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Call, Number, Structure

from ..company import Company
from ..intentions import duration
from ..library import PlanLibrary
from .layout import Layout, blocks
from .program import Calm

CALM = 60
"""Cycles, as many as are of interest."""
_PRINTS = frozenset({".print", ".println"})


class CalmAnalysis:
    """Looks at the plans of an agent.

    Args:
        library: the plans.
        company: the agents of its system.
    """

    def __init__(self, library: PlanLibrary, company: Company) -> None:
        self._library = library
        self._company = company
        self._plans = [plan for plan in library.plans if not plan.builtin]
        self._layouts = {id(plan): Layout(plan) for plan in self._plans}
        self._triggers: dict[tuple[EventKey, bool], int] = {}
        # What happens after a failure, which can come anywhere, is not looked into.
        self._handles_failures = any(plan.trigger.sign[0] == "-" and len(plan.trigger.sign) > 1 for plan in self._plans)

    def calm(self) -> dict[EventKey, Calm]:
        """For each event that there are plans for, the cycles from the one on in which a plan is selected."""
        # Goals are most often pursued above the plans for them: what follows is known first.
        plans = reversed(self._plans)
        keys = list(dict.fromkeys(key for plan in plans if (key := plan.trigger.key) is not None))
        if self._handles_failures:
            return dict.fromkeys(keys, (0, 0))
        self._triggers = {(key, is_open): CALM for key in keys for is_open in (False, True)}
        changed = True
        while changed:
            changed = False
            for (key, is_open), known in self._triggers.items():
                found = min(self._of_plan(plan, is_open) for plan in self._library.relevant(*key))
                if found < known:
                    self._triggers[key, is_open] = found
                    changed = True
        return {key: (self._triggers[key, False], self._triggers[key, True]) for key in keys}

    def _of_plan(self, plan: Plan, is_open: bool) -> int:
        if plan.builtin or plan.atomic or (plan.context is not None and _calls(plan.context)):
            return 0
        layout = self._layouts[id(plan)]
        end = 0 if is_open else CALM
        cycles = {layout.end: end}
        # What comes after a statement has a higher number, unless it is the head of the loop that it is in.
        for pc, statement in sorted(layout.statements, key=lambda numbered: -numbered[0]):
            cycles[pc] = min(CALM, self._of_statement(statement, pc, layout, cycles, is_open))
        return cycles[0] if layout.end else end

    def _of_statement(
        self, statement: Statement, pc: int, layout: Layout, cycles: dict[int, int], is_open: bool
    ) -> int:
        after = layout.after[pc]
        then = cycles.get(after, 0)
        if isinstance(statement, AchievementGoal):
            return self._of_goal(statement, is_open or after != layout.end)
        if isinstance(statement, BeliefUpdate):
            return 1 if self._has_plans(statement.sign.replace("++", "+"), statement.literal) else 1 + then
        if isinstance(statement, ExternalAction):
            # A variable could stand for a body.
            return 1 + then if self._company.one_acts and isinstance(statement.action, Structure) else 0
        if isinstance(statement, InternalActionCall):
            return self._of_internal(statement.call, then)
        if isinstance(statement, (ConditionStatement, TestGoal)):
            asks = isinstance(statement, TestGoal) and any(plan.trigger.sign == "+?" for plan in self._plans)
            return 0 if asks or _calls(statement.formula) else 1 + then
        if not isinstance(statement, (If, While, For)) or _calls(statement.condition):
            return 0
        starts = [cycles[first] for block, first in blocks(statement, pc) if block]
        return 1 + min([then, *starts])

    def _of_goal(self, statement: AchievementGoal, is_open: bool) -> int:
        if statement.new_intention or not isinstance(statement.literal, Structure):
            return 1
        # Without any plan for it the goal fails, and with it what waits for it.
        return 1 + self._triggers.get((("+!", statement.literal.key), is_open), CALM)

    def _of_internal(self, call: Call, then: int) -> int:
        if call.name in _PRINTS:
            return 1 + then if self._company.one_prints else 0
        if call.name == ".abolish":
            return 1 if self._has_plans("-", call.args[0] if call.args else None) else 1 + then
        if call.name == ".wait" and len(call.args) == 1 and isinstance(call.args[0], Number):
            ticks = duration(call.args[0])
            return CALM if ticks >= CALM else 1 + int(ticks) + then
        return 0

    def _has_plans(self, signs: str, literal: object) -> bool:
        """Whether there may be a plan for the event of a belief."""
        if not isinstance(literal, Structure):
            return True
        return any(self._library.relevant(sign, literal.key) for sign in signs)


def _calls(formula: Formula) -> bool:
    return any(isinstance(part, Call) for part in parts_of(formula))
