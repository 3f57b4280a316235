"""Statements with blocks in them: ``if``, ``while``, ``for``."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.syntax import For, If, While
from pytest_hricdv.bdi.logic.substitution import Bindings

from .conditions import question_of, solutions_of
from .intentions import Frame, Intention, Loop

if TYPE_CHECKING:
    from .agent import Agent
    from .execution import Step


def choose(statement: If) -> Step:
    """How to go into one block or the other."""
    holds = question_of(statement.condition)

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        frame.enter(statement.then if holds(agent, frame) else statement.otherwise, None)
        _requeue(agent, intention, frame)
        return False

    return step


def repeat(statement: While) -> Step:
    """How to go round while a condition holds."""
    holds = question_of(statement.condition)

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        loop = _loop(frame, statement, lambda: deque())
        # What was bound the last time round is not bound any more.
        frame.unifier = dict(loop.outer)
        if holds(agent, frame):
            frame.enter(statement.body, loop)
            _requeue(agent, intention, frame)
        else:
            _leave_loop(agent, intention, frame, loop)
        return False

    return step


def for_each(statement: For) -> Step:
    """How to go round for every solution.

    All are found at the start, so that the body may change what they came from.
    """
    solutions = solutions_of(statement.condition)

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        loop = _loop(frame, statement, lambda: deque(solutions(agent, frame.unifier)))
        if loop.solutions:
            frame.unifier = loop.solutions.popleft()
            frame.enter(statement.body, loop)
            _requeue(agent, intention, frame)
        else:
            _leave_loop(agent, intention, frame, loop)
        return False

    return step


def _loop(frame: Frame, statement: For | While, solutions: Callable[[], deque[Bindings]]) -> Loop:
    """The loop under way at this statement, or a new one."""
    loop, frame.loop = frame.loop, None
    return loop or Loop(statement, frame.unifier, solutions())


def _leave_loop(agent: Agent, intention: Intention, frame: Frame, loop: Loop) -> None:
    """What was bound in a loop is not bound after it."""
    frame.unifier = loop.outer
    agent.go_on(intention)


def _requeue(agent: Agent, intention: Intention, frame: Frame) -> None:
    if frame.finished:
        agent.clear(intention)
    else:
        agent.ready(intention)
