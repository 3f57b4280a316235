"""Executes the statements in the bodies of plans: `EXECUTE` has a function for each class of statement.

`Agent.execute` calls it with the agent, the intention, the plan on top of that intention with its bindings
(`IntendedMeans`), and the statement.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.failures import fail, note_deadline
from pytest_hricdv.bdi.agent.intentions import ForkedIntention, IntendedMeans, Intention, LoopState
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.limits import limit_answers
from pytest_hricdv.bdi.language.syntax import (
    AchievementGoal,
    BeliefUpdate,
    ConditionStatement,
    ExternalAction,
    For,
    ForkStatement,
    GoalTerm,
    If,
    InternalActionCall,
    Rule,
    TestGoal,
    While,
)
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import (
    SOURCE_SELF,
    AnnotatedVariable,
    PlanTerm,
    QualifiedLiteral,
    Structure,
    Variable,
)
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute_all

_VARIABLES = (Variable, AnnotatedVariable)


def _achieve(agent: AgentState, intention: Intention, means: IntendedMeans, statement: AchievementGoal) -> None:
    goal = statement.event_literal or instantiate(agent, statement.literal, means)
    if len(goal.annots) > 1:  # more than its source, as few have
        goal = note_deadline(agent, goal)
    if statement.new_intention:
        agent.post_goal(goal)
        agent.go_on(intention)
    else:
        agent.post("+!", goal, intention)


def _test(agent: AgentState, intention: Intention, means: IntendedMeans, statement: TestGoal) -> None:
    formula = statement.formula
    if isinstance(formula, _VARIABLES) and isinstance(agent.value(formula, means.unifier), _VARIABLES):
        place = f"{Path(statement.location.file).name}:{statement.location.line}"
        raise EvaluationError(f"{place}: Variable '{formula}' must be ground.", "body_var_without_value")
    solution = first(agent, formula, means.unifier)
    if solution is not None:
        means.unifier = solution
        agent.go_on(intention)
        return
    if isinstance(formula, QualifiedLiteral) and not isinstance(agent.value(formula, means.unifier), Structure):
        fail(agent, intention, "test_goal_failed", f"test goal {statement} failed")
        return
    if isinstance(formula, GoalTerm):
        literal = instantiate(agent, formula, means)
        if agent.library.relevant("+?", literal.key):
            agent.post("+?", literal, intention)
            return
    fail(agent, intention, "test_goal_failed", f"test goal {statement} failed")


def _act(agent: AgentState, intention: Intention, means: IntendedMeans, statement: ExternalAction) -> None:
    written = statement.action
    if type(written) is Variable:
        value = agent.value(written, means.unifier)
        if isinstance(value, PlanTerm) and isinstance(value.plan, tuple):
            # A variable may stand for a body, which is executed instead.
            means.enter(value.plan, None)
            if value.plan:
                EXECUTE[type(means.statement)](agent, intention, means, means.statement)
            else:
                agent.requeue(intention)
            return
    is_ground = isinstance(written, Structure) and written.ground
    action: Any = written if is_ground else literal_of(agent, written, means.unifier)
    success = agent.run.act(agent.name, action, means.plan, statement)
    agent.feedback.append((intention, success))


def _internal(agent: AgentState, intention: Intention, means: IntendedMeans, statement: InternalActionCall) -> None:
    succeeded, held, failure = agent.actions.execute(agent, statement.call, means.unifier, intention)
    if held:
        return
    if succeeded:
        agent.go_on(intention)
    else:
        # As in Jason, where `.fail` with annotations raises an error, and `.fail` without is an action that failed.
        fail(agent, intention, "internal_action" if failure else "ia_failed", f"{statement} failed", failure)


def _check(agent: AgentState, intention: Intention, means: IntendedMeans, statement: ConditionStatement) -> None:
    solution = first(agent, statement.formula, means.unifier)
    if solution is None:
        fail(agent, intention, "constraint_failed", f"condition {statement} does not hold")
    else:
        means.unifier = solution
        agent.go_on(intention)


def _update_beliefs(agent: AgentState, intention: Intention, means: IntendedMeans, statement: BeliefUpdate) -> None:
    """A change posts an event that the intention waits for; without one, or for ``++``, the intention continues."""
    literal = statement.event_literal
    if literal is None:
        if (rule := _rule_of(agent, statement.literal, means)) is not None:
            _update_rules(agent, statement, rule)
            agent.go_on(intention)
            return
        literal = instantiate(agent, statement.literal, means)
    changed: Structure | None = None
    if statement.sign == "++":
        agent.believe(literal)
    elif statement.sign == "-":
        deleted = literal if literal.ground else _first_match(agent, means, literal)
        if deleted is not None and agent.beliefs.remove(deleted):
            changed = deleted
    else:
        if statement.sign == "-+":
            _remove_first(agent, literal)
        changed = agent.beliefs.add(literal)
    if changed is None:
        agent.go_on(intention)
    else:
        agent.run.progress += 1
        agent.post("-" if statement.sign == "-" else "+", changed, intention)


def _rule_of(agent: AgentState, written: object, means: IntendedMeans) -> Rule | None:
    """The rule that an update is of, ``+{ a(X) :- b(X) }``, or ``+R`` for a variable with such a value."""
    if not isinstance(written, (Variable, PlanTerm)):
        return None
    value = agent.value(written, means.unifier)
    if not isinstance(value, PlanTerm) or not isinstance(value.plan, Rule):
        return None
    return replace(value.plan, variables=tuple(sorted(variables_of(value.plan))))


def _update_rules(agent: AgentState, statement: BeliefUpdate, rule: Rule) -> None:
    if statement.sign not in ("+", "-"):
        raise EvaluationError(f"{statement}: a rule is added with + and removed with -")
    if statement.sign == "+":
        agent.beliefs.add_rule(rule)
    else:
        agent.beliefs.remove_rule(rule)
    agent.run.progress += 1


def _first_match(agent: AgentState, means: IntendedMeans, literal: Structure) -> Structure | None:
    """The literal with the first solution's values; None if there is no solution."""
    solution = first(agent, literal, means.unifier)
    if solution is None:
        return None
    means.unifier = solution
    value = agent.value(literal, solution)
    return value if isinstance(value, Structure) else None


def _remove_first(agent: AgentState, literal: Structure) -> None:
    """Delete the first belief of that predicate and these sources, whatever its arguments."""
    annots = literal.annots
    # The iteration ends with the deletion.
    for held in reversed(agent.beliefs.bucket(literal.key).values()):
        if not isinstance(held, Structure):
            continue
        if held.annots == annots:
            agent.disbelieve(held)
            return
        if all(annot in held.annots for annot in annots):
            agent.disbelieve(held.with_annotations(annots))
            return


def instantiate(agent: AgentState, term: GoalTerm | PlanTerm, means: IntendedMeans) -> Structure:
    """A literal as it leaves its plan: bound, with a source, its free variables replaced by new ones.

    Raises:
        EvaluationError: it is not a literal, or an expression in it has no value.
    """
    if isinstance(term, Structure) and not term.annots and term.annots_tail is None:
        # Most literals: with the source from the beginning.
        args = substitute_all(term.args, means.unifier, agent.function)
        literal = Structure(term.functor, args, (SOURCE_SELF,), term.negated)
        if literal.ground:
            return literal
    else:
        literal = literal_of(agent, term, means.unifier)
    if not literal.ground:
        for variable in free_variables(literal):
            # Another plan may have a variable of this name; one that is fresh already is known by its name here.
            if not agent.run.is_fresh(variable):
                means.unifier[variable] = agent.fresh()
        literal = literal_of(agent, literal, means.unifier)
    return literal.with_own_source()


def literal_of(agent: AgentState, term: GoalTerm | PlanTerm, bindings: Bindings) -> Structure:
    """A literal with the variables replaced that are bound.

    Raises:
        EvaluationError: it is not a literal, or an expression in it has no value.
    """
    literal = agent.value(term, bindings)
    if isinstance(literal, Variable):
        raise EvaluationError(f"variable {literal} has no value here", "body_var_without_value")
    if isinstance(literal, QualifiedLiteral):
        raise EvaluationError(f"namespace {literal.space} has no value here", "body_var_without_value")
    if not isinstance(literal, Structure):
        raise EvaluationError(f"{term} is not a literal but {literal}")
    return literal


def _if(agent: AgentState, intention: Intention, means: IntendedMeans, statement: If) -> None:
    """Enter one block or the other."""
    solution = first(agent, statement.condition, means.unifier)
    if solution is not None:
        means.unifier = solution
    means.enter(statement.otherwise if solution is None else statement.then, None)
    agent.requeue(intention)


def _while(agent: AgentState, intention: Intention, means: IntendedMeans, statement: While) -> None:
    """Enter the block again if the condition holds, or leave the loop."""
    # `means.loop` says that this is not the first iteration; it is taken away, for the body may have a loop of its own.
    loop, means.loop = means.loop or LoopState(statement, means.unifier, deque()), None
    # Bindings of the last iteration are dropped.
    solution = first(agent, statement.condition, loop.outer)
    if solution is None:
        _leave_loop(agent, intention, means, loop)
    else:
        means.unifier = dict(solution)
        means.enter(statement.body, loop)
        agent.requeue(intention)


def _for(agent: AgentState, intention: Intention, means: IntendedMeans, statement: For) -> None:
    """Enter the block with the next solution, or leave the loop.

    All solutions are found at the start, so that the body may change the beliefs that they came from.
    """
    loop, means.loop = means.loop, None
    if loop is None:
        loop = LoopState(
            statement, means.unifier, deque(limit_answers(solve(agent, statement.condition, means.unifier)))
        )
    if loop.solutions:
        means.unifier = loop.solutions.popleft()
        means.enter(statement.body, loop)
        agent.requeue(intention)
    else:
        _leave_loop(agent, intention, means, loop)


def _leave_loop(agent: AgentState, intention: Intention, means: IntendedMeans, loop: LoopState) -> None:
    """Drop the bindings made in a loop after it."""
    means.unifier = loop.outer
    agent.go_on(intention)


def _fork(agent: AgentState, intention: Intention, means: IntendedMeans, statement: ForkStatement) -> None:
    """Start an intention for each branch; this one continues when they are done."""
    if intention.atomic:
        raise EvaluationError(f"{statement}: an atomic plan has no statements side by side")
    forked = ForkedIntention(intention, statement.needs_all)
    for body in statement.branches:
        branch = agent.new_intention()
        branch.branch_of = forked
        branch.stack = [below.copy() for below in intention.stack]
        branch.top.body, branch.top.pc, branch.top.blocks, branch.top.loop = body, 0, [], None
        forked.branches.append(branch)
        agent.intentions.append(branch)
    agent.forked.append(forked)


EXECUTE: dict[type, Callable[[AgentState, Intention, IntendedMeans, Any], None]] = {
    AchievementGoal: _achieve,
    TestGoal: _test,
    BeliefUpdate: _update_beliefs,
    ExternalAction: _act,
    InternalActionCall: _internal,
    ConditionStatement: _check,
    If: _if,
    While: _while,
    For: _for,
    ForkStatement: _fork,
}
"""Executes a statement that an intention is at; afterwards the intention is queued, waiting, failed or ended.

Raises an EvaluationError if the statement fails because something in it has no value, and a BdiError if the run cannot
continue."""
