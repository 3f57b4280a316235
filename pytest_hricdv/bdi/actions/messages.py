"""``.send`` and ``.broadcast``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.terms import Call, ListTerm, Structure, is_name

from ..communication import send, text_of, with_source
from ..intentions import Frame, Intention, Message, Question
from ..values import Value, value_of
from .registry import Invocation, Outcome, internal_action, prepared

if TYPE_CHECKING:
    from ..agent import Agent
    from ..execution import Step

_QUESTIONS = frozenset({"askOne", "askAll", "askHow"})


@internal_action("send", 3, 5)
def _send(invocation: Invocation) -> Outcome:
    """``.send(Receiver, Force, Content)``; a question with a fourth argument waits there for its answer.

    For a force of one's own, the receiver needs plans. The receiver may be a list of agents, whose answers are then
    a list in the order in which they came.
    """
    to, force = invocation.value(0), text_of(invocation.value(1))
    receivers = [text_of(item) for item in to.items] if isinstance(to, ListTerm) else [text_of(to)]
    waits = force in _QUESTIONS and len(invocation) > 3
    reply_to = "" if waits or len(invocation) == 3 else invocation.text(3)
    content = invocation.value(2)
    numbers = [send(invocation.agent, receiver, force, content, reply_to) for receiver in receivers]
    if waits and numbers:
        _wait_for_answers(invocation, force, numbers, len(receivers) if isinstance(to, ListTerm) else None)
    return True


@prepared("send")
def _prepared_send(call: Call, otherwise: Step) -> Step:
    """To one agent, without waiting for an answer."""
    if len(call.args) != 3 or not all(map(is_name, call.args[:2])):  # type: ignore[arg-type]
        return otherwise
    receiver, force = (arg.functor for arg in call.args[:2])  # type: ignore[attr-defined]
    what = call.args[2]
    if receiver == "self":
        return otherwise
    if isinstance(what, Structure) and what.ground:
        return _known_send(receiver, force, what, otherwise)
    content = value_of(what)  # type: ignore[arg-type]
    return otherwise if content is None else _computed_send(receiver, force, content, otherwise)


def _known_send(receiver: str, force: str, what: Structure, otherwise: Step) -> Step:
    """With the same content every time."""
    sourced: dict[str, Structure] = {}

    def step(agent: Agent, intention: Intention, frame: Frame) -> bool | None:
        run = agent.run
        to = run.agents.get(receiver)
        if to is None:
            return otherwise(agent, intention, frame)
        sender = "self" if to is agent else agent.name
        literal = sourced.get(sender)
        if literal is None:
            literal = sourced[sender] = with_source(what, sender)
        run.deliver(to, Message(sender, force, what, run.next_message_number(), "", literal))
        agent.disturbed = True
        return True

    return step


def _computed_send(receiver: str, force: str, content: Value, otherwise: Step) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool | None:
        run = agent.run
        to, what = run.agents.get(receiver), content(frame.unifier)
        if to is None or what is None:
            return otherwise(agent, intention, frame)
        sender = "self" if to is agent else agent.name
        run.deliver(to, Message(sender, force, what, run.next_message_number()))
        agent.disturbed = True
        return True

    return step


def _wait_for_answers(invocation: Invocation, force: str, numbers: list[str], asked: int | None) -> None:
    agent = invocation.agent
    deadline = agent.run.after(invocation.number(4)) if len(invocation) == 5 else None
    question = Question(invocation.own_intention(), force, invocation.args[3], deadline, asked)
    agent.questions.update(dict.fromkeys(numbers, question))
    if deadline is not None:
        agent.run.note_deadline(deadline)
    invocation.held = True


@internal_action("broadcast", 2)
def _broadcast(invocation: Invocation) -> Outcome:
    force, content = text_of(invocation.value(0)), invocation.value(1)
    for name in invocation.agent.run.agents:
        if name != invocation.agent.name:
            send(invocation.agent, name, force, content)
    return True
