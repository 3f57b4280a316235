"""Handing an agent over from compiled code to the interpreter: the same mental state in the interpreter's terms."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.syntax import Body, For, If, While
from pytest_hricdv.bdi.language.terms import Structure, Term, Variable
from pytest_hricdv.bdi.logic.substitution import Bindings

from ..agent import Agent
from ..beliefs import BeliefBase
from ..intentions import Event, Frame, Intention, Loop, Wait
from .activity import Activity, Goal
from .layout import blocks, number, size
from .program import PlanCode, Values

if TYPE_CHECKING:
    from .agent import CompiledAgent


def to_interpreter(compiled: CompiledAgent) -> Agent:
    """The agent for the interpreter; the compiled one must not be used any more."""
    agent = Agent(compiled.name, compiled.run, _beliefs(compiled), compiled.code.library, [])
    intentions: dict[int, Intention] = {}

    def intention_of(activity: Activity) -> Intention:
        if activity.number not in intentions:
            intentions[activity.number] = _intention(activity)
        return intentions[activity.number]

    agent.mailbox = compiled.mailbox
    agent.executed = compiled.executed
    agent.listed = compiled.listed
    for goal, activity in compiled.events:
        waiting = None if activity is None else intention_of(activity)
        agent.events.append(Event(goal[0].sign, _literal(goal), waiting))
    agent.feedback = deque((intention_of(activity), success) for activity, success in compiled.feedback)
    agent.intentions = deque(intention_of(activity) for activity in compiled.intentions)
    for wait in compiled.waits:
        agent.waits.append(Wait(intention_of(wait.intention), wait.since, wait.deadline))
    agent.take_over(compiled.activities, compiled.seen_percepts)
    return agent


def _beliefs(compiled: CompiledAgent) -> BeliefBase:
    base = BeliefBase()
    for name, annots in compiled.p.items():
        base.add(Structure(name.removeprefix("~"), (), annots, name.startswith("~")))
    tables = {key: compiled.tables[place] for key, place in compiled.code.program.tables.items()}
    for (negated, functor, _), table in (tables | compiled.others).items():
        for args, annots in table.items():
            base.add(Structure(functor, args, annots, negated))
    return base


def _intention(activity: Activity) -> Intention:
    intention = Intention(activity.number)
    own = (activity.plan, activity.pc, activity.values, activity.goal)
    intention.frames = [_frame(*plan) for plan in (*activity.below, own)]
    return intention


def _literal(goal: Goal) -> Structure:
    trigger, args, annots = goal
    return Structure(trigger.key[1], args, annots, trigger.key[0])


def _frame(code: PlanCode, pc: int, values: Values, goal: Goal) -> Frame:
    bound: Bindings = {}
    for variable, value in zip(code.variables, values, strict=False):
        if value is not None:
            bound[variable] = value  # type: ignore[assignment]
    left = dict(zip(code.loops, values[len(code.variables) :], strict=True))
    frame = Frame(code.plan, goal[0].sign, _literal(goal), bound)
    if pc != code.end:
        _go_to(frame, code, code.plan.body, 0, pc, left)
    else:
        frame.pc = len(frame.body)
    return frame


def _go_to(frame: Frame, code: PlanCode, body: Body, start: int, pc: int, left: dict[int, object]) -> None:
    """Put a frame at the statement of a number, inside the blocks that it is in."""
    for index, (own, statement) in enumerate(number(body, start)):
        if own == pc:
            frame.body, frame.pc = body, index
            if isinstance(statement, (For, While)) and left[own] is not None:
                frame.loop = _loop(frame, code, statement, own, left)
            return
        for block, first in blocks(statement, own):
            if not first <= pc < first + size(block):
                continue
            if isinstance(statement, If):
                frame.blocks.append((body, index + 1, None))
            elif isinstance(statement, (For, While)):
                frame.blocks.append((body, index, _loop(frame, code, statement, own, left)))
            _go_to(frame, code, block, first, pc, left)
            return


def _loop(frame: Frame, code: PlanCode, statement: For | While, pc: int, left: dict[int, object]) -> Loop:
    known = code.loops[pc]
    outer: Bindings = {each: frame.unifier[each] for each in known.outer if each in frame.unifier}
    remaining = left[pc]
    solutions = list(reversed(remaining)) if isinstance(remaining, list) else []
    return Loop(statement, outer, deque(outer | _named(known.new, solution) for solution in solutions))


def _named(variables: tuple[Variable, ...], values: tuple[Term, ...]) -> Bindings:
    return dict(zip(variables, values, strict=True))
