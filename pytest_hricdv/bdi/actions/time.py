"""Internal actions of virtual time (``.wait``, ``.at`` ...), which plans call; `internal_action` registers them."""

from __future__ import annotations

import re
from datetime import date, timedelta

from pytest_hricdv.bdi.actions.registry import WRONG, Invocation, internal_action, is_function
from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.intentions import IntendedMeans, Outcome, PendingWait
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.parser import parse_trigger
from pytest_hricdv.bdi.language.syntax import GOAL_STATE, InternalActionCall, Plan, PlanTrigger
from pytest_hricdv.bdi.language.terms import Arithmetic, Call, Number, PlanTerm, String, Structure, Variable
from pytest_hricdv.bdi.logic.inference import first

_DELAY = re.compile(r"\s*now(?:\s*\+\s*(\d+)\s*([a-z]*))?\s*")
_UNITS_MS = {"": 1, "ms": 1, "s": 1_000, "m": 60_000, "h": 3_600_000, "d": 86_400_000}
_UNITS = {"second": "s", "minute": "m", "hour": "h", "day": "d"}
"""The units of a delay such as ``now + 3 seconds``, which ``.at`` takes."""
_AT = Structure("at")


@internal_action("wait", 1, 3)
def _wait(invocation: Invocation) -> Outcome:
    """``.wait(Ms)``, ``.wait(Event or condition)``, ``.wait(Event or condition, Ms)``, with the time waited third."""
    agent, run = invocation.agent, invocation.agent.run
    awaited = invocation.args[0]
    intention = invocation.own_intention()
    value = invocation.value(0) if _is_value(awaited) else awaited
    wait = PendingWait(intention, run.ticks)
    if isinstance(value, Number):
        if -1 < value <= 0:
            # Like an action that is done at once: it continues after the others, and after a plan selected meanwhile.
            agent.feedback.append((intention, True))
            invocation.held = True
            return True
        wait.deadline = _deadline(invocation, value)
    elif isinstance(value, (String, PlanTerm)):
        wait.trigger = _trigger(invocation, value)
    else:
        solution = first(agent, awaited, invocation.bindings)
        if solution is not None:
            intention.top.unifier = solution
            return True
        wait.condition = awaited
    # As in Jason, arguments after a number of milliseconds are ignored.
    if len(invocation.args) > 1 and not isinstance(value, Number):
        wait.deadline = _deadline(invocation, invocation.number(1))
    if len(invocation.args) > 2 and not isinstance(value, Number):
        wait.elapsed = invocation.args[2]
    if wait.deadline is not None:
        run.note_deadline(wait.deadline)
    agent.waits.append(wait)
    agent.awaits_goals |= wait.trigger is not None and wait.trigger.sign == GOAL_STATE
    invocation.held = True
    return True


def _deadline(invocation: Invocation, milliseconds: float) -> float | None:
    """The end of a time; a negative one never ends, as in Jason."""
    run = invocation.agent.run
    if milliseconds > -1:
        return run.deadline(milliseconds)
    run.warn(f"{invocation.agent.name}: {invocation.call.location}: {invocation.call}: a negative time never ends")
    return None


@internal_action("at", 2)
def _at(invocation: Invocation) -> Outcome:
    """``.at("now +3 seconds", {+!g})``: an event in some time; the units are ``s``, ``m``, ``h`` and ``d``, else ms.

    Only the event comes: an event of a belief does not change what the agent believes.
    """
    agent, run, place = invocation.agent, invocation.agent.run, invocation.call.location
    when = _DELAY.fullmatch(invocation.text(0))
    unit = None if when is None else _UNITS.get((when[2] or "").removesuffix("s"), when[2] or "")
    if when is None or unit not in _UNITS_MS:
        raise EvaluationError(f'{invocation.call}: the time is not of the form "now +3 s"', WRONG)
    event = _event(invocation, 1)
    trigger = _trigger(invocation, event)
    delay_ms = float(when[1] or 0) * _UNITS_MS[unit]
    if not delay_ms:  # also the call that is left to do when the time has come
        return _cause(agent, trigger)
    # An intention of its own: it waits at its first statement, and its second one is the event, then due at once.
    later = InternalActionCall(Call(".at", (String("now"), event), place), place)
    plan = Plan("_at", PlanTrigger("+", _AT), None, (later, later), place, builtin=True)
    intention = agent.new_intention()
    intention.stack.append(IntendedMeans(plan, "+", _AT, {}))
    deadline = run.deadline(delay_ms)
    run.note_deadline(deadline)
    agent.waits.append(PendingWait(intention, run.ticks, deadline))
    return True


def _cause(agent: AgentState, trigger: PlanTrigger) -> bool:
    literal = trigger.literal
    if not isinstance(literal, Structure):
        raise EvaluationError(f"{trigger} is not an event", WRONG)
    if trigger.sign == "+!":
        agent.post_goal(literal.with_own_source())
    else:
        agent.post(trigger.sign, literal.with_own_source(), None)
    return True


def _is_value(argument: object) -> bool:
    return isinstance(argument, (Number, String, PlanTerm, Variable, Arithmetic)) or (
        isinstance(argument, Call) and is_function(argument)
    )


def _event(invocation: Invocation, index: int) -> String | PlanTerm:
    value = invocation.value(index)
    if not isinstance(value, (String, PlanTerm)):
        raise EvaluationError(f"{invocation.call}: argument {index + 1} is not an event but {value}", WRONG)
    return value


def _trigger(invocation: Invocation, value: String | PlanTerm) -> PlanTrigger:
    if isinstance(value, String):
        return invocation.read(value.value, parse_trigger, "unknown")
    if not isinstance(value.plan, Plan):
        raise EvaluationError(f"{value} is not an event")
    return value.plan.trigger


@internal_action("signal", 1)
def _signal(invocation: Invocation) -> Outcome:
    """``.signal({+b})``: the event comes, while what the agent believes stays."""
    return _cause(invocation.agent, _trigger(invocation, _event(invocation, 0)))


@internal_action("nano_time", 1)
def _nano_time(invocation: Invocation) -> Outcome:
    """The virtual time of the run in nanoseconds."""
    invocation.agent.run.progress += 1
    return invocation.unify(0, Number(round(invocation.agent.run.time_ms * 1_000_000)))


@internal_action("date", 3)
def _date(invocation: Invocation) -> Outcome:
    """The virtual date of the run as year, month and day; every run begins on the first of January 1970."""
    invocation.agent.run.progress += 1
    today = date(1970, 1, 1) + timedelta(milliseconds=invocation.agent.run.time_ms)
    return all(invocation.unify(index, Number(part)) for index, part in enumerate((today.year, today.month, today.day)))


@internal_action("time", 3, 4)
def _time(invocation: Invocation) -> Outcome:
    """The virtual time of the run as hours, minutes, seconds and, if asked for, ms; every run begins at 0:00:00."""
    invocation.agent.run.progress += 1
    seconds, ms = divmod(int(invocation.agent.run.time_ms), 1000)
    parts = (seconds // 3600, seconds // 60 % 60, seconds % 60, ms)
    return all(invocation.unify(index, Number(parts[index])) for index in range(len(invocation.args)))
