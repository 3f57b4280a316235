"""Internal actions on goals and intentions (``.suspend`` ...), which plans call; `internal_action` registers them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.bdi.actions.registry import MANY, Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.failures import drop_goal, fail_goal
from pytest_hricdv.bdi.agent.intentions import TICKS_PER_MS, Event, IntendedMeans, Intention, Outcome
from pytest_hricdv.bdi.language.syntax import AchievementGoal, PlanTrigger, Statement
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import ListTerm, Number, PlanTerm, String, Structure, Term
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import undo, unify


def _pursues(intention: Intention, goal: Term) -> bool:
    """Whether some plan of an intention is for a goal."""
    return any(unify(goal, pursued, dict(means.unifier), []) for means in intention.stack if (pursued := means.goal))


def _concerns(event: Event, goal: Term) -> bool:
    """Whether an event adds a goal, or belongs to an intention that pursues it."""
    return _is_about(event, goal) or (event[2] is not None and _pursues(event[2], goal))


def _is_about(event: Event, goal: Term) -> bool:
    """Whether an event adds a goal."""
    sign, literal, _ = event
    return sign == "+!" and unify(goal, literal, {}, [])


@internal_action("fail", 0, MANY)
def _fail(invocation: Invocation) -> Outcome:
    invocation.failure = tuple(invocation.value(index) for index in range(len(invocation.args)))
    return False


@internal_action("intend", 1, inspects=True)
def _intend(invocation: Invocation) -> Iterator[object]:
    agent = invocation.agent
    intentions = [] if agent.current is None else [agent.current]
    for intention in dict.fromkeys([*intentions, *(other for other, _ in agent.all_intentions())]):
        for means in reversed(intention.stack):
            if (pursued := means.goal) is not None and invocation.unify(0, pursued):
                yield means


@internal_action("desire", 1, inspects=True)
def _desire(invocation: Invocation) -> Iterator[object]:
    for sign, literal, _ in (*invocation.agent.events, *invocation.agent.held_events):
        if sign == "+!" and invocation.unify(0, literal):
            yield literal
    yield from _intend(invocation)  # type: ignore[misc]


def _settle(invocation: Invocation, succeeded: bool) -> bool:
    """End a goal, in every intention that pursues it, as if it had been achieved or had failed."""
    agent, goal = invocation.agent, invocation.literal(0)
    for intention, event in agent.all_intentions():
        waiting = event is not None and _is_about(event, goal)
        if not waiting and not _pursues(intention, goal):
            continue
        agent.remove_intention(intention)
        if event is not None:
            agent.remove_event(event)
        if intention is invocation.intention:
            invocation.held = True
        # Where the goal is further down in the intention as well, the outermost one is settled, and this one with it.
        if not waiting or event is None or _pursues(intention, goal):
            drop_goal(agent, intention, goal, succeeded)
        elif succeeded:
            agent.go_on(intention)
        else:
            fail_goal(agent, intention, "+!", event[1], "", f"goal {goal} was failed")
    return True


@internal_action("succeed_goal", 1, inspects=True)
def _achieve_goal(invocation: Invocation) -> Outcome:
    return _settle(invocation, True)


@internal_action("fail_goal", 1, inspects=True)
def _fail_goal(invocation: Invocation) -> Outcome:
    return _settle(invocation, False)


def _drop(invocation: Invocation, intention: Intention) -> None:
    """Drop an intention, which may be the one that the action is a statement of."""
    invocation.agent.remove_intention(intention)
    invocation.agent.note_end(intention)
    invocation.agent.run.progress += 1
    if intention is invocation.intention:
        invocation.held = True


@internal_action("drop_intention", 0, 1, inspects=True)
def _drop_intention(invocation: Invocation) -> Outcome:
    if not invocation.args:
        _drop(invocation, invocation.own_intention())
        return True
    goal = invocation.literal(0)
    for intention, _ in invocation.agent.all_intentions():
        if _pursues(intention, goal):
            _drop(invocation, intention)
    return True


@internal_action("drop_event", 1, inspects=True)
def _drop_event(invocation: Invocation) -> Outcome:
    agent, goal = invocation.agent, invocation.literal(0)
    for event in [event for event in (*agent.events, *agent.held_events) if _is_about(event, goal)]:
        agent.remove_event(event)
        _, _, intention = event
        if intention is not None:
            agent.note_end(intention)
    return True


@internal_action("drop_desire", 1, inspects=True)
def _drop_desire(invocation: Invocation) -> Outcome:
    _drop_event(invocation)
    return _drop_intention(invocation)


@internal_action("drop_all_events", 0, inspects=True)
def _drop_all_events(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    for _, _, intention in (*agent.events, *agent.held_events):
        if intention is not None:
            agent.note_end(intention)
    agent.events.clear()
    agent.held_events.clear()
    return True


@internal_action("drop_all_intentions", 0, inspects=True)
def _drop_all_intentions(invocation: Invocation) -> Outcome:
    """Drop all intentions but the one this is a statement of."""
    agent = invocation.agent
    for intention, event in agent.all_intentions():
        external = event is not None and event[2] is None
        if intention is not invocation.intention and not external:
            _drop(invocation, intention)
    return True


@internal_action("drop_all_desires", 0, inspects=True)
def _drop_all_desires(invocation: Invocation) -> Outcome:
    _drop_all_events(invocation)
    return _drop_all_intentions(invocation)


@internal_action("suspend", 0, 1, inspects=True)
def _suspend(invocation: Invocation) -> Outcome:
    agent = invocation.agent
    if not invocation.args:
        agent.suspended.append(invocation.own_intention())
        invocation.held = True
        return True
    goal = invocation.literal(0)
    held = [event for event in agent.events if _concerns(event, goal)]
    for event in held:
        agent.events.remove(event)
    agent.held_events += held
    for intention, waiting in agent.all_intentions():
        if waiting is not None or not _pursues(intention, goal) or intention in agent.suspended:
            continue
        if intention is invocation.intention:
            agent.suspended.append(intention)
            invocation.held = True
        elif intention in agent.intentions:
            agent.remove_intention(intention)
            agent.suspended.append(intention)
        elif intention not in agent.suspending:
            agent.suspending.append(intention)
    return True


@internal_action("resume", 1, inspects=True)
def _resume(invocation: Invocation) -> Outcome:
    agent, goal = invocation.agent, invocation.literal(0)
    agent.suspending = [intention for intention in agent.suspending if not _pursues(intention, goal)]
    released = [event for event in agent.held_events if _concerns(event, goal)]
    agent.held_events = [event for event in agent.held_events if event not in released]
    agent.events += released
    agent.run.progress += len(released)
    for intention in [intention for intention in agent.suspended if _pursues(intention, goal)]:
        agent.suspended.remove(intention)
        agent.run.progress += 1
        means = intention.top
        at_suspend = not means.is_finished and str(means.statement).startswith(".suspend")
        if at_suspend:
            agent.go_on(intention)
        else:
            agent.intentions.append(intention)
    return True


@internal_action("suspended", 2, inspects=True)
def _find_suspended_goal(invocation: Invocation) -> Outcome:
    """The second argument is the reason, in the words of Jason 1.4.2: ``suspended-1``, or what it also waits for."""
    agent = invocation.agent
    held = [intention for _, _, intention in agent.held_events if intention is not None]
    for intention in (*agent.suspended, *agent.suspending, *held):
        for means in intention.stack:
            if means.sign == "+!" and invocation.unify(0, means.literal):
                return invocation.unify(1, _reason(agent, intention))
    return False


def _reason(agent: AgentState, intention: Intention) -> Term:
    for wait in agent.waits:
        if wait.intention is intention:
            if wait.trigger is None and wait.condition is None and wait.deadline is not None:
                return String(f"{intention.number}/time{Number((wait.deadline - wait.since) / TICKS_PER_MS)}")
            return String(f"{intention.number}/{wait.trigger or wait.condition}")
    by_itself = intention in agent.suspended and str(intention.top.statement) == ".suspend"
    return String(f"suspended-{'self-' if by_itself else ''}{intention.number}")


@internal_action("current_intention", 1, inspects=True)
def _current_intention(invocation: Invocation) -> Outcome:
    """``intention(Number, [im(Label, {Event}, {what is left of the plan}, [map(Variable, Value), ...]), ...])``.

    The plan being executed is the first.
    """
    intention = invocation.own_intention()
    means = tuple(_means_term(invocation.agent, means) for means in reversed(intention.stack))
    return invocation.unify(0, Structure("intention", (Number(intention.number), ListTerm(means))))


def _means_term(agent: AgentState, means: IntendedMeans) -> Structure:
    plan = means.plan
    event = PlanTerm(
        replace(plan, label="_plan", trigger=PlanTrigger(means.sign, means.literal), context=None, body=())
    )
    # The names of variables are texts: as variables they would be those of the plan that asks.
    values = sorted((str(name), agent.value(value, means.unifier)) for name, value in means.unifier.items())
    maps = tuple(Structure("map", (String(name), value)) for name, value in values)
    label = Structure(plan.label).with_annotations(plan.annots)
    return Structure("im", (label, event, _rest(agent, means), ListTerm(maps)))


def _rest(agent: AgentState, means: IntendedMeans) -> Term:
    """The rest of a plan, as a term whose free variables occur nowhere else."""
    rest = PlanTerm(means.body[means.pc :])
    own: Bindings = {name: agent.fresh() for name in variables_of(rest) if name not in means.unifier}
    return agent.value(rest, means.unifier | own)


@internal_action("done", 0, 1, inspects=True)
def _finish_own_goal(invocation: Invocation) -> Outcome:
    """End a goal of the intention that this is a statement of, as if it had been achieved; without one, its own."""
    agent, intention = invocation.agent, invocation.own_intention()
    goal = invocation.literal(0) if invocation.args else intention.top.literal
    if _pursues(intention, goal):
        invocation.held = True
        drop_goal(agent, intention, goal, True)
    return True


@internal_action("drop_future_intention", 1, inspects=True)
def _drop_future_intention(invocation: Invocation) -> Outcome:
    """Drop the intentions whose plan is going to pursue a goal."""
    _drop_event(invocation)
    goal = invocation.literal(0)
    for intention, _ in invocation.agent.all_intentions():
        if intention.stack and any(_adopts(statement, goal, intention.top) for statement in _rest_of(intention.top)):
            _drop(invocation, intention)
    return True


def _rest_of(means: IntendedMeans) -> tuple[Statement, ...]:
    return means.body[means.pc :]


def _adopts(statement: Statement, goal: Term, means: IntendedMeans) -> bool:
    return isinstance(statement, AchievementGoal) and unify(goal, statement.literal, dict(means.unifier), [])


@internal_action("intention", 2, 4, inspects=True)
def _intention(invocation: Invocation) -> Iterator[object]:
    """``.intention(Number, State)``, ``.intention(Number, State, Plans)``; with ``current`` fourth, this one only."""
    agent = invocation.agent
    only_current = len(invocation.args) == 4 and invocation.text(3) == "current"
    intentions = [agent.current] if agent.current is not None else []
    intentions += [] if only_current else [intention for intention, _ in agent.all_intentions()]
    for intention in dict.fromkeys(intentions):
        if not intention.stack:
            continue
        mark = len(invocation.trail)
        values: list[Term] = [Number(intention.number), _state(agent, intention)]
        if len(invocation.args) > 2:
            values.append(ListTerm(tuple(_means_term(agent, means) for means in reversed(intention.stack))))
        if all(invocation.unify(index, value) for index, value in enumerate(values)):
            yield intention
        undo(invocation.bindings, invocation.trail, mark)


def _state(agent: AgentState, intention: Intention) -> Structure:
    """As in Jason 3.3: ``running``, ``suspended``, or ``waiting`` with what it waits for."""
    if intention in agent.suspended or intention in agent.suspending:
        return Structure("suspended")
    for wait in agent.waits:
        if wait.intention is intention:
            awaited: Term = String(str(wait.trigger or wait.condition))
            if wait.trigger is None and wait.condition is None and wait.deadline is not None:
                awaited = Structure("time", (Number((wait.deadline - wait.since) / TICKS_PER_MS),))
            reason = Structure("wait", (Number(intention.number),), (awaited,))
            return Structure("waiting", (), (Structure("reason", (reason,)),))
    asks = any(question.intention is intention for question in agent.questions.values())
    return Structure("waiting" if asks else "running")
