"""States that the code holds in an attribute or a variable, and says nowhere: a draft looks at them in runs."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.found.findings import Entry, FoundValue, Machine, Message, MessageField, Place, State
from pytest_hricdv.extra.draft.reading.constants import UnknownValueError, evaluate
from pytest_hricdv.extra.draft.reading.naming import camel, snake
from pytest_hricdv.extra.draft.reading.sources import dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, texts
from pytest_hricdv.extra.draft.states.classes import KIND

TOLD = ("state", "mode", "phase", "status", "name")
"""Fields of these names tell a state, in a message whose name says so, also where no machine was found."""


def looked_at_in_runs(
    machines: tuple[Machine, ...], entry: Entry | None, flow: ValueFlow
) -> tuple[tuple[Machine, ...], tuple[Message, ...]]:
    """Where the code tells no state, the attribute of the robot that holds one: the draft looks at it in runs."""
    if any(machine.told for machine in machines):
        return machines, ()
    machine, read = None, ""
    if entry is not None and entry.is_made:
        machine = next((m for m in machines if m.held.rpartition(":")[2].rpartition(".")[0] == entry.name), None)
        machine = machine or next(_assigned(entry, flow), None)
        read = f"made.{machine.held.rpartition('.')[2]}" if machine is not None else ""
        if machine is None:
            machine, read = next(_numbered(entry, flow), (None, ""))
        read = f"type({read}).__name__" if machine is not None and machine.kind == KIND else read
        read += ".id" if machine is not None and machine.kind == "python-statemachine" else ""
    if machine is None:
        machine = next((m for m in machines if m.held.startswith("import_module(")), None)
        read = machine.held if machine is not None else ""
    if machine is None:
        return machines, ()
    last = re.split(r"\W+", machine.held.rstrip('"]'))[-1].strip("_")
    name = camel(f"{entry.name if entry is not None and 'made.' in read else 'robot'}_{last}")
    values = tuple(FoundValue(state.name, state.place) for state in machine.states)
    part = MessageField("name", "str", "str", machine.place, values, default='""')
    message = Message(name, snake(name), "", "said", (part,), machine.place, (machine.place,), "state", read)
    looked_at = replace(machine, told=f"{message.topic}.name")
    return (looked_at, *(other for other in machines if other is not machine)), (message,)


def _assigned(entry: Entry, flow: ValueFlow) -> Iterator[Machine]:
    """An attribute with the name of a state to which texts are assigned, and which nothing tests."""
    for (owner, attribute), values in flow.attributes.items():
        if owner == entry.name and attribute.strip("_") in TOLD[:4]:
            names = {text: place for at, value in values
                     for text, place in texts(flow.constants(value, at.module, at)).items()}  # fmt: skip
            if len(names) > 1:
                states = tuple(State(text, place) for text, place in names.items())
                held = f"{entry.module}:{owner}.{attribute}"
                yield Machine(owner, "text", states, (), states[0].place, held=held)


def _numbered(entry: Entry, flow: ValueFlow) -> Iterator[tuple[Machine, str]]:
    """An attribute that has numbers with names, as of `IDLE, MOVING = range(2)`; and what reads the name."""
    for (owner, attribute), values in flow.attributes.items():
        if owner != entry.name or attribute.strip("_") not in TOLD[:4]:
            continue
        named: dict[int, tuple[str, Place]] = {}
        for at, value in values:
            for node, where, _ in flow.expressions(value, at.module, at):
                if not isinstance(node, ast.Name | ast.Attribute):
                    continue
                try:
                    number = evaluate(flow.sources, where, node)
                except UnknownValueError:
                    continue
                if isinstance(number, int) and not isinstance(number, bool):
                    named.setdefault(number, (dotted_name(node).rpartition(".")[2], where.place(node)))
        if len(named) > 1:
            states = tuple(State(name, place) for name, place in named.values())
            names = ", ".join(f'{number}: "{name}"' for number, (name, _) in named.items())
            read = f"{{{names}}}.get(made.{attribute}, made.{attribute})"
            held = f"{entry.module}:{owner}.{attribute}"
            yield Machine(owner, "number", states, (), states[0].place, held=held), read
