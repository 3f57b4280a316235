"""How the intentions go on that wait for events, conditions, answers or time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.syntax import Trigger
from pytest_hricdv.bdi.language.terms import ListTerm, Number, Structure
from pytest_hricdv.bdi.logic.inference import first
from pytest_hricdv.bdi.logic.unify import Trail, undo, unify

from .failure import fail
from .intentions import TICKS_PER_MS, Wait

if TYPE_CHECKING:
    from .agent import Agent


def wake_by_event(agent: Agent, sign: str, literal: Structure) -> None:
    """Let those go on in the next cycle that wait for an event like this one."""
    for wait in list(agent.waits):
        if wait.trigger is not None and _is_awaited(wait, wait.trigger, sign, literal):
            _end(agent, wait)
            agent.woken.append(wait.intention)
            agent.disturbed = True


def _is_awaited(wait: Wait, trigger: Trigger, sign: str, literal: Structure) -> bool:
    bindings = wait.intention.frames[-1].unifier
    trail: Trail = []
    if trigger.sign == sign and unify(trigger.literal, literal, bindings, trail):
        return True
    undo(bindings, trail, 0)
    return False


def wake_by_conditions(agent: Agent) -> None:
    """Let those go on in the next cycle whose condition holds now."""
    for wait in list(agent.waits):
        if wait.condition is None:
            continue
        frame = wait.intention.frames[-1]
        solution = first(agent, wait.condition, frame.unifier)
        if solution is not None:
            frame.unifier = solution
            _end(agent, wait)
            agent.woken.append(wait.intention)
            agent.disturbed = True


def _end(agent: Agent, wait: Wait) -> None:
    """End a wait and note how long it took."""
    agent.waits.remove(wait)
    if wait.elapsed is not None:
        elapsed = Number(round((agent.run.ticks - wait.since) / TICKS_PER_MS))
        unify(wait.elapsed, elapsed, wait.intention.frames[-1].unifier, [])


def end_waits(agent: Agent, now: int) -> None:
    """Let the intentions go on, or fail, whose wait is over, the earliest first."""
    over = [wait for wait in agent.waits if wait.deadline is not None and wait.deadline <= now]
    if len(over) > 1:
        over.sort(key=lambda wait: wait.deadline or 0)
    for wait in over:
        waits_for_something = wait.trigger is not None or wait.condition is not None
        if waits_for_something and wait.elapsed is None:
            agent.waits.remove(wait)
            fail(agent, wait.intention, "wait_timeout", "timeout in .wait")
        else:
            _end(agent, wait)
            agent.resume(wait.intention)
    if agent.questions:
        _end_questions(agent, now)


def _end_questions(agent: Agent, now: int) -> None:
    """Let the intentions go on whose questions have not been answered in time."""
    for number, question in list(agent.questions.items()):
        if number in agent.questions and question.deadline is not None and question.deadline <= now:
            agent.questions = {each: other for each, other in agent.questions.items() if other is not question}
            answer = Structure("timeout") if question.asked is None else ListTerm(tuple(question.answers))
            unify(question.answer, answer, question.intention.frames[-1].unifier, [])
            agent.resume(question.intention)
