"""Internal actions that say something: messages to other agents, and text to the user."""

from __future__ import annotations

import re

from pytest_hricdv.bdi.actions.registry import MANY, Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.agent.intentions import Question
from pytest_hricdv.bdi.agent.messages import send, text_of
from pytest_hricdv.bdi.language.parser import parse_term
from pytest_hricdv.bdi.language.terms import ListTerm, String, Structure, Term, Variable

_QUESTIONS = frozenset({"askOne", "askAll", "askHow"})


@internal_action("send", 3, 5)
def _send(invocation: Invocation) -> Outcome:
    """``.send(Receiver, Force, Content)``; a question with a fourth argument waits there for its answer.

    For a custom force, the receiver needs plans. The receiver may be a list of agents, whose answers are then
    a list in the order in which they came.
    """
    agent, argument_count = invocation.agent, len(invocation.args)
    to, force = invocation.value(0), text_of(invocation.value(1))
    if argument_count == 3 and type(to) is Structure and not to.args:
        send(agent, to.functor, force, invocation.value(2))
        return True
    receivers = [text_of(item) for item in to.items] if isinstance(to, ListTerm) else [text_of(to)]
    waits = force in _QUESTIONS and argument_count > 3
    reply_to = "" if waits or argument_count == 3 else invocation.text(3)
    content = invocation.value(2)
    names = [send(agent, receiver, force, content, reply_to).name for receiver in receivers]
    if waits and names:
        _wait_for_answers(invocation, force, names, len(receivers) if isinstance(to, ListTerm) else None)
    return True


def _wait_for_answers(invocation: Invocation, force: str, names: list[str], asked: int | None) -> None:
    agent = invocation.agent
    deadline = agent.run.deadline(invocation.number(4)) if len(invocation.args) == 5 else None
    question = Question(invocation.own_intention(), force, invocation.args[3], deadline, asked)
    agent.questions.update(dict.fromkeys(names, question))
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


_EXPRESSION = re.compile(r"#\{([^}]*)\}")


def _text(invocation: Invocation, start: int = 0) -> str:
    """The arguments one after the other; strings without quotes, but only outside of other terms.

    A variable without a value is marked as one, as Jason does.
    """
    return "".join(_shown(invocation.value(index)) for index in range(start, len(invocation.args)))


def _shown(value: Term) -> str:
    if isinstance(value, String):
        return value.value
    return f"{value}<no-value>" if isinstance(value, Variable) else str(value)


@internal_action("print", 0, MANY)
def _print(invocation: Invocation) -> Outcome:
    invocation.agent.run.print(invocation.agent.name, _text(invocation))
    return True


@internal_action("verbose", 1)
def _verbose(invocation: Invocation) -> Outcome:
    """It sets what Jason logs; nothing is logged here."""
    invocation.agent.run.warn(f"{invocation.agent.name}: {invocation.call.location}: ignored: {invocation.call}")
    return True


@internal_action("println", 0, MANY)
def _println(invocation: Invocation) -> Outcome:
    return _print(invocation)


@internal_action("puts", 1, MANY)
def _puts(invocation: Invocation) -> Outcome:
    """As ``.print``, with the values of the expressions in the texts, as in ``"#{X+1} left"``."""
    agent, bindings = invocation.agent, invocation.bindings

    def filled(index: int) -> str:
        value = invocation.value(index)
        text = _shown(value)
        if not isinstance(value, String):
            return text
        return _EXPRESSION.sub(lambda match: _shown(agent.value(invocation.read(match[1], parse_term), bindings)), text)

    agent.run.print(agent.name, "".join(map(filled, range(len(invocation.args)))))
    return True


@internal_action("log", 2, MANY)
def _log(invocation: Invocation) -> Outcome:
    invocation.agent.run.warn(f"{invocation.agent.name}: {_text(invocation, 1)}")
    return True
