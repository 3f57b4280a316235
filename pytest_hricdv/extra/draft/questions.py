"""What nobody but a person can say of the code: what was not found, and what its surroundings do."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.draft.found.findings import Entry, Findings, Port, Question
from pytest_hricdv.extra.draft.found.nodes import Endpoint
from pytest_hricdv.extra.draft.surroundings.motions import motions


def questions(findings: Findings) -> Iterator[Question]:
    """All questions, those of what it says and hears first."""
    for endpoint in findings.ros.endpoints:
        yield from _endpoint_question(endpoint)
    if not findings.heard and not any(not endpoint.is_said for endpoint in findings.ros.endpoints):
        yield Question("Nothing was found that the code hears: what makes it act?", "messages", None)
    if not findings.said and not any(endpoint.is_said for endpoint in findings.ros.endpoints):
        yield Question("Nothing was found that the code says: how does one see what it does?", "messages", None)
    for message in findings.messages:
        for part in message.leaves:
            if part.kind == "str" and not part.values and message.direction != "said":
                text = f"Which texts can `{message.topic}.{part.name}` have? None is compared with it"
                yield Question(text, f"{message.topic}.{part.name}", part.place)
            if part.kind == "float" and message.direction != "said":
                yield Question(
                    f"Between which numbers is `{message.topic}.{part.name}`?",
                    f"{message.topic}.{part.name}",
                    part.place,
                )
    if not findings.machines:
        yield Question("No states were found: has the robot some, and where does it tell them?", "state", None)
    for machine in findings.machines:
        if not machine.told and not machine.held:
            yield Question(f"Where does the code tell the states of `{machine.name}`?", "state", machine.place)
        if not machine.transitions and machine.kind != "py_trees":
            yield Question(f"Which state of `{machine.name}` follows which?", "transitions", machine.place)
    yield from _entry_questions(findings.entry)


def _endpoint_question(endpoint: Endpoint) -> Iterator[Question]:
    lacks = [word for word, value in (("name", endpoint.name), ("type", endpoint.type)) if not value]
    if lacks:
        text = f"Which {' and which '.join(lacks)} has this {endpoint.kind}"
        yield Question(f"{text}{f', {endpoint.name}' if endpoint.name else ''}?", endpoint.kind, endpoint.place)


def _entry_questions(entry: Entry | None) -> Iterator[Question]:
    if entry is None:
        yield Question(
            "Nothing was found to call: which function runs the robot? Say --from PACKAGE:FUNCTION", "entry", None
        )
        return
    if entry.certainty == "likely":
        called = f"{entry.name}.{entry.method}" if entry.method else entry.name
        yield Question(f"Is `{called}` what runs the robot? Else say --from PACKAGE:FUNCTION", "entry", entry.place)
    for port in (*entry.ports, *entry.method_ports):
        if port.role == "parameter" and not port.default:
            yield Question(f"Between which values is the parameter `{port.name}`?", port.name, port.place)
        elif port.role == "device":
            yield from _device_questions(port)


def _device_questions(port: Port) -> Iterator[Question]:
    """What nobody but a person can say of what a device says."""
    follows = {value.operation.name: motion.commands[0].operation.name
               for motion in motions(port) for value in motion.readings}  # fmt: skip
    for operation in port.operations:
        about = f"{port.name}.{operation.name}"
        if operation.name in follows:
            yield Question(f"Does `{about}` follow `{follows[operation.name]}`, and how?", about, operation.place)
        elif operation.returns and operation.returns != "None":
            yield Question(f"What does `{about}` say, and when?", about, operation.place)
