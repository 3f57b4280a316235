"""The end of waits: for conditions, for time, and for answers."""

from __future__ import annotations

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.failures import fail
from pytest_hricdv.bdi.language.terms import ListTerm, Structure
from pytest_hricdv.bdi.logic.inference import first
from pytest_hricdv.bdi.logic.unify import unify


def wake_by_conditions(agent: AgentState) -> None:
    """Let the intentions go on in the next cycle whose condition holds now."""
    for wait in list(agent.waits):
        if wait.condition is None:
            continue
        means = wait.intention.top
        solution = first(agent, wait.condition, means.unifier)
        if solution is not None:
            means.unifier = solution
            agent.end_wait(wait)
            agent.woken.append(wait.intention)


def end_waits(agent: AgentState, now: int) -> None:
    """Let the intentions go on, or fail, whose wait is over, the earliest first."""
    over = [wait for wait in agent.waits if wait.deadline is not None and wait.deadline <= now]
    over.sort(key=lambda wait: wait.deadline or 0)
    for wait in over:
        waits_for_something = wait.trigger is not None or wait.condition is not None
        if waits_for_something and wait.elapsed is None:
            agent.waits.remove(wait)
            fail(agent, wait.intention, "wait_timeout", "timeout in .wait")
        else:
            agent.end_wait(wait)
            agent.resume(wait.intention)
    _end_questions(agent, now)


def _end_questions(agent: AgentState, now: int) -> None:
    """Let the intentions go on whose questions have not been answered in time."""
    for number, question in list(agent.questions.items()):
        if number in agent.questions and question.deadline is not None and question.deadline <= now:
            agent.questions = {each: other for each, other in agent.questions.items() if other is not question}
            answer = Structure("timeout") if question.asked is None else ListTerm(tuple(question.answers))
            unify(question.answer, answer, question.intention.top.unifier, [])
            agent.resume(question.intention)
