"""Adds `Observations` of first runs or recordings to a model of code: entry, values, results of devices, states."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.code.attributes import ATTRIBUTE, OBSERVED
from pytest_hricdv.extra.draft.code.sources import Scope, Sources
from pytest_hricdv.extra.draft.code_model import (
    CodeModel,
    Entry,
    FieldValue,
    Message,
    MessageField,
    Operation,
    Port,
    State,
    StateMachine,
    Transition,
)
from pytest_hricdv.extra.draft.observe.observations import Observations, Site
from pytest_hricdv.extra.draft.observe.shape import Shape
from pytest_hricdv.extra.draft.observe.tracer import LIBRARY
from pytest_hricdv.extra.draft.observed_calls import kind_of_shape, texts_of_shape, with_methods

MIN_REPEATS = 10
"""Calls of a method, all alike, that make it a control loop."""

MAX_STATES = 12
"""Most texts of an attribute that are taken for states."""


def best_entry(seen: Observations, sources: Sources) -> str:
    """The class of the code that is made from outside, and has most calls from and to outside; empty if none is."""
    own = {scope.module.name + ":" + scope.node.name: scope.node.name for scope in sources.classes}
    scores: dict[str, int] = {}
    for key in seen.made:
        if key in own:
            name = own[key]
            ports = sum(site.count for call, site in seen.calls.items() if call.startswith(f"{name}."))
            calls = sum(site.count for method, site in seen.methods.items() if method.startswith(f"{key}."))
            scores[name] = ports + calls
    best = max(scores, key=lambda name: scores[name], default="")
    return best if scores.get(best) else ""


def function_at(sources: Sources, location: str) -> Scope | None:
    """The function of the code at `file:line`; None if there is none."""
    file, _, line = location.rpartition(":")
    for scope in sources.functions if line.isdigit() else ():
        lines = {scope.node.lineno, *(decorator.lineno for decorator in scope.node.decorator_list)}
        if int(line) in lines and (sources.root / scope.module.file) == Path(file).resolve():
            return scope
    return None


def _methods(seen: Observations, entry: Entry) -> dict[str, Site]:
    head = f"{entry.module}:{entry.name}."
    return {key.removeprefix(head): site for key, site in seen.methods.items() if key.startswith(head)}


def methods_from_outside(seen: Observations, entry: Entry) -> frozenset[str]:
    """Methods of the entry that programs called, and are not callbacks."""
    callbacks = {name for site in seen.calls.values() for shape in site.arguments.values()
                 if shape.kinds.get("callable") for name in shape.classes}  # fmt: skip
    return frozenset(name for name, site in _methods(seen, entry).items() if site.location != LIBRARY
                     and f"{entry.module}:{entry.name}.{name}" not in callbacks)  # fmt: skip


def period_of(seen: Observations, entry: Entry, method: str) -> tuple[int, float]:
    """The number of calls of a method called like a control loop, and its only numeric argument: the period (s)."""
    site = _methods(seen, entry).get(method)
    if site is None or site.count < MIN_REPEATS:
        return 0, 0.0
    shapes = list(site.arguments.values())
    if not all(shape.low is not None and set(shape.kinds) <= {"int", "float"} for shape in shapes) or len(shapes) > 1:
        return 0, 0.0
    return site.count, (shapes[0].high or 0.0) if shapes else 0.0


def with_observations(model: CodeModel, seen: Observations) -> CodeModel:
    """The model with observed values."""
    entry = model.entry
    if entry is None:
        return model
    messages = tuple(_with_values(message, seen, entry) for message in model.messages)
    model = replace(model, messages=messages)
    pairs = _pairs(model, seen)
    model = replace(model, machines=tuple(_with_states(machine, pairs) for machine in model.machines))
    states = tuple(FieldValue(state.name, state.location) for state in model.machine.states) if model.machine else ()
    messages = tuple(replace(part, fields=(replace(part.fields[0], values=states),)) if part.form == "state" else part
                     for part in model.messages)  # fmt: skip
    return with_steps(replace(model, messages=messages), seen)


def keep_declared(declared: CodeModel, now: CodeModel) -> CodeModel:
    """A model that was made of observations, with all that the code declares."""
    there = {message.topic: message for message in now.messages}
    messages = [
        other for other in declared.messages if other.form != "called" or other.topic in there
    ]  # now it may be an answer
    kept = [_keep_message(message, there.pop(message.topic, message)) for message in messages]
    machines = now.machines
    if declared.machine is not None:
        others = [machine for machine in now.machines if machine.name != declared.machine.name]
        same = next((machine for machine in now.machines if machine.name == declared.machine.name), declared.machine)
        states = {state.name: state for state in (*declared.machine.states, *same.states)}
        machines = (replace(same, states=tuple(states.values()), field=declared.machine.field), *others)
    return replace(now, messages=(*kept, *there.values()), machines=machines)


def _keep_message(declared: Message, now: Message) -> Message:
    fields = {part.name: part for part in now.fields}
    if not {part.name for part in declared.fields} <= {*fields}:
        return declared
    kept = {part.name: _keep_field(part, fields[part.name]) for part in declared.fields}
    return replace(now, fields=tuple(kept.get(part.name, part) for part in now.fields))


def _keep_field(declared: MessageField, now: MessageField) -> MessageField:
    if declared.kind not in ("", now.kind):
        return declared
    values = {value.text: value for value in (*declared.values, *now.values)}
    return replace(now, values=tuple(values.values()))


def find_machines(seen: Observations, model: CodeModel) -> Iterator[StateMachine]:
    """Attributes of the entry's object that had a few texts, and came back to one: of the most steps first."""
    entry = model.entry
    assert entry is not None
    head = f"{entry.module}:{entry.name}."
    found = []
    for key, pairs in seen.states.items():
        path = key.removeprefix(head)
        steps = [pair.split(" -> ") for pair in pairs if pair.count(" -> ") == 1]
        texts = list(dict.fromkeys(text for step in steps for text in step))
        comes_back = any(step[1] in texts[: texts.index(step[0]) + 1] for step in steps)
        if key != path and "." not in path and comes_back and "" not in texts and len(texts) <= MAX_STATES:
            states = tuple(State(text, entry.location) for text in texts)
            held = f"{entry.name}.{path}"
            found.append((len(steps), StateMachine(path, OBSERVED, states, (), entry.location, "", held)))
    yield from (machine for _, machine in sorted(found, key=lambda rated: -rated[0]))


def _with_values(message: Message, seen: Observations, entry: Entry) -> Message:
    """A message with the observed values of its fields: of arguments, and of what queues returned."""
    shapes: dict[str, Shape] = {}
    if message.form == "call":
        for site in [site for name, site in _methods(seen, entry).items() if name == message.channel]:
            for name, shape in site.arguments.items():
                _collect(shapes, {name: shape, **shape.fields})
    for site in (*seen.calls.values(), *seen.methods.values()):
        for shape in (site.result, *site.arguments.values()):
            if f"{message.module}:{message.name}" in shape.classes or (
                message.form == "item" and {*shape.fields} >= {part.name for part in message.fields}
            ):
                _collect(shapes, shape.fields)
    return replace(message, fields=tuple(_field(part, shapes.get(part.name)) for part in message.fields))


def _collect(shapes: dict[str, Shape], more: Mapping[str, Shape]) -> None:
    for name, shape in more.items():
        shapes.setdefault(name, Shape()).merge(shape)


def _field(part: MessageField, shape: Shape | None) -> MessageField:
    """A field with what was observed of it."""
    if shape is None:
        return part
    kind = part.kind or (kind_of_shape(shape) if not part.type else "")
    if kind == "float" and shape.low is not None and shape.high is not None and not part.compared:
        return replace(part, kind=kind, observed=(shape.low, shape.high))
    if kind == "str" and not (part.by_type or part.values or shape.is_open):  # else programs try other texts, too
        return replace(part, kind=kind, values=texts_of_shape(shape, part.location))
    return replace(part, kind=kind)


def with_ports(model: CodeModel, seen: Observations) -> CodeModel:
    """The model, whose devices have all methods that were called, with what they returned, or were taken for."""
    entry = model.entry
    assert entry is not None

    def with_results(ports: tuple[Port, ...]) -> tuple[Port, ...]:
        every = (with_methods(port, entry, seen) for port in ports)
        return tuple(replace(port, operations=tuple(_operation(port, operation, seen, entry.name)
                                                    for operation in port.operations))
                     if port.role == "device" else port for port in every)  # fmt: skip

    updated = replace(entry, ports=with_results(entry.ports), method_ports=with_results(entry.method_ports))
    return replace(model, entry=updated, inner=with_results(model.inner))


def _operation(port: Port, operation: Operation, seen: Observations, owner: str) -> Operation:
    names = (f"{owner}.{port.name}.{operation.name}", f"{owner}.__init__.{port.name}.{operation.name}",
             operation.path(port.name))  # fmt: skip
    site = next((seen.calls[name] for name in names if name in seen.calls), None)
    kind = "" if site is None else "float" if site.compared else kind_of_shape(site.result)
    if (
        site is None
        or not kind
        or operation.is_set
        or (kind == "str" and (site.result.is_open or not site.result.texts))
    ):
        return operation
    before = operation.result or MessageField("value", "", kind, operation.location, compared=tuple(site.compared))
    part = _field(replace(before, kind=before.kind or kind), site.result)
    return replace(operation, result=part if part.kind != "str" or part.values else operation.result)


def _pairs(model: CodeModel, seen: Observations) -> Collection[str]:
    """States in which the object was seen, and what followed what, as "from -> to"."""
    path = next((message.channel for message in model.messages if message.form == "state"), "")
    entry = model.entry
    return seen.states.get(f"{entry.module}:{entry.name}.{path}", {}) if entry is not None and path else ()


def _with_states(machine: StateMachine, pairs: Collection[str]) -> StateMachine:
    """A machine with the states that its attribute was seen in."""
    there = {state.name for state in machine.states}
    texts = dict.fromkeys(text for pair in pairs for text in pair.split(" -> ") if text and text not in there)
    states = tuple(State(text, machine.location) for text in texts) if machine.field else ()
    return replace(machine, states=(*machine.states, *states))


def with_steps(model: CodeModel, seen: Observations) -> CodeModel:
    """The model, where a machine whose transitions no code declares has those that were seen."""
    steps = [tuple(pair.split(" -> ")) for pair in _pairs(model, seen) if pair.count(" -> ") == 1]

    def with_its_steps(machine: StateMachine) -> StateMachine:
        names = {state.name for state in machine.states}
        moves = tuple(Transition(before, after, machine.location) for before, after in steps
                      if before != after and {before, after} <= names)  # fmt: skip
        is_open = machine.kind in (ATTRIBUTE, OBSERVED) and machine.field
        return replace(machine, transitions=moves) if is_open else machine

    return replace(model, machines=tuple(map(with_its_steps, model.machines)))
