"""The analysis of a ROS 2 node for a draft: the messages of its topics, services and actions, with their fields."""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from pytest_hricdv.extra.draft.analysis import analyse_sources, questions
from pytest_hricdv.extra.draft.code.attributes import AttributeStates
from pytest_hricdv.extra.draft.code.contents import ContentReader
from pytest_hricdv.extra.draft.code.fields import FieldReader
from pytest_hricdv.extra.draft.code.flow import Flow, parameter_names
from pytest_hricdv.extra.draft.code.loading import top_level_without
from pytest_hricdv.extra.draft.code.sources import DraftError, Scope, Sources
from pytest_hricdv.extra.draft.code.waits import find_guarded_imports
from pytest_hricdv.extra.draft.code_model import (
    CodeModel,
    Direction,
    FieldValue,
    Message,
    MessageField,
    Problem,
    StateMachine,
)
from pytest_hricdv.extra.draft.observe.observations import Observations
from pytest_hricdv.extra.draft.ros.executable import Executable
from pytest_hricdv.extra.draft.ros.interfaces import fields, is_installed
from pytest_hricdv.extra.draft.ros.nodes import FOLDERS
from pytest_hricdv.extra.draft.ros_model import Endpoint, EndpointKind, RosStart

_FORMS: dict[EndpointKind, tuple[str, str, Direction, int]] = {
    "publisher": ("topic", "", "published", 0), "subscription": ("topic", "", "received", 0),
    "service": ("service", "_request", "received", 0), "client": ("service", "_request", "published", 0),
    "action server": ("action", "_goal", "received", 0), "action client": ("action", "_goal", "published", 0),
}  # fmt: skip
"""Kind of an endpoint -> the form of its message, the end of its topic in requirements, direction, part of the type."""

_ANSWERS = {"service": "_response", "action server": "_result"}
OWN = "rclpy"


def analyse_node(executable: Executable) -> tuple[CodeModel, RosStart]:
    """The model for a testbench of the node, and how it starts it.

    Raises:
        DraftError: the code does not use `rclpy`.
    """
    if not any(name.partition(".")[0] == OWN for name, _ in executable.sources.outside):
        asked = (
            f"--ros2={executable.asked!r}: expected a node of ROS 2; {executable.entry} and the code that it imports"
        )
        raise DraftError(f"{asked} use no rclpy: --from drafts for other code")
    model = analyse_sources(executable.sources, executable.asked, "")
    start, problems = _start(executable, model)
    messages = _with_values(_messages(executable, start), model.ros.endpoints, executable.sources)
    machines = (*(replace(machine, field="") for machine in model.machines), *_attribute_machines(executable.sources))
    made = replace(
        model, messages=tuple(messages), machines=machines, entry=None, problems=problems,
        modules=top_level_without(executable.sources, OWN.encode()),  # other nodes of the package are not under test
    )  # fmt: skip
    return replace(made, questions=tuple(questions(made))), start


def _attribute_machines(sources: Sources) -> Iterator[StateMachine]:
    """The states that nodes hold in attributes; then those of enumerations that other objects hold."""
    states = AttributeStates(sources, Flow(sources))
    for scope in sources.classes:
        if any(base.startswith(f"{OWN}.") for base in sources.bases(scope)):
            yield from states.machines(scope)
    yield from states.enumerations()


def with_state_topic(model: CodeModel, seen: Observations | None) -> CodeModel:
    """The model, in which a machine has the field of a topic in which first runs saw nothing but its states."""
    for number, machine in enumerate(model.machines):
        values = {state.name: FieldValue(state.name, state.location) for state in machine.states}
        for key, pairs in seen.states.items() if seen is not None else ():
            texts = {text for pair in pairs for text in pair.split(" -> ")}
            if len(texts) > 1 and texts <= {*values}:
                messages = tuple(replace(message, fields=tuple(
                    replace(part, values=tuple(values.values())) if f"{message.topic}.{part.name}" == key else part
                    for part in message.fields)) for message in model.messages)  # fmt: skip
                machines = (replace(machine, field=key), *model.machines[:number], *model.machines[number + 1 :])
                return replace(model, machines=machines, messages=messages)
    return model


def _start(executable: Executable, model: CodeModel) -> tuple[RosStart, tuple[Problem, ...]]:
    """The declarations and replacements for the start, and what is missing."""
    guarded = find_guarded_imports(executable.sources)
    needed = {dotted.partition(".")[0]: location for dotted, location in reversed(executable.sources.outside)
              if len(dotted.split(".")) > 1 and dotted.split(".")[1] in FOLDERS}  # fmt: skip
    provided = [name for name in sorted(needed) if not is_installed(name) and name in executable.packages]
    problems = [p for p in model.problems
                if p.kind != "missing module" or p.text.split("`")[1] not in {*provided, *needed, OWN}]  # fmt: skip
    unavailable = {name for name in needed if not (is_installed(name) or name in provided)}
    absent = unavailable - guarded
    for name in sorted(absent):
        text = (
            f"the messages of `{name}` are neither installed here nor in the workspace: the node cannot start, and "
            "their fields are not drafted; install them, or put their packages into the workspace, and draft again"
        )
        problems.append(Problem("missing messages", text, needed[name]))
    if not is_installed(OWN):
        location = next(
            (location for name, location in executable.sources.outside if name.partition(".")[0] == OWN), None
        )
        text = "`rclpy` is not installed here, so that the draft was not run: docs/ros2.md says how to get it"
        problems.append(Problem("missing messages", text, location))
    declared = tuple(
        endpoint for endpoint in model.ros.endpoints
        if endpoint.is_complete and endpoint.type.partition("/")[0] not in unavailable & guarded
    )  # fmt: skip
    folders = tuple(str(executable.packages[name]) for name in provided)
    return RosStart(executable.asked, executable.entry, declared, folders), tuple(problems)


def _messages(executable: Executable, start: RosStart) -> list[Message]:
    messages: dict[str, Message] = {}
    for endpoint in start.declared:
        form, end, direction, part = _FORMS[endpoint.kind]
        parts = fields(endpoint.type, part, executable.packages, endpoint.location)
        _add(messages, _message(endpoint, form, end, direction, parts or ()))
        if endpoint.kind in _ANSWERS:
            answer = fields(endpoint.type, 1, executable.packages, endpoint.location)
            _add(messages, _message(endpoint, form, _ANSWERS[endpoint.kind], "published", answer or ()))
    return list(messages.values())


def _message(endpoint: Endpoint, form: str, end: str, direction: Direction, parts: Sequence[MessageField]) -> Message:
    topic = endpoint.name.strip("/").replace("/", "_") + end
    name = endpoint.name + end.replace("_", ", ")
    return Message(
        name, topic, endpoint.type, direction, tuple(parts), endpoint.location, (endpoint.location,), form,
        endpoint.name,
    )  # fmt: skip


def _add(messages: dict[str, Message], message: Message) -> None:
    """Add a message; what a node both publishes and receives is one."""
    there = messages.get(message.topic)
    if there is None:
        messages[message.topic] = message
    elif there.direction != message.direction:
        messages[message.topic] = replace(there, direction="both")


def _with_values(messages: Sequence[Message], endpoints: Sequence[Endpoint], sources: Sources) -> Iterator[Message]:
    """The messages, with the texts that callbacks compare their fields with, or take for JSON."""
    flow = Flow(sources)
    reader = FieldReader(sources, flow)
    contents = ContentReader(flow, reader)
    callbacks = {endpoint.name: endpoint.callbacks for endpoint in endpoints if not endpoint.is_outgoing}
    for message in messages:
        names = callbacks.get(message.channel, ()) if message.direction != "published" else ()
        functions = [scope for scope in sources.functions if scope.node.name in names]
        yield replace(message, fields=tuple(
            replace(part, values=reader.values_in(functions, part.name) or _json_texts(part, functions, contents))
            if part.kind == "str" else part
            for part in message.fields
        ))  # fmt: skip


def _json_texts(part: MessageField, functions: Sequence[Scope], contents: ContentReader) -> tuple[FieldValue, ...]:
    """The JSON texts of which a callback takes a field: one for each kind and each value that it distinguishes."""
    found: dict[str, FieldValue] = {}
    for function in functions:
        assert not isinstance(function.node, ast.ClassDef)
        for _, argument in contents.variants(function, parameter_names(function.node)[-1]):
            for sample in _samples(argument.fields) if "json.dumps(" in argument.source else ():
                names = {"json": json, "Neutral": lambda **named: SimpleNamespace(**named) if named else None}
                made = eval(argument.source, names, {"m": SimpleNamespace(**sample)})  # of this tool's own making
                text = getattr(made, part.name, made)
                text = text.decode() if isinstance(text, bytes) else str(text)
                found.setdefault(text, FieldValue(text, function.location))
    return tuple(found.values())


def _samples(parts: Sequence[MessageField]) -> Iterator[dict[str, Any]]:
    """Values of all fields: the first ones, and each other one with the first ones of the others."""
    options: dict[str, list[Any]] = {}
    for part in parts:
        texts = [value.text for value in part.values]
        options[part.name] = [True, False] if part.kind == "bool" else (texts or [""]) if part.kind == "str" else [1.0]
    first = {name: values[0] for name, values in options.items()}
    yield first
    yield from ({**first, name: value} for name, values in options.items() for value in values[1:])
