"""Internal actions on other agents and output (``.send`` ...), which plans call; `internal_action` registers them."""

from __future__ import annotations

import re

from pytest_hricdv.bdi.actions.registry import MANY, Invocation, internal_action
from pytest_hricdv.bdi.agent.directory import DIRECTORY
from pytest_hricdv.bdi.agent.intentions import Outcome, PendingQuestion, SpeechAct
from pytest_hricdv.bdi.agent.messages import send, text_of
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.syntax import And, Comparison, Not, Or
from pytest_hricdv.bdi.language.terms import (
    FormulaTerm,
    ListTerm,
    Number,
    String,
    Structure,
    Term,
    Variable,
    is_name,
    render,
)

_QUESTIONS = frozenset({"askOne", "askAll", "askHow"})
"""The forces (kinds of messages) that ask for an answer."""


@internal_action("send", 3, 5)
def _send(invocation: Invocation) -> Outcome:
    """``.send(Receiver, Force, Content)``; a question with a fourth argument waits there for its answer.

    For a custom force, the receiver needs plans. The receiver may be a list of agents, whose answers are then
    a list in the order in which they came.
    """
    agent, argument_count = invocation.agent, len(invocation.args)
    to, force = invocation.value(0), _force(invocation, 1)
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


def _force(invocation: Invocation, index: int) -> str:
    force = invocation.value(index)
    if not is_name(force):
        name = invocation.call.name.removeprefix(".")
        reason = f"illocutionary force parameter ('{force}') must be an atom!"
        raise EvaluationError(f"Wrong argument for internal action '{name}': {reason}", "wrong_arguments")
    return str(force)


def _wait_for_answers(invocation: Invocation, force: str, names: list[str], asked: int | None) -> None:
    agent = invocation.agent
    deadline = agent.run.deadline(invocation.number(4)) if len(invocation.args) == 5 else None
    question = PendingQuestion(invocation.own_intention(), force, invocation.args[3], deadline, asked)
    agent.questions.update(dict.fromkeys(names, question))
    if deadline is not None:
        agent.run.note_deadline(deadline)
    invocation.held = True


@internal_action("broadcast", 2)
def _broadcast(invocation: Invocation) -> Outcome:
    force, content = _force(invocation, 0), invocation.value(1)
    for name in invocation.agent.run.agents:
        if name != invocation.agent.name:
            send(invocation.agent, name, force, content)
    return True


_NAMED = re.compile(r"#\{([A-Z]\w*)\}")


def _text(invocation: Invocation, start: int = 0) -> str:
    """The arguments one after the other; strings without quotes, but only outside of other terms.

    A variable without a value is marked as one, as Jason does.
    """
    return "".join(_argument_text(invocation, index) for index in range(start, len(invocation.args)))


def _argument_text(invocation: Invocation, index: int) -> str:
    written: object = invocation.args[index]
    if isinstance(written, (And, Or, Not, Comparison)):
        return str(invocation.agent.value(FormulaTerm(written, invocation.call.location), invocation.bindings))
    value = invocation.value(index)
    # A variable that stands for another one without a value is known by its own name.
    return _plain_text(written if isinstance(value, Variable) and isinstance(written, Variable) else value)


def _plain_text(value: Term) -> str:
    return f"{value}<no-value>" if isinstance(value, Variable) else render(value)


@internal_action("print", 0, MANY)
@internal_action("println", 0, MANY)
def _print(invocation: Invocation) -> Outcome:
    invocation.agent.run.print(invocation.agent.name, _text(invocation))
    return True


@internal_action("verbose", 1)
@internal_action("set_random_seed", 1)
def _configure(invocation: Invocation) -> Outcome:
    """Nothing is logged here, and random numbers come from the run's own seed."""
    return invocation.ignore()


@internal_action("puts", 1, MANY)
def _puts(invocation: Invocation) -> Outcome:
    """The texts, with the values of the variables named in them, as in ``"#{X} left"``; as in Jason, nothing else."""
    agent, values = invocation.agent, map(invocation.value, range(len(invocation.args)))
    text = "".join(value.value for value in values if isinstance(value, String))
    filled = _NAMED.sub(lambda match: render(agent.value(Variable(match[1]), invocation.bindings)), text)
    agent.run.print(agent.name, filled)
    return True


_FORMAT = re.compile(r"%([-+ 0,(#]*\d*(?:\.\d+)?)([a-zA-Z%])")


@internal_action("printf", 1, MANY)
def _printf(invocation: Invocation) -> Outcome:
    """``.printf("%5.2f %s", X, Y)``, with the formats of Java for doubles, which all numbers are, and for text."""
    left = [invocation.value(index) for index in range(1, len(invocation.args))]

    def fill(match: re.Match[str]) -> str:
        flags, kind = match[1].replace("(", ""), match[2]
        if kind in "n%":
            return "\n" if kind == "n" else "%"
        if not left:
            raise EvaluationError(f"{invocation.call}: no value for {match[0]}", "unknown")
        value = left.pop(0)
        if kind in "sS":
            width = flags.replace("-", "<") if "-" in flags else f">{flags}" if flags else ""
            text = format(repr(float(value)) if isinstance(value, Number) else _plain_text(value), width)
            return text.upper() if kind == "S" else text
        if kind not in "feEgG" or not isinstance(value, Number):
            # As in Java, numbers do not fit `%d`.
            raise EvaluationError(f"{invocation.call}: {match[0]} is not a format of {value}", "unknown")
        return format(float(value), (flags.replace("-", "<") or "") + kind)

    invocation.agent.run.print(invocation.agent.name, _FORMAT.sub(fill, invocation.text(0)).rstrip("\n"))
    return True


@internal_action("print_unifier", 0)
def _print_unifier(invocation: Invocation) -> Outcome:
    """Print the variables that have a value, one a line."""
    agent = invocation.agent
    for name, value in sorted(invocation.bindings.items()):
        agent.run.print(agent.name, f"{name}={agent.value(value, invocation.bindings)}")
    agent.run.print(agent.name, "done")
    return True


@internal_action("log", 2, MANY)
def _log(invocation: Invocation) -> Outcome:
    invocation.agent.run.warn(f"{invocation.agent.name}: {_text(invocation, 1)}")
    return True


# --- the agents of a run: who takes part, and who offers what


@internal_action("create_agent", 2, inspects=True)
def _create_agent(invocation: Invocation) -> Outcome:
    """``.create_agent(Name, "source.asl")``; the agent acts from the next round on, as the last."""
    if invocation.is_free(0) or invocation.is_free(1):
        raise EvaluationError(f"{invocation.call}: expected a name and a source, found a variable without a value")
    invocation.agent.run.create_agent(invocation.text(0), invocation.text(1), invocation.call.location)
    return True


@internal_action("kill_agent", 1, inspects=True)
def _kill_agent(invocation: Invocation) -> Outcome:
    return invocation.agent.run.kill_agent(invocation.text(0))


@internal_action("clone", 1, inspects=True)
def _clone(invocation: Invocation) -> Outcome:
    """``.clone(Name)``: another agent with the beliefs and plans of this one; it acts from the next round on."""
    if invocation.is_free(0):
        raise EvaluationError(f"{invocation.call}: expected a name, found a variable without a value")
    invocation.agent.run.clone_agent(invocation.agent.name, invocation.text(0), invocation.call.location)
    return True


@internal_action("stopMAS", 0, 1)
def _stop_mas(invocation: Invocation) -> Outcome:
    if invocation.args and invocation.number(0) < 0:
        raise EvaluationError(f"{invocation.call}: a delay cannot be negative")
    invocation.agent.run.stop()
    return True


# The directory of who offers what, of agents that are providers of services. As in Jason's own infrastructure, the type
# of a service is read and makes no difference.


@internal_action("df_register", 1, 2, inspects=True)
def _df_register(invocation: Invocation) -> Outcome:
    run, service = invocation.agent.run, invocation.text(0)
    run.directory.register(invocation.agent.name, service)
    for subscriber in run.directory.subscribers(service):
        _tell_provider(invocation, subscriber, invocation.agent.name)
    run.progress += 1
    return True


@internal_action("df_deregister", 1, 2, inspects=True)
def _df_deregister(invocation: Invocation) -> Outcome:
    invocation.agent.run.directory.deregister(invocation.agent.name, invocation.text(0))
    invocation.agent.run.progress += 1
    return True


@internal_action("df_search", 2, 3, inspects=True)
def _df_search(invocation: Invocation) -> Outcome:
    """``.df_search(Service, Agents)``: the list of those who offer it, in the order of their names."""
    names = invocation.agent.run.directory.providers(invocation.text(0))
    return invocation.unify(len(invocation.args) - 1, ListTerm(tuple(map(Structure, names))))


@internal_action("df_subscribe", 1, 2, inspects=True)
def _df_subscribe(invocation: Invocation) -> Outcome:
    """``df`` tells the agent ``provider(Agent, "service")`` for each present and future provider."""
    run, service = invocation.agent.run, invocation.text(0)
    run.directory.subscribe(invocation.agent.name, service)
    for provider in run.directory.providers(service):
        _tell_provider(invocation, invocation.agent.name, provider)
    run.progress += 1
    return True


def _tell_provider(invocation: Invocation, subscriber: str, provider: str) -> None:
    run = invocation.agent.run
    run.messages += 1
    content = Structure("provider", (Structure(provider), String(invocation.text(0))))
    run.deliver(subscriber, SpeechAct(DIRECTORY, "tell", content, run.messages))
