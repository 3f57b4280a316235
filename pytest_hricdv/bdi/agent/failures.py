"""Plan failure: `fail` looks for a plan that handles the failure of a statement.

`Agent` calls it, and so do the functions of `statements` and `messages`. A failed goal ``+!g`` is handled by the
nearest plan for ``-!g``: its own, or that of a goal below it in the intention. As in Jason, a failure in the body of
a handling plan or of what it calls, or directly in the body of a plan for a belief event, is not handled: the
intention is dropped with a warning, and the agent continues.
"""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.intentions import ADDED_GOALS, Event, HardDeadline, IntendedMeans, Intention
from pytest_hricdv.bdi.language.errors import BdiError, Location
from pytest_hricdv.bdi.language.syntax import GOAL_STATE, Comparison, ConditionStatement, InternalActionCall, TestGoal
from pytest_hricdv.bdi.language.terms import Number, String, Structure, Term, Variable
from pytest_hricdv.bdi.logic.unify import unify

_MESSAGE = (False, "error_msg", 1)
_HARD_DEADLINE = (False, "hard_deadline", 1)
_NO_CODE = Structure("no_code")


def fail(agent: AgentState, intention: Intention, error: str, message: str, extra: tuple[Term, ...] = ()) -> None:
    """Handle the failure of the current statement of an intention.

    Args:
        intention: the intention, which no queue of the agent holds any more.
        error: Jason's name for the kind of failure, the value of the annotation ``error``.
        extra: annotations for the failure event.
    """
    means = intention.stack[-1]
    statement = None if means.is_finished else means.statement
    place = means.plan.location if statement is None else statement.location
    annots: tuple[Structure, ...] = (
        Structure("error", (Structure(error),)),
        Structure("error_msg", (String(_error_message(error, message, means)),)),
        Structure("code", (_code(agent, means),)),
        *_place(place),
    )
    # An `error(...)` of its own is one more, as in Jason: a plan that asks for it by name is applicable, too.
    replaced = {annot.functor for annot in extra if isinstance(annot, Structure)} - {"error"}
    annots = tuple(annot for annot in annots if annot.functor not in replaced)
    if means.sign in ADDED_GOALS:
        _note_failed(agent, means.sign, means.literal)
        if _handle(agent, intention, len(intention.stack) - 1, annots + extra):
            return
    goal = f"{means.sign}{means.literal.without_annotations()}"
    agent.run.warn(f"{agent.name}: {place}: {message}: no failure plan, the intention of {goal} is dropped")
    agent.note_end(intention)


def _note_failed(agent: AgentState, sign: str, goal: Structure) -> None:
    if sign == "+!" and (agent.library.follows_goals or agent.awaits_goals):
        agent.note_goal(goal, "failed")


def _error_message(error: str, message: str, means: IntendedMeans) -> str:
    """The error message that a plan for the failure gets: Jason's, where that is known."""
    if error in ("ia_failed", "action_failed", "unknown"):  # Jason's is empty for these
        return ""
    if error == "test_goal_failed":
        return f"Failed to test '{'; '.join(map(str, means.body[means.pc :]))}'"
    return message


def _code(agent: AgentState, means: IntendedMeans) -> Term:
    """The next statement of a plan, as a term if it is one, else as text."""
    statement = None if means.is_finished else means.statement
    if isinstance(statement, InternalActionCall):
        # Not a call, which would be evaluated as a function.
        done: object = Structure(statement.call.name, statement.call.args)  # type: ignore[arg-type]
    else:
        done = getattr(statement, "literal", None) or getattr(statement, "action", None)
        done = statement.formula if isinstance(statement, TestGoal) else done
    try:
        if isinstance(done, (Structure, Variable)):
            return agent.value(done, means.unifier)
        if isinstance(statement, ConditionStatement) and isinstance(statement.formula, Comparison):
            left, right = (
                agent.value(side, means.unifier) for side in (statement.formula.left, statement.formula.right)
            )
            return String(f"({left} {statement.formula.operator} {right})")
    except (BdiError, AttributeError):
        pass  # Its arguments have no value, or are conditions: it is shown as written.
    return String(str(statement))


def _place(place: Location | None) -> tuple[Structure, ...]:
    """Where that is written; ``no_code`` for what no plan's body asked for."""
    if place is None:
        return (Structure("code_src", (_NO_CODE,)), Structure("code_line", (_NO_CODE,)))
    return (Structure("code_src", (String(Path(place.file).name),)), Structure("code_line", (Number(place.line),)))


def no_applicable_plan(agent: AgentState, event: Event) -> bool:
    """No plan is applicable for a goal, which fails, or for a belief event that no intention waits for: it is skipped.

    Returns:
        Whether that was all for this cycle; if not, another event is selected.
    """
    sign, literal, intention = event
    if len(sign) == 1 or sign == GOAL_STATE:
        return False
    if sign in ADDED_GOALS:
        has_relevant_plan = bool(agent.library.relevant(sign, literal.key))
        error = "no_applicable" if has_relevant_plan else "no_relevant"
        kind = "applicable" if has_relevant_plan else "relevant"
        message = f"no {kind} plan for {sign}{literal.without_annotations()}"
        text = f"Found a goal for which there is no {kind} plan:{sign}{literal}"
        fail_goal(agent, intention or agent.new_intention(), sign, literal, error, message, text)
    else:
        event_text = f"{sign}{literal.without_annotations()}{_reason(literal)}"
        agent.run.warn(f"{agent.name}: no applicable plan for {event_text}: the intention is dropped")
        if intention is not None:
            agent.note_end(intention)
    return True


def _reason(literal: Structure) -> str:
    """The reason of a failure, if the literal is that of one."""
    texts = [annot.args[0] for annot in literal.annots if isinstance(annot, Structure) and annot.key == _MESSAGE]
    return f" ({texts[0].value})" if texts and isinstance(texts[0], String) and texts[0].value else ""


def fail_goal(
    agent: AgentState, intention: Intention, sign: str, literal: Structure, error: str, message: str, text: str = ""
) -> None:
    """Handle the failure of a goal that has no plan on the intention, or none any more.

    Args:
        agent: the agent whose goal it is.
        intention: the intention, taken out of whatever it was in.
        sign: the sign of the goal's event.
        error: Jason's name for the kind of failure; empty if a plan for it is not told of any, as by ``.fail_goal``.
        text: the message that a plan for the failure gets, if it is a different one.
    """
    annots: tuple[Term, ...] = ()
    if error:
        annots = (
            Structure("error", (Structure(error),)),
            Structure("error_msg", (String(text or message),)),
            Structure("code", (literal,)),
            *_place(intention.stack[-1].statement.location if intention.stack else None),
        )
    _note_failed(agent, sign, literal)
    handler = "-" + sign[1]
    if agent.library.relevant(handler, literal.key):
        _post(agent, handler, literal, annots, intention)
    elif not _handle(agent, intention, len(intention.stack) - 1, annots):
        agent.run.warn(f"{agent.name}: {message}: no failure plan, the intention is dropped")
        agent.note_end(intention)


def _handle(agent: AgentState, intention: Intention, start: int, annots: tuple[Term, ...]) -> bool:
    """Post the failure event of the topmost goal that has a plan for it; its plans so far are given up."""
    stack = intention.stack
    for depth in range(start, -1, -1):  # the innermost goal first
        means = stack[depth]
        if intention.branch_of is not None and depth < intention.branch_of.depth and _gives_up_branch(agent, intention):
            return True
        handler = "-" + means.sign[1:]
        if agent.library.relevant(handler, means.literal.key):
            # A plan for a failure, or for a belief that can also be lost, ends the search.
            if means.sign not in ADDED_GOALS:
                return False
            literal = means.literal
            agent.leave_fork(intention, depth)
            del stack[depth:]
            _post(agent, handler, literal, annots, intention)
            return True
    return False


def _gives_up_branch(agent: AgentState, branch: Intention) -> bool:
    """Whether a failed branch is of a disjunction (`|||`), whose other branches continue.

    As in Jason, the intention ends with the last branch, without a failure event.
    """
    forked = branch.branch_of
    if forked is None or forked.needs_all:
        return False
    forked.branches.remove(branch)
    agent.run.progress += 1
    if not forked.branches:
        goal = forked.intention.top
        agent.run.warn(
            f"{agent.name}: {goal.statement.location}: all branches of {goal.statement} have failed: the intention "
            f"of {goal.sign}{goal.literal.without_annotations()} is dropped"
        )
        agent.forked.remove(forked)
        agent.note_end(forked.intention)
    return True


def _post(agent: AgentState, sign: str, literal: Structure, annots: tuple[Term, ...], intention: Intention) -> None:
    agent.run.progress += 1
    agent.post(sign, literal.with_annotations(literal.annots + annots), intention)


def note_deadline(agent: AgentState, goal: Structure) -> Structure:
    """Make a goal that is being posted fail at its ``hard_deadline(Ms)``, if it has one.

    Returns:
        The goal to be posted: its own object, by which it is told from equal ones.
    """
    for annot in goal.annots:
        if isinstance(annot, Structure) and annot.key == _HARD_DEADLINE:
            if not isinstance(annot.args[0], Number):
                agent.run.warn(f"{agent.name}: the deadline of !{goal} is not a number of milliseconds: it has none")
                continue
            own = goal.with_annotations(goal.annots)
            deadline = agent.run.deadline(annot.args[0])
            agent.run.note_deadline(deadline)
            agent.deadlines.append(HardDeadline(own, deadline))
            return own
    return goal


def end_deadlines(agent: AgentState, now: int) -> None:
    """Fail the goals whose deadline is over at a tick of the virtual clock."""
    over = [goal for goal in agent.deadlines if goal.deadline <= now]
    agent.deadlines = [goal for goal in agent.deadlines if goal.deadline > now]
    for reached in sorted(over, key=lambda goal: goal.deadline):
        for intention, event in agent.all_intentions():
            if _reach_deadline(agent, intention, event, reached.goal):
                break


def _reach_deadline(agent: AgentState, intention: Intention, event: Event | None, goal: Structure) -> bool:
    """Fail the goal if the intention is pursuing it, or is going to."""
    depth = next((depth for depth, means in enumerate(intention.stack) if means.literal is goal), None)
    if depth is None and (event is None or event[1] is not goal):
        return False
    agent.remove_intention(intention)
    if event is not None:
        agent.remove_event(event)
    if depth is not None:
        agent.leave_fork(intention, depth)
        del intention.stack[depth:]
    fail_goal(agent, intention, "+!", goal, "deadline_reached", f"the hard deadline of {goal} is over")
    return True


def drop_goal(agent: AgentState, intention: Intention, goal: Term, succeeded: bool) -> bool:
    """Give up, or declare achieved, a goal that an intention is pursuing.

    Args:
        agent: the agent whose intention it is.
        intention: the intention, taken out of whatever it was in.
        goal: what the goal has to unify with.
        succeeded: whether the intention continues as if the goal were achieved, or as if it had failed.

    Returns:
        Whether the intention was pursuing it.
    """
    stack = intention.stack
    for depth, means in enumerate(stack):
        pursued = means.goal
        if pursued is not None and unify(goal, pursued, dict(means.unifier), []):
            agent.leave_fork(intention, depth)
            del stack[depth:]
            if succeeded:
                agent.go_on(intention)
            elif means.sign == "+!" or not _handle(agent, intention, depth - 1, ()):
                fail_goal(agent, intention, "+!", pursued, "", f"goal {goal} was failed")
            return True
    return False
