"""Statements that contain blocks: ``if``, ``while``, ``for``."""

from __future__ import annotations

from collections import deque

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.intentions import IntendedMeans, Intention, Loop
from pytest_hricdv.bdi.language.syntax import For, If, While
from pytest_hricdv.bdi.logic.inference import first, solve


def execute_if(agent: AgentState, intention: Intention, means: IntendedMeans, statement: If) -> None:
    """Enter one block or the other."""
    solution = first(agent, statement.condition, means.unifier)
    if solution is not None:
        means.unifier = solution
    means.enter(statement.otherwise if solution is None else statement.then, None)
    agent.requeue(intention)


def execute_while(agent: AgentState, intention: Intention, means: IntendedMeans, statement: While) -> None:
    """Enter the block again if the condition holds, or leave the loop."""
    loop, means.loop = means.loop or Loop(statement, means.unifier, deque()), None
    # What was bound in the last iteration is not bound any more.
    solution = first(agent, statement.condition, loop.outer)
    if solution is None:
        _leave_loop(agent, intention, means, loop)
    else:
        means.unifier = dict(solution)
        means.enter(statement.body, loop)
        agent.requeue(intention)


def execute_for(agent: AgentState, intention: Intention, means: IntendedMeans, statement: For) -> None:
    """Enter the block with the next solution, or leave the loop.

    All solutions are found at the start, so that the body may change the beliefs that they came from.
    """
    loop, means.loop = means.loop, None
    if loop is None:
        loop = Loop(statement, means.unifier, deque(solve(agent, statement.condition, means.unifier)))
    if loop.solutions:
        means.unifier = loop.solutions.popleft()
        means.enter(statement.body, loop)
        agent.requeue(intention)
    else:
        _leave_loop(agent, intention, means, loop)


def _leave_loop(agent: AgentState, intention: Intention, means: IntendedMeans, loop: Loop) -> None:
    """What was bound in a loop is not bound after it."""
    means.unifier = loop.outer
    agent.go_on(intention)
