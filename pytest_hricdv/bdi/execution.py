"""Executing one statement of a plan's body."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from . import failure
from .actions import Invocation, call_action
from .comparison import compare
from .errors import EvaluationError
from .formulas import Comparison, Formula, GoalTerm
from .inference import first, solve
from .intentions import Frame, Intention, Loop
from .substitution import Bindings, free_variables
from .syntax import Achieve, Act, Believe, Check, For, If, Internal, Test, While
from .terms import SOURCE_SELF, Annotated, Structure, Variable

if TYPE_CHECKING:
    from .agent import Agent


def instantiate(agent: Agent, term: GoalTerm, frame: Frame) -> Structure:
    """A literal as it leaves its plan: bound, with a source, its free variables replaced by new ones."""
    literal = _literal(agent, term, frame.unifier)
    if not literal.ground:
        for variable in free_variables(literal):
            if not agent.run.is_fresh(variable):
                frame.unifier[variable] = agent.fresh()
        literal = _literal(agent, literal, frame.unifier)
    return literal if literal.has_source() else literal.annotated((*literal.annots, SOURCE_SELF))


def _literal(agent: Agent, term: GoalTerm, bindings: Bindings) -> Structure:
    literal = agent.value(term, bindings)
    if isinstance(literal, Variable):
        raise EvaluationError(f"variable {literal} has no value here", "body_var_without_value")
    if not isinstance(literal, Structure):
        raise EvaluationError(f"{term} is not a literal but {literal}")
    return literal


def _achieve(agent: Agent, intention: Intention, frame: Frame, statement: Achieve) -> None:
    goal = statement.ready or instantiate(agent, statement.literal, frame)
    if statement.apart:
        agent.post_goal(goal)
        agent.go_on(intention)
    else:
        agent.post("+!", goal, intention)


def _test(agent: Agent, intention: Intention, frame: Frame, statement: Test) -> None:
    formula = statement.formula
    solution = first(agent, formula, frame.unifier)
    if solution is not None:
        frame.unifier = solution
        agent.go_on(intention)
        return
    if isinstance(formula, (Structure, Variable, Annotated)):
        literal = instantiate(agent, formula, frame)
        if agent.library.relevant("+?", literal.key):
            agent.post("+?", literal, intention)
            return
    failure.fail(agent, intention, "test_goal_failed", f"test goal {statement} failed")


def _believe(agent: Agent, intention: Intention, frame: Frame, statement: Believe) -> None:
    literal = statement.ready or instantiate(agent, statement.literal, frame)
    sign = statement.sign
    if sign == "-":
        changed = _delete(agent, intention, frame, literal)
    else:
        if sign == "-+":
            _delete_any(agent, literal)
        changed = agent.believe(literal, None if sign == "++" else intention)
    # A change posts an event that the intention waits for; otherwise it goes on by itself.
    if not changed or sign == "++":
        agent.go_on(intention)


def _delete(agent: Agent, intention: Intention, frame: Frame, literal: Structure) -> bool:
    """Delete the first belief that matches, if any."""
    if literal.ground:
        return agent.disbelieve(literal, intention)
    solution = first(agent, literal, frame.unifier)
    if solution is None:
        return False
    frame.unifier = solution
    found = agent.value(literal, solution)
    return isinstance(found, Structure) and agent.disbelieve(found, intention)


def _delete_any(agent: Agent, literal: Structure) -> None:
    """For ``-+``: delete the first belief of that predicate and these sources, whatever its arguments."""
    for held in agent.beliefs.candidates(literal.key):
        if isinstance(held, Structure) and all(annot in held.annots for annot in literal.annots):
            agent.disbelieve(held if held.annots == literal.annots else held.annotated(literal.annots))
            return


def _act(agent: Agent, intention: Intention, frame: Frame, statement: Act) -> None:
    action = statement.action
    if not isinstance(action, Structure) or not action.ground:
        action = _literal(agent, action, frame.unifier)
    success = agent.run.act(agent.name, action, frame.plan, statement)
    agent.feedback.append((intention, success))


def _internal(agent: Agent, intention: Intention, frame: Frame, statement: Internal) -> None:
    invocation = Invocation(agent, statement.call, frame.unifier, [], intention)
    outcome = call_action(invocation)
    if not isinstance(outcome, bool):
        outcome = next(iter(outcome), None) is not None
    if invocation.held:
        return
    if outcome:
        agent.go_on(intention)
    else:
        failure.fail(agent, intention, "ia_failed", f"{statement} failed", invocation.failure)


def _check(agent: Agent, intention: Intention, frame: Frame, statement: Check) -> None:
    formula = statement.formula
    if isinstance(formula, Comparison):
        holds = compare(agent, formula, frame.unifier, [])
    else:
        solution = first(agent, formula, frame.unifier)
        holds = solution is not None
        if solution is not None:
            frame.unifier = solution
    if holds:
        agent.go_on(intention)
    else:
        failure.fail(agent, intention, "constraint_failed", f"condition {statement} does not hold")


def _if(agent: Agent, intention: Intention, frame: Frame, statement: If) -> None:
    solution = first(agent, statement.condition, frame.unifier)
    if solution is not None:
        frame.unifier = solution
    frame.enter(statement.otherwise if solution is None else statement.then, None)
    _requeue(agent, intention, frame)


def _while(agent: Agent, intention: Intention, frame: Frame, statement: While) -> None:
    loop = _loop(frame, statement, lambda: deque())
    solution = first(agent, statement.condition, loop.outer)
    if solution is None:
        _leave_loop(agent, intention, frame, loop)
    else:
        frame.unifier = dict(solution)
        frame.enter(statement.body, loop)
        _requeue(agent, intention, frame)


def _for(agent: Agent, intention: Intention, frame: Frame, statement: For) -> None:
    # All solutions are found at the start, so that the body may change what they came from.
    loop = _loop(frame, statement, lambda: deque(_solutions(agent, statement.condition, frame.unifier)))
    if loop.solutions:
        frame.unifier = loop.solutions.popleft()
        frame.enter(statement.body, loop)
        _requeue(agent, intention, frame)
    else:
        _leave_loop(agent, intention, frame, loop)


def _solutions(agent: Agent, formula: Formula, bindings: Bindings) -> list[Bindings]:
    return list(solve(agent, formula, bindings))


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


EXECUTE: dict[type, Callable[[Agent, Intention, Frame, Any], None]] = {
    Achieve: _achieve,
    Test: _test,
    Believe: _believe,
    Act: _act,
    Internal: _internal,
    Check: _check,
    If: _if,
    While: _while,
    For: _for,
}
"""How statements are executed, by their class; afterwards the intention is where it belongs: ready, waiting, failed or
ended. They raise an EvaluationError if the statement fails because something in it has no value, and a BdiError if the
run cannot go on."""
