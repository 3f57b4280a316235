"""`snapshot` gives an agent's mental state as a hashable value; `restore` puts the agent back into this state.

`RecordingRun` takes the snapshots at the end of each segment; the memo's nodes (`StateNode`) hold them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable
from typing import Any, NamedTuple

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import IntendedMeans, Intention, LoopState, PendingWait, SpeechAct
from pytest_hricdv.bdi.language.terms import Key
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, Entry
from pytest_hricdv.bdi.logic.substitution import Bindings


class AgentSnapshot(NamedTuple):
    """Everything that determines the agent's next step, between two rounds; all parts can be hashed.

    Args:
        beliefs: the beliefs and rules of each predicate; empty for a predicate that certainly has none.
        mailbox: the messages, without their numbers.
        events: sign and literal, and the intention that waits for it.
        feedback: the intentions whose action has been executed, and its success.
        intentions: those that are ready.
        waits: the intentions that wait, since and for how many ticks, and for what.
    """

    beliefs: frozenset[tuple[Key, tuple[Entry, ...]]]
    mailbox: tuple[Any, ...]
    events: tuple[Any, ...]
    feedback: tuple[Any, ...]
    intentions: tuple[Any, ...]
    waits: tuple[Any, ...]


class _Identity:
    """An object that is equal to itself only: plans and bodies are compared by identity, which is fast."""

    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Identity) and self.value is other.value

    def __hash__(self) -> int:
        return id(self.value)


def snapshot(agent: Agent, now: int) -> AgentSnapshot | None:
    """The state of an agent at a tick of the virtual clock; None if it cannot be compared with others."""
    if agent.awaits_goals:
        return None  # rare, as what follows
    if (
        agent.questions
        or agent.deadlines
        or agent.woken
        or agent.suspended
        or agent.held_events
        or agent.suspending
        or agent.forked
    ):
        return None  # rare; and questions go by the numbers of messages, which are different in every run
    return AgentSnapshot(
        frozenset(agent.beliefs.content()),
        tuple([(message.sender, message.force, message.content, message.reply_to) for message in agent.mailbox]),
        tuple([(sign, literal, _intention_state(agent, waiting)) for sign, literal, waiting in agent.events]),
        tuple([(_intention_state(agent, intention), success) for intention, success in agent.feedback]),
        tuple([_intention_state(agent, intention) for intention in agent.intentions]),
        tuple([_wait_state(agent, wait, now) for wait in agent.waits]),
    )


def restore(agent: Agent, state: AgentSnapshot, beliefs: BeliefBase) -> None:
    """Put an agent that has not begun yet into a state, with these beliefs."""
    now = agent.run.ticks
    agent.beliefs = beliefs
    agent.mailbox = deque(
        SpeechAct(sender, force, content, 0, reply) for sender, force, content, reply in state.mailbox
    )
    agent.events = deque((sign, literal, _intention(agent, waiting)) for sign, literal, waiting in state.events)
    agent.feedback = deque((_intention(agent, intention), success) for intention, success in state.feedback)
    agent.intentions = deque(_intention(agent, intention) for intention in state.intentions)
    for intention, elapsed, left, *awaited in state.waits:
        deadline = None if left is None else now + left
        agent.waits.append(PendingWait(_intention(agent, intention), now - elapsed, deadline, *awaited))
        if deadline is not None:
            agent.run.note_deadline(deadline)
    agent.note_restored()


def _wait_state(agent: Agent, wait: PendingWait, now: int) -> tuple[Hashable, ...]:
    left = None if wait.deadline is None else wait.deadline - now
    intention = _intention_state(agent, wait.intention)
    return intention, now - wait.since, left, wait.trigger, wait.condition, wait.elapsed


def _intention_state(agent: Agent, intention: Intention | None) -> Hashable:
    if intention is None:
        return None
    return agent.atomic is intention, tuple([_means_state(means) for means in intention.stack])


def _intention(agent: Agent, state: Any) -> Any:
    if state is None:
        return None
    atomic, stack = state
    intention = agent.new_intention()
    intention.stack = [_means(means) for means in stack]
    if atomic:
        agent.atomic = intention
    return intention


def _means_state(means: IntendedMeans) -> tuple[Hashable, ...]:
    blocks = tuple([(_Identity(body), pc, _loop_state(loop)) for body, pc, loop in means.blocks])
    at = _Identity(means.body), means.pc, blocks, _loop_state(means.loop)
    return _Identity(means.plan), means.sign, means.literal, tuple(means.unifier.items()), *at


def _means(state: Any) -> IntendedMeans:
    plan, sign, literal, unifier, body, pc, blocks, loop = state
    means = IntendedMeans(plan.value, sign, literal, dict(unifier))
    means.body, means.pc, means.loop = body.value, pc, _loop(loop)
    means.blocks = [(outer.value, outer_pc, _loop(outer_loop)) for outer, outer_pc, outer_loop in blocks]
    return means


def _loop_state(loop: LoopState | None) -> Hashable:
    if loop is None:
        return None
    solutions = tuple([tuple(solution.items()) for solution in loop.solutions])
    return _Identity(loop.statement), tuple(loop.outer.items()), solutions


def _loop(state: Any) -> LoopState | None:
    if state is None:
        return None
    statement, outer, solutions = state
    return LoopState(statement.value, dict(outer), deque(_bindings(solution) for solution in solutions))


def _bindings(items: Any) -> Bindings:
    return dict(items)
