"""Executing statements of plans: a function for each, made once, when it is executed for the first time.

What can be known of a statement beforehand is looked at when that function is made: its kind, whether its literal is
ground, how its arguments get their values.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pytest_hricdv.bdi.language.formulas import Comparison
from pytest_hricdv.bdi.language.syntax import (
    AchievementGoal,
    BeliefUpdate,
    ConditionStatement,
    ExternalAction,
    For,
    If,
    InternalActionCall,
    Plan,
    Statement,
    TestGoal,
    While,
)
from pytest_hricdv.bdi.language.terms import AnnotatedVariable, PlanTerm, Structure, Variable

from . import failure
from .actions import PREPARED, Invocation, call_action
from .blocks import choose, for_each, repeat
from .conditions import comparison_of, question_of
from .instances import instantiate, literal_of, maker_of
from .intentions import Frame, Intention
from .spinning import leave_alone
from .updates import believe

if TYPE_CHECKING:
    from .agent import Agent

Step = Callable[["Agent", Intention, Frame], bool | None]
"""Executes a statement for an intention that is at it.

True if it is done and the intention is to go on with the next; if not, the intention is where it belongs: waiting,
failed, ended, or ready for something else. None if, besides, others may have been given something to do, or the run
ends. Raises an EvaluationError if the statement fails because something in it has no value, and a BdiError if the run
cannot go on."""


def step_of(statement: Statement, plan: Plan) -> Step:
    """How a statement of a plan is executed."""
    if statement.step is None:
        step = _again(plan) if plan.is_busy_wait else _MAKERS[type(statement)](statement)
        object.__setattr__(statement, "step", step)
    return statement.step  # type: ignore[return-value]


def _achieve(statement: AchievementGoal) -> Step:
    if statement.new_intention:
        return _achieve_apart(statement)
    ready, make = statement.event_literal, maker_of(statement.literal)

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        agent.post("+!", ready or make(agent, frame), intention)
        return False

    return step


def _again(plan: Plan) -> Step:
    """The step of a plan that does nothing but pursue its own goal again."""
    (statement,) = plan.body
    assert isinstance(statement, AchievementGoal)
    goal = statement.event_literal
    assert goal is not None

    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        agent.post("+!", goal, intention)
        if agent.only_spins(goal):
            leave_alone(agent, plan.label, agent.run.rounds + 1)

    return step


def _achieve_apart(statement: AchievementGoal) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        agent.post_goal(statement.event_literal or instantiate(agent, statement.literal, frame))
        return True

    return step


def _test(statement: TestGoal) -> Step:
    formula = statement.formula
    holds = question_of(formula)

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        if holds(agent, frame):
            return True
        if isinstance(formula, (Structure, Variable, AnnotatedVariable)):
            literal = instantiate(agent, formula, frame)
            if agent.library.relevant("+?", literal.key):
                agent.post("+?", literal, intention)
                return False
        failure.fail(agent, intention, "test_goal_failed", f"test goal {statement} failed")
        return False

    return step


def _act(statement: ExternalAction) -> Step:
    written = statement.action
    if isinstance(written, Variable):
        return _perform(statement, written)
    ready = written if isinstance(written, Structure) and written.ground else None

    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        action = ready or literal_of(agent, written, frame.unifier)
        success = agent.run.act(agent.name, action, frame.plan, statement)
        agent.feedback.append((intention, success))

    return step


def _perform(statement: ExternalAction, variable: Variable) -> Step:
    """For a variable: the action, or the body, that it stands for."""

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool | None:
        value = agent.value(variable, frame.unifier)
        if isinstance(value, PlanTerm) and isinstance(value.plan, tuple):
            frame.enter(value.plan, None)
            return step_of(frame.statement, frame.plan)(agent, intention, frame)
        action = literal_of(agent, variable, frame.unifier)
        success = agent.run.act(agent.name, action, frame.plan, statement)
        agent.feedback.append((intention, success))
        return None

    return step


def _internal(statement: InternalActionCall) -> Step:
    call = statement.call

    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        invocation = Invocation(agent, call, frame.unifier, [], intention)
        outcome = call_action(invocation)
        if not isinstance(outcome, bool):
            outcome = next(iter(outcome), None) is not None
        if invocation.held:
            return
        if outcome:
            agent.go_on(intention)
        else:
            failure.fail(agent, intention, "ia_failed", f"{statement} failed", invocation.failure)

    prepare = PREPARED.get(call.name)
    return step if prepare is None else prepare(call, step)


def _check(statement: ConditionStatement) -> Step:
    formula = statement.formula
    if isinstance(formula, Comparison):
        compared = comparison_of(formula)
        return _checked(statement, lambda agent, frame: compared(agent, frame.unifier))
    return _checked(statement, question_of(formula))


def _checked(statement: ConditionStatement, holds: Callable[[Agent, Frame], bool]) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        if holds(agent, frame):
            return True
        failure.fail(agent, intention, "constraint_failed", f"condition {statement} does not hold")
        return False

    return step


_MAKERS: dict[type, Callable[[Any], Step]] = {
    AchievementGoal: _achieve,
    TestGoal: _test,
    BeliefUpdate: believe,
    ExternalAction: _act,
    InternalActionCall: _internal,
    ConditionStatement: _check,
    If: choose,
    While: repeat,
    For: for_each,
}
