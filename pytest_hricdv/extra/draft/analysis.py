"""`analyse`: the model of a package, read from its source without importing it, and questions on what is left open."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.code.entry import EntryFinder
from pytest_hricdv.extra.draft.code.flow import Flow
from pytest_hricdv.extra.draft.code.loading import find
from pytest_hricdv.extra.draft.code.messages import MessageFinder
from pytest_hricdv.extra.draft.code.sources import Sources
from pytest_hricdv.extra.draft.code.states import StateMachines
from pytest_hricdv.extra.draft.code.waits import problems, time_outs
from pytest_hricdv.extra.draft.code_model import (
    CodeModel,
    Entry,
    FieldValue,
    Message,
    MessageField,
    Question,
    StateMachine,
)
from pytest_hricdv.extra.draft.ros.nodes import ros_nodes
from pytest_hricdv.extra.draft.ros_model import Endpoint

NO_INPUTS = "No inputs found"


def analyse(package: str, start: Path | None = None) -> CodeModel:
    """Read the code of a package for what a testbench needs. Nothing is imported or run.

    Args:
        package: `PACKAGE` or `PACKAGE:FUNCTION`: a name that can be imported from `start`, or a path.
        start: the folder where it is looked for; None for the working folder.

    Raises:
        DraftError: there is no such package or function, or no source.
    """
    name, _, entry_name = package.partition(":")
    return analyse_sources(find(name, (start or Path.cwd()).resolve()), name, entry_name)


def analyse_sources(
    sources: Sources, name: str, entry_name: str, used: Collection[str] = (), flow: Flow | None = None
) -> CodeModel:
    """Analyse code that was read; `used` are the calls of programs next to it.

    Raises:
        DraftError: there is no such function.
    """
    flow = flow or Flow(sources)
    entry = EntryFinder(sources, flow, used).entry(entry_name)
    messages = MessageFinder(sources, flow).messages()
    machines = _with_fields(_unique(StateMachines(sources, flow).machines()), messages, flow)
    model = CodeModel(
        package=name,
        root=str(sources.root),
        modules=sources.top_level,
        messages=_with_states(messages, machines),
        machines=machines,
        time_outs=tuple(time_outs(flow)),
        entry=entry,
        problems=tuple(problems(sources, flow)),
        ros=ros_nodes(sources, flow),
        has_waivers=any(b"# unreachable:" in (sources.root / module.file).read_bytes() for module in sources.modules),
    )
    return replace(model, questions=tuple(questions(model)))


# --- states


def _unique(machines: Iterator[StateMachine]) -> list[StateMachine]:
    """Each set of states once: a table of a machine of a library is that machine."""
    return list({frozenset(state.name for state in machine.states): machine for machine in machines}.values())


def _with_fields(machines: Sequence[StateMachine], messages: Sequence[Message], flow: Flow) -> tuple[StateMachine, ...]:
    """The machines, each with the field in which the code publishes its state; machines with a field first."""
    published = [message for message in messages if message.direction != "received"]
    with_fields = [replace(machine, field=_field_of(machine, published, flow)) for machine in machines]
    return tuple(sorted(with_fields, key=lambda machine: not machine.field))


def _field_of(machine: StateMachine, messages: Sequence[Message], flow: Flow) -> str:
    """A field that has all states as values, or that is made of the attribute that holds them: `Status(self.state)`."""
    names = {state.name for state in machine.states}
    owner, _, attribute = machine.held_in.rpartition(".")
    for message in messages:
        for part in message.fields:
            if len(names) > 1 and names <= {value.text for value in part.values}:
                return f"{message.topic}.{part.name}"
        fields = [part.name for part in message.fields]
        for call in flow.calls.get(message.name, ()) if attribute else ():
            named = [(keyword.arg, keyword.value) for keyword in call.node.keywords]
            for name, value in (*zip(fields, call.node.args, strict=False), *named):
                holder = call.scope.owner.name if call.scope is not None and call.scope.owner is not None else ""
                is_held = ast.unparse(value) in (f"self.{attribute}", f"self.{attribute}.value", f"self.{attribute}.id")
                if is_held and holder == owner:
                    return f"{message.topic}.{name}"
    return ""


def _with_states(messages: Sequence[Message], machines: Sequence[StateMachine]) -> tuple[Message, ...]:
    """The messages, where a field that publishes a state has all states as values."""
    states = {machine.field: machine.states for machine in reversed(machines) if machine.field}

    def with_states(message: Message, part: MessageField) -> MessageField:
        there = {value.text for value in part.values}
        own = states.get(f"{message.topic}.{part.name}", ()) if not part.by_type else ()
        missing = tuple(FieldValue(state.name, state.location) for state in own if state.name not in there)
        return replace(part, kind="str", values=part.values + missing, is_partial=False) if own else part

    return tuple(
        replace(message, fields=tuple(with_states(message, part) for part in message.fields)) for message in messages
    )


# --- questions


def questions(model: CodeModel) -> Iterator[Question]:
    """Questions that only a person can answer, first about received and published messages."""
    for endpoint in model.ros.endpoints:
        yield from _endpoint_questions(endpoint)
    for endpoint in model.ros.of("client", "action client"):
        yield Question(f"What does {endpoint.name or 'it'} answer when the node asks?", "answer", endpoint.location)
    if not model.inputs and all(endpoint.is_outgoing for endpoint in model.ros.endpoints):
        yield Question(f"{NO_INPUTS}. Which messages or calls make the code act?", "messages", None)
    if not model.outputs and not any(endpoint.is_outgoing for endpoint in model.ros.endpoints):
        yield Question("No outputs found. How does one see what the code does?", "messages", None)
    for message in model.inputs:
        yield from _field_questions(message)
    if not model.machines:
        yield Question("No state machine found. Has the robot states, and where does it publish them?", "state", None)
    for machine in model.machines:
        if not machine.field:
            text = f"Where does the code publish the states of `{machine.name}`?"
            yield Question(text, "state", machine.location)
        if not machine.transitions:
            text = f"Which state of `{machine.name}` follows which?"
            yield Question(text, "transitions", machine.location)
    if model.entry is not None or not model.ros.endpoints:
        yield from _entry_questions(model.entry)


def _field_questions(message: Message) -> Iterator[Question]:
    """A question on all texts of a message, and one on all its numbers."""
    texts = [part for part in message.fields if part.kind == "str" and not part.values]
    numbers = [part for part in message.fields if part.kind == "float"]
    for parts, asks, gives in ((texts, "Which texts can", " have? The code compares none"),
                               (numbers, "Between which numbers can", " be?")):  # fmt: skip
        if parts:
            names = [f"{message.topic}.{part.name}" for part in parts]
            listed = ", ".join(f"`{name}`" for name in names)
            yield Question(f"{asks} {listed}{gives}", names[0], parts[0].location)


def _endpoint_questions(endpoint: Endpoint) -> Iterator[Question]:
    lacking = [word for word, value in (("name", endpoint.name), ("type", endpoint.type)) if not value]
    if lacking:
        text = f"Which {' and which '.join(lacking)} has this {endpoint.kind}"
        yield Question(f"{text}{f', {endpoint.name}' if endpoint.name else ''}?", endpoint.kind, endpoint.location)


def _entry_questions(entry: Entry | None) -> Iterator[Question]:
    if entry is None:
        text = "Nothing found to call. Which function runs the robot? Say --from PACKAGE:FUNCTION"
        yield Question(text, "entry", None)
        return
    if not entry.is_certain:
        called = f"{entry.name}.{entry.method}" if entry.method else entry.name
        text = f"Does `{called}` run the robot? If not, say --from PACKAGE:FUNCTION"
        yield Question(text, "entry", entry.location)
    for port in (*entry.ports, *entry.method_ports):
        if port.role == "parameter" and not port.default:
            yield Question(f"Between which values is the parameter `{port.name}`?", port.name, port.location)
        answers = [
            f"`{port.name}.{operation.name}`"
            for operation in port.operations
            if port.role == "device"
            and not operation.is_set
            and (operation.result is not None or operation.returns not in ("", "None"))
        ]
        if answers:
            verb = "does" if len(answers) == 1 else "do"
            yield Question(f"What {verb} {', '.join(answers)} return, and when?", port.name, port.location)
