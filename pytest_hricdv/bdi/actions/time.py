"""Waiting, and the virtual clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import EvaluationError
from ..inference import first
from ..intentions import Frame, Intention, Wait
from ..parser import parse_trigger
from ..syntax import Plan, Trigger
from ..terms import Arithmetic, Call, Number, Quoted, String, Variable
from .registry import Invocation, Outcome, internal_action, prepared

if TYPE_CHECKING:
    from ..agent import Agent
    from ..execution import Step


@internal_action("wait", 1, 3)
def _wait(invocation: Invocation) -> Outcome:
    """``.wait(Ms)``, ``.wait(Event or condition)``, ``.wait(Event or condition, Ms)``, with the time waited third."""
    agent, run = invocation.agent, invocation.agent.run
    what = invocation.args[0]
    intention = invocation.own_intention()
    value = invocation.value(0) if _is_value(what) else what
    wait = Wait(intention, run.ticks)
    if isinstance(value, Number):
        wait.deadline = run.after(value)
    elif isinstance(value, (String, Quoted)):
        wait.trigger = _trigger(value)
    else:
        solution = first(agent, what, invocation.bindings)
        if solution is not None:
            intention.frames[-1].unifier = solution
            return True
        wait.condition = what
    if len(invocation) > 1:
        wait.deadline = run.after(invocation.number(1))
    if len(invocation) > 2:
        wait.elapsed = invocation.args[2]
    if wait.deadline is not None:
        run.note_deadline(wait.deadline)
    agent.waits.append(wait)
    invocation.held = True
    return True


@prepared("wait")
def _prepared_wait(call: Call, otherwise: Step) -> Step:
    """For a known time."""
    wait_ms = call.args[0]
    if len(call.args) != 1 or not isinstance(wait_ms, Number):
        return otherwise

    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        run = agent.run
        deadline = run.after(wait_ms)
        run.note_deadline(deadline)
        agent.waits.append(Wait(intention, run.ticks, deadline))

    return step


def _is_value(what: object) -> bool:
    return isinstance(what, (Number, String, Quoted, Variable, Arithmetic))


def _trigger(value: String | Quoted) -> Trigger:
    if isinstance(value, String):
        return parse_trigger(value.value)
    if not isinstance(value.plan, Plan):
        raise EvaluationError(f"{value} is not an event")
    return value.plan.trigger


@internal_action("time", 3)
def _time(invocation: Invocation) -> Outcome:
    """The virtual time of the run as hours, minutes and seconds; every run begins at 0:00:00."""
    invocation.agent.run.progress += 1
    seconds = int(invocation.agent.run.time_ms // 1000)
    parts = (seconds // 3600, seconds // 60 % 60, seconds % 60)
    return all(invocation.unify(index, Number(part)) for index, part in enumerate(parts))
