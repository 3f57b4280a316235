"""Writes the `Driver` of a drafted `conftest.py`, with stand-ins and what people say, and `drafted_messages.py`."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, SCRIPT, Message, MessageField, Port
from pytest_hricdv.extra.draft.project.declarations import ImportTable, tuple_text
from pytest_hricdv.extra.draft.project.draft import Draft, Sensor
from pytest_hricdv.extra.draft.project.inputs import Input, Variant
from pytest_hricdv.extra.draft.project.ranges import number_range


def say_lines(draft: Draft, table: ImportTable) -> list[str]:
    """Lines for what people say; declarations that first runs did without are comments."""
    said = {command for thing in draft.inputs for command, _ in thing.commands}
    lines = list(_say_rows(draft, draft.inputs, table))
    if said:
        lines = ["    # What a person can say to the robot, with the numbers in it.", "    says = {", *lines, "    }"]
    rest = [line for thing in draft.whole.inputs for line in _say_rows(draft, [thing.without(said)], ImportTable(()))]
    rest += unset_lines(draft)
    return [*lines, *comment_lines([line.removeprefix("    ") for line in rest], "    ")]


def unset_lines(draft: Draft) -> list[str]:
    """Lines for declared return values of devices that the draft never sets."""
    there = {(sensor.name, level) for sensor in draft.sensors for level, _ in sensor.levels}
    return [f'    "set_{word(sensor.name)} {level}"  # {sensor.operation.location}' for sensor in draft.whole.sensors
            for level, _ in sensor.levels if (sensor.name, level) not in there]  # fmt: skip


def comment_lines(lines: list[str], indent: str = "") -> list[str]:
    """Declarations that first runs did without, as comments."""
    head = f"{indent}# The code declares this, too. First runs did without: QUESTIONS.md says why."
    return [head, *(f"{indent}# {line.strip()}" for line in lines)] if lines else []


def _say_rows(draft: Draft, things: Iterable[Input], table: ImportTable) -> Iterator[str]:
    for thing in things:
        if draft.ros is not None:
            kind = json.dumps(thing.message.channel)
        elif thing.variants:
            kind = table.use(thing.message.module, thing.message.name)
        for command, variant in thing.commands:
            values = list(_values(draft, thing, variant, table))
            notes = [note for _, note in values if note]
            mark = notes[0] if len(notes) == 1 else str(variant.location)
            if len(notes) < 2:
                arguments = ", ".join([kind, *(text for text, _ in values)])
                yield f'        "{command}": Say({arguments}),  # {mark}'
                continue
            yield from (f'        "{command}": Say(  # {mark}', f"            {kind},")
            yield from (f"            {text},{f'  # {note}' if note else ''}" for text, note in values)
            yield "        ),"


def _values(draft: Draft, thing: Input, variant: Variant, table: ImportTable) -> Iterator[tuple[str, str]]:
    """The fields of a message, each with a note; unknown fields have their default, or are neutral."""
    values, ranges = dict(variant.values), dict(variant.ranges)
    for part in thing.message.fields:
        if part.name in values:
            text, note = table.text(values[part.name], part.imports), ""
        elif part.kind == "float":
            text, note = number_range(part, ranges.get(part.name))
            text = f"Array({text})" if part.type == "list" and draft.ros is not None else text
        elif part.default or draft.ros is not None:
            continue
        else:
            text, note = table.text(part.neutral or "None", part.imports), ""
        yield f"{part.name}={text}" if part.name.isidentifier() else f'**{{"{part.name}": {text}}}', note


# --- the driver


def driver_lines(draft: Draft, table: ImportTable) -> list[str]:
    entry = draft.entry
    lines = ["    driver = Driver("]
    if entry is None:
        names = ", ".join(f"import_module({json.dumps(name)})" for name in draft.code.modules if draft.imports_code)
        lines += ["        # TODO: nothing was found to call: what runs the robot?", f"        lambda: [{names}],"]
    else:
        robot = f"Script({json.dumps(entry.module)})" if entry.name == SCRIPT else table.use(entry.module, entry.name)
        lines += [f"        {robot},  # {entry.location}"]
        lines += _ports(draft, "ports", entry.ports, table)
    if entry is not None and entry.method:
        lines += [f'        method="{entry.method}",', *_ports(draft, "method_ports", entry.method_ports, table)]
    if entry is not None and entry.period_s:
        lines += [f"        period_s={entry.period_s:g},  # TODO: how often?"]
    lines += _inner(draft, table)
    lines += ["        says=says,"] if draft.inputs else []
    calls = [thing.message for thing in draft.inputs if thing.message.form == "call"]
    if calls:
        lines += ["        reaches={"]
        for message in calls:
            how = table.text(message.delivery, message.delivery_imports)
            lines += [f"            {table.use(message.module, message.name)}: {how},"]
        lines += ["        },"]
    outputs = [message for message in draft.code.outputs if message.form not in ("called", "state")]
    lines += [f"        answers={_kinds(draft.answers, table)},"] if draft.answers else []
    lines += [f"        outputs={_kinds(outputs, table)},"] if outputs else []
    called = {message.channel: table.use(message.module, message.name)
              for message in draft.code.outputs if message.form == "called"}  # fmt: skip
    if called:
        pairs = ", ".join(f"{json.dumps(port)}: {name}" for port, name in called.items())
        lines += [f"        called={{{pairs}}},"]
    lines += _senses(draft)
    topic, _, field = draft.code.state.partition(".")
    state = next((message for message in draft.code.outputs if message.topic == topic), None)
    if state is not None:
        path = f'        state="{state.channel}",  # {state.location}' if state.form == "state" else ""
        lines += [path] if path else []
        lines += [f"        state_message={table.use(state.module, state.name)},"]
        lines += [f'        state_field="{field}",'] if field != "state" else []
    lines += [f'        person="{draft.person}",'] if draft.person != "person" else []
    lines += ["        manners=Manners(ANSWER_S, STAYS_S),", "        limit_s=LIMIT_S,"]
    lines += ["        takes_s=0.01,  # a loop that only asks devices would not end"] if draft.takes_time else []
    lines += ["        may_end=True,"] if "early" in draft.allowed_endings and entry is not None else []
    if draft.may_raise and entry is not None:
        lines += [f"        may_raise={tuple_text(draft.may_raise, quoted=False)},  # TODO: what does the code need?"]
    if draft.working_folder:
        lines += [f"        folder=HERE / {json.dumps(os.path.relpath(draft.working_folder, draft.folder))},"]
    lines += ['        cross="state and manner",'] if has_cross(draft) else []
    lines += ["        is_async=True,"] if draft.is_async else []
    return [*lines, "    )"]


def _kinds(messages: tuple[Message, ...] | list[Message], table: ImportTable) -> str:
    names = [table.use(message.module, message.name) for message in messages]
    return f"({', '.join(names)}{',' if len(names) == 1 else ''})"


def _ports(draft: Draft, keyword: str, ports: tuple[Port, ...], table: ImportTable) -> list[str]:
    required = [port for port in ports if not port.default]
    lines = [f'            "{port.name}": {_port(draft, port, table)},  # {port.location}' for port in required]
    return [f"        {keyword}={{", *lines, "        },"] if lines else []


def _inner(draft: Draft, table: ImportTable) -> list[str]:
    """The objects that the code makes itself."""
    lines = []
    for port in (port for port in draft.code.inner if port.made_from):  # others are of `replace_modules`
        target = f"Replace({json.dumps(port.made_from)}, {_port(draft, port, table)})"
        lines.append(f'            "{port.name}": {target},  # {port.location}; TODO: a simulator')
    return ["        inner={", *lines, "        },"] if lines else []


def _port(draft: Draft, port: Port, table: ImportTable) -> str:
    """The argument of the code for a port."""
    if port.role == "bus":
        return "BusPort()"
    if port.role == "clock":
        is_called = any(operation.name == "__call__" for operation in port.operations)
        form = ("sleep" if port.name == "sleep" else "now") if is_called else ""
        return f'ClockPort("{form}")' if form else "ClockPort()"
    if port.role == "publish" or (port.role == "queue" and port.direction == "published"):
        return "OutboxPort()"
    if port.role == "queue":
        kinds = []
        for thing in draft.inputs:
            message = thing.message
            if message.form == "call" or message.channel not in ("", port.name.strip("_")):
                continue
            is_item = message.form == "item"
            kinds.append(f"{{{_conversion(message, table)}}}" if is_item else table.use(message.module, message.name))
        return f"InboxPort({', '.join(kinds)})"
    if port.role == "program":
        return f"ProgramPort({json.dumps(port.annotation)})"
    if port.role == "connection":
        return _connection(draft, port, table)
    if port.role == "device":
        return _device(draft, port, table)
    if port in draft.parameters:
        return f'RunParameter("{port.name}"{", is_whole=True" if port.annotation == "int" else ""})'
    neutral = table.text(port.neutral or "None", port.imports)
    return f"Make(lambda: {neutral})" if "(" in neutral or "[" in neutral or "{" in neutral else neutral


def _conversion(message: Message, table: ImportTable) -> str:
    how = table.text(message.delivery, message.delivery_imports)
    return f"{table.use(message.module, message.name)}: {how}"


def _connection(draft: Draft, port: Port, table: ImportTable) -> str:
    path = port.made_from.partition(":")[2]
    parts = [json.dumps(path.rpartition(".")[2])] if not path.startswith("socket") else []
    kinds = [_conversion(thing.message, table) for thing in draft.inputs
             if thing.message.form == "item" and thing.message.channel == port.name]  # fmt: skip
    parts += [f"kinds={{{', '.join(kinds)}}}"] if kinds else []
    return f"ConnectionPort({', '.join(parts)})"


def _device(draft: Draft, port: Port, table: ImportTable) -> str:
    sensors = [sensor.operation.key for sensor in draft.sensors if sensor.port == port.name]
    answers = {operation.key: table.text(operation.neutral, operation.imports) for operation in port.operations
               if operation.neutral and operation.key not in sensors and not operation.is_set}  # fmt: skip
    coroutines = [operation.name for operation in port.operations if operation.is_async and operation.is_method]
    parts = [f"senses={tuple_text(sensors)}"] if sensors else []
    if answers:
        made = ", ".join(f"{json.dumps(name)}: lambda: {text}" for name, text in answers.items())
        parts += [f"answers={{{made}}}"]
    parts += [f"coroutines={tuple_text(coroutines)}"] if coroutines else []
    inboxes: dict[str, list[str]] = {}
    for message in (thing.message for thing in draft.inputs if thing.message.form == "item"):
        owner, _, method = message.channel.partition(".")
        if method and owner == port.name:
            is_method = any(operation.name == method and operation.is_method for operation in port.operations)
            inboxes.setdefault(f"{method}()" if is_method else method, []).append(_conversion(message, table))
    taken = [f"{json.dumps(method)}: {{{', '.join(kinds)}}}" for method, kinds in inboxes.items()]
    parts += [f"inboxes={{{', '.join(taken)}}}"] if taken else []
    return f"Device({', '.join(parts)})"


def _senses(draft: Draft) -> list[str]:
    if not draft.sensors:
        return []
    lines = ["        # What the code reads first. TODO: what is right for your robot?", "        senses={"]
    lines += [f'            "{s.path}": {_initial(s)},  # {s.operation.location}'
              for s in draft.sensors]  # fmt: skip
    lines += ["        },"]
    texts = [f"            {json.dumps(f'set_{word(sensor.name)} {level}')}: {json.dumps(text, ensure_ascii=False)},"
             for sensor in draft.sensors if sensor.field.kind == "str"
             for level, text in sensor.levels]  # fmt: skip
    return [*lines, *(["        settings={", *texts, "        },"] if texts else [])]


def _initial(sensor: Sensor) -> str:
    if sensor.field.kind == "str":
        return json.dumps(sensor.field.values[0].text, ensure_ascii=False)
    if sensor.field.kind == "bool":
        return "False"
    numbers = sensor.field.compared or sensor.field.observed or (0.0, 1.0)
    middle = sum(numbers) / len(numbers)
    if middle in sensor.field.compared:  # what it is equal to may end the code
        middle += max(abs(middle), 1.0) / 2
    return repr(float(f"{middle:.6g}"))


def has_cross(draft: Draft) -> bool:
    """Whether the states are crossed with the manners of what was said."""
    return bool(draft.code.state and draft.inputs and not draft.has_open_states) and draft.ros is None


# --- messages of its own

_TYPES = {"bool": "bool", "float": "float", "str": "str"}

_DOCS = {
    "call": "Gets to the code as a call: {location}.",
    "item": "Gets to the code as {location} takes it.",
    "called": "The code has called this port: its method, and the first text among the arguments. {location}",
    "state": "The state of the robot has changed: {location}.",
}


def own_messages(draft: Draft) -> tuple[Message, ...]:
    """The messages that the draft defines."""
    every = dict.fromkeys((*draft.messages, *draft.whole.messages))
    return tuple(message for message in every if message.module == OWN_MODULE)


def messages_module(draft: Draft) -> str:
    """The module with these messages."""
    lines = [
        '"""Messages between people and the robot where its code has no classes for them."""',
        "",
        "from dataclasses import dataclass",
    ]
    for message in own_messages(draft):
        doc = _DOCS[message.form].format(location=message.location).replace("\\", "/").replace('"', "'")
        lines += ["", "", "@dataclass(frozen=True)", f"class {message.name}:", f'    """{doc}"""']
        lines += [""] if message.fields else []
        lines += [f"    {part.name}: {_type(part)}{_default(part)}" for part in message.fields]
    return "\n".join(lines) + "\n"


def _type(part: MessageField) -> str:
    return "int" if part.type == "int" else _TYPES.get(part.kind, "str")


def _default(part: MessageField) -> str:
    """The default of a part; for texts, a comment lists the values that the code knows."""
    texts = ", ".join(json.dumps(value.text, ensure_ascii=True) for value in part.values[:6])
    return f"  # {texts}" if texts else ""
