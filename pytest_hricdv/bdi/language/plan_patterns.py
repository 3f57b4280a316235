"""Patterns of plans for declarative goals, ``{ begin dg(g) } ... { end }``: kinds of commitment to a goal g.

`AgentSpeakTransformer` calls `expand_pattern` with the plans inside, and gets the changed plans as a `PlanPattern`. The
patterns are those of Bordini, Hübner and Wooldridge, Programming Multi-Agent Systems in AgentSpeak using Jason (2007),
chapter 8. A goal is declarative if it is achieved when the agent believes it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from pytest_hricdv.bdi.language.errors import EvaluationError, Location
from pytest_hricdv.bdi.language.syntax import (
    AchievementGoal,
    And,
    BeliefUpdate,
    Body,
    Formula,
    InternalActionCall,
    Not,
    Plan,
    PlanTrigger,
    TestGoal,
)
from pytest_hricdv.bdi.language.terms import Call, Number, Structure, Variable, source

_AUTOMATIC = "_plan"
"""Placeholder for the label of a plan: the parser replaces it by an automatic one."""
_ADOPTING, _ADOPTED = "fg__", "fl__"
"""Beliefs that the pattern sga (one goal at a time) adds: of goals that wait, and of the goal that is pursued."""


@dataclass(frozen=True, slots=True)
class PlanPattern:
    """The expansion of a directive with the plans in it.

    Args:
        plans: the plans, those of the source changed.
        beliefs: initial beliefs that the pattern adds.
    """

    plans: tuple[Plan, ...]
    beliefs: tuple[Structure, ...] = ()


def plans_in(parts: Iterable[Plan | PlanPattern]) -> PlanPattern:
    """The plans between ``begin`` and ``end``, including those of nested patterns."""
    plans: list[Plan] = []
    beliefs: list[Structure] = []
    for part in parts:
        if isinstance(part, PlanPattern):
            plans += part.plans
            beliefs += part.beliefs
        else:
            plans.append(part)
    return PlanPattern(tuple(plans), tuple(beliefs))


def expand_pattern(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """Expand a directive with the plans inside it.

    Raises:
        EvaluationError: there is no such directive, or it has other arguments; the message names those that there are.
    """
    pattern = _PATTERNS.get(directive.functor)
    if pattern is None:
        raise EvaluationError(
            f"unknown directive {{ begin {directive} }}: Java classes define others than {', '.join(_PATTERNS)}; "
            "write the plans that it stands for"
        )
    least, most, expand = pattern
    arguments = directive.args
    if not least <= len(arguments) <= most or not all(isinstance(argument, Structure) for argument in arguments):
        wanted = f"{least}" if least == most else f"{least} or {most}"
        raise EvaluationError(f"{{ begin {directive} }}: expected {wanted} literals in the parentheses")
    return expand(directive, inside, at)


def _declarative(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``dg(g)``: g is achieved once it is believed, and each plan for it ends with a test of it."""
    goal = _argument(directive, 0)
    achieved = _plan(PlanTrigger("+!", goal), goal, (), at)
    plans = [
        replace(plan, body=(*plan.body, TestGoal(goal, at))) if _is_for_goal(plan) else plan for plan in inside.plans
    ]
    ends = _plan(PlanTrigger("+", goal), None, (_call(".succeed_goal", goal, at),), at)
    return PlanPattern((achieved, *plans, ends), inside.beliefs)


def _with_backtracking(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``bdg(g)``: as dg; after a failure, g is tried again."""
    goal = _argument(directive, 0)
    again = _plan(PlanTrigger("-!", goal), None, _pursue(goal, at), at)
    return _and(_declarative(directive, inside, at), again)


def _exclusive(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``ebdg(g)``: as bdg, but each plan is tried only once."""
    goal = _argument(directive, 0)
    plans = []
    for number, plan in enumerate(inside.plans, start=1):
        tried = Structure("p__f", (Number(number), goal))
        if _is_for_goal(plan):
            parts: tuple[Formula, ...] = (Not(tried), *(() if plan.context is None else (plan.context,)))
            note = BeliefUpdate("+", tried, at)
            plan = replace(plan, context=And(parts) if len(parts) > 1 else parts[0], body=(note, *plan.body))
        plans.append(plan)
    expanded = _with_backtracking(directive, PlanPattern(tuple(plans), inside.beliefs), at)
    forget = _call(".abolish", Structure("p__f", (Variable("_Number"), goal)), at)
    ends = PlanTrigger("+", goal)
    return replace(
        expanded,
        plans=tuple(
            replace(plan, body=(forget, *plan.body)) if plan.trigger == ends and plan not in plans else plan
            for plan in expanded.plans
        ),
    )


def _blind(directive: Structure, inside: PlanPattern, at: Location, inner: int = 1) -> PlanPattern:
    """``bc(g)``: blind commitment, g is pursued until it is achieved; ``bc(g, dg)`` is made of another pattern."""
    goal = _argument(directive, 0)
    return _and(_inner(directive, inside, at, inner), _plan(PlanTrigger("+!", goal), None, _pursue(goal, at), at))


def _inner(directive: Structure, inside: PlanPattern, at: Location, index: int) -> PlanPattern:
    """Expand the pattern named by the argument at this index (default ``bdg``) for the goal of a directive."""
    kind = directive.args[index] if len(directive.args) > index else Structure("bdg")
    name = kind.functor if isinstance(kind, Structure) else str(kind)
    return expand_pattern(Structure(name, (_argument(directive, 0),)), inside, at)


def _pursue(goal: Structure, at: Location) -> Body:
    return (AchievementGoal(goal, False, at),)


def _single_minded(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``smc(g, f)``: as bc, until f is believed; then the intention of g is dropped."""
    return _give_up(_blind(directive, inside, at, inner=2), directive, at)


def _relative(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``rc(g, m)``: as bc, as long as the motivation m is believed."""
    return _and(_blind(directive, inside, at, inner=2), _no_longer_motivated(directive, 1, at))


def _open_minded(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``omc(g, f, m)``: as smc and rc together."""
    expanded = _give_up(_blind(directive, inside, at, inner=3), directive, at)
    return _and(expanded, _no_longer_motivated(directive, 2, at))


def _maintenance(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``mg(g)``: g, which is perceived at first, is achieved again whenever it ends."""
    goal = _argument(directive, 0)
    expanded = _inner(directive, inside, at, 1)
    again = _plan(PlanTrigger("-", goal), None, _pursue(goal, at), at)
    perceived = goal.with_annotations((*goal.annots, source("percept")))
    return PlanPattern((*expanded.plans, again), (*expanded.beliefs, perceived))


def _in_sequence(directive: Structure, inside: PlanPattern, at: Location) -> PlanPattern:
    """``sga(t, c, g)``: whenever t is believed while c holds, g is adopted: one after the other."""
    event, context, goal = (_argument(directive, index) for index in range(3))
    waiting, pursued = Structure(_ADOPTING, (goal,)), Structure(_ADOPTED, (goal,))
    any_pursued, other = Structure(_ADOPTED, (Variable("_Pursued"),)), Structure(_ADOPTING, (Variable("NextGoal"),))
    adopt = AchievementGoal(waiting, False, at)
    update = [BeliefUpdate(sign, literal, at) for sign, literal in (("+", pursued), ("-", pursued), ("-", other))]
    plans = (
        _plan(PlanTrigger("+", event), And((Not(any_pursued), context)), (adopt,), at),
        _plan(PlanTrigger("+", event), And((any_pursued, context)), (BeliefUpdate("+", waiting, at),), at),
        _plan(PlanTrigger("+!", waiting), None, (update[0], AchievementGoal(goal, False, at), update[1]), at),
        _plan(PlanTrigger("-!", waiting), None, (update[1],), at),
        _plan(PlanTrigger("-", any_pursued), other, (update[2], AchievementGoal(other, False, at)), at),
    )
    return PlanPattern((*inside.plans, *plans), inside.beliefs)


_PATTERNS: dict[str, tuple[int, int, Callable[[Structure, PlanPattern, Location], PlanPattern]]] = {
    "dg": (1, 1, _declarative),
    "bdg": (1, 1, _with_backtracking),
    "ebdg": (1, 1, _exclusive),
    "bc": (1, 2, _blind),
    "smc": (2, 3, _single_minded),
    "rc": (2, 3, _relative),
    "omc": (3, 4, _open_minded),
    "mg": (1, 2, _maintenance),
    "sga": (3, 3, _in_sequence),
}
"""The patterns: the least and greatest number of arguments, and what each makes of the plans inside."""


def _argument(directive: Structure, index: int) -> Structure:
    argument = directive.args[index]
    assert isinstance(argument, Structure)
    return argument


def _give_up(pattern: PlanPattern, directive: Structure, at: Location) -> PlanPattern:
    """Let the pattern give up the goal once the second argument is believed, and not retry it."""
    goal, hopeless = _argument(directive, 0), _argument(directive, 1)
    again = _plan(PlanTrigger("-!", goal), None, _pursue(goal, at), at)
    plans = (replace(plan, context=Not(hopeless)) if plan == again else plan for plan in pattern.plans)
    fails = _plan(PlanTrigger("+", hopeless), None, (_call(".fail_goal", goal, at),), at)
    return PlanPattern((*plans, fails), pattern.beliefs)


def _no_longer_motivated(directive: Structure, index: int, at: Location) -> Plan:
    ends = (_call(".succeed_goal", _argument(directive, 0), at),)
    return _plan(PlanTrigger("-", _argument(directive, index)), None, ends, at)


def _is_for_goal(plan: Plan) -> bool:
    return plan.trigger.sign == "+!"


def _and(pattern: PlanPattern, *plans: Plan) -> PlanPattern:
    return replace(pattern, plans=(*pattern.plans, *plans))


def _call(name: str, literal: Structure, at: Location) -> InternalActionCall:
    return InternalActionCall(Call(name, (literal,), at), at)


def _plan(trigger: PlanTrigger, context: Formula | None, body: Body, at: Location) -> Plan:
    return Plan(_AUTOMATIC, trigger, context, body, at)
