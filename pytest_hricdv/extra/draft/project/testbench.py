"""The testbench of a draft, for code that is no node of ROS 2: a `Driver` with stand-ins, and what people say."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

from pytest_hricdv.extra.draft.code.naming import unit_of, word
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Message, MessageField, Port
from pytest_hricdv.extra.draft.project.declarations import (
    MAX_PATIENCE_S,
    PATIENCE,
    command_table_lines,
    model_lines,
    time_lines,
    times_lines,
    tuple_text,
)
from pytest_hricdv.extra.draft.project.draft import Draft, Sensor
from pytest_hricdv.extra.draft.project.imports import ImportTable
from pytest_hricdv.extra.draft.project.inputs import OTHER, Input, Variant, is_open
from pytest_hricdv.extra.draft.project.ranges import answer_s, lateness, number_range, reaction_lines, times_of_lines

TESTBENCH = ("BeliefSpace", "Concretization", "CrossProduct", "Delay", "Drop", "Duplicate", "Field", "Model",
             "StateField", "Testbench", "Uniform", "VirtualTime")  # fmt: skip
STAND_INS = ("Anything", "BusPort", "CallbackCall", "Clock", "Device", "Drawn", "Driver", "InboxPort", "Make",
             "Manners", "MethodCall", "OutboxPort", "Replace", "Say", "member", "replace_modules")  # fmt: skip
STANDARD = ("Path", "SimpleNamespace", "json", "import_module")
TAKEN = ("HERE", "TIMES", "TIMES_OF", "STATES", "LIMIT_S", "ANSWER_S", "STAYS_S", "says", "driver", "config", "name")


def conftest(draft: Draft) -> str:
    """The module `conftest`."""
    table = ImportTable((*TESTBENCH, *STAND_INS, *STANDARD, *TAKEN))
    function = [*_says(draft, table), *_driver(draft, table), *_testbench(draft)]
    body = [
        *_constants(draft),
        "",
        "",
        "def pytest_hricdv_testbench(config: object) -> Testbench:",
        '    """What the plugin asks for."""',
        *_missing(draft),
        *table.lines(),
        "",
        *function,
    ]
    text = "\n".join(line.rstrip() for line in body) + "\n"
    return "\n".join([*_head(draft, text), "", ""]) + text


def _head(draft: Draft, body: str) -> list[str]:
    def used(names: tuple[str, ...]) -> str:
        return ", ".join(name for name in names if re.search(rf"(?<![\w.'\"]){name}\b", body))

    return [
        f'"""The testbench of {draft.robot}, drafted from its code: each value has the location that it comes from.',
        "",
        'TODO marks what the code does not say."""',
        "",
        "from __future__ import annotations",
        "",
        *(["import json"] if "json.dumps(" in body else []),
        *(["from importlib import import_module"] if "import_module(" in body else []),
        "from pathlib import Path",
        *(["from types import SimpleNamespace"] if "SimpleNamespace(" in body else []),
        "",
        *_wrapped("from pytest_hricdv.stand_ins import", used(STAND_INS)),
        *_wrapped("from pytest_hricdv.testbench import", used(TESTBENCH)),
    ]


def _wrapped(head: str, names: str) -> list[str]:
    line = f"{head} {names}"
    return [line] if len(line) <= 88 else [f"{head} (", *(f"    {name}," for name in names.split(", ")), ")"]


def _constants(draft: Draft) -> list[str]:
    """Times and states."""
    late_s, location = draft.late_s
    reason = f"longer than {location}" if location is not None else "TODO: the code has no time-out"
    waits_s, why = answer_s(draft, max(draft.patience_s, min(late_s, MAX_PATIENCE_S) * PATIENCE))
    lines = [
        "HERE = Path(__file__).parent",
        "",
        "LIMIT_S = 900.0  # no run needs as long; TODO",
        *reaction_lines(draft),
        f"ANSWER_S = {waits_s:g}  # so long a person waits for an answer; {why}",
        "STAYS_S = 5 * ANSWER_S  # so long a person stays at most until the robot says nothing more; TODO",
        *times_lines(late_s, reason),
        *(times_of_lines(draft) if draft.inputs else []),
    ]
    if draft.code.machine is not None:
        states = draft.code.machine.states
        lines += ["", "STATES = (", *(f"    {json.dumps(s.name)},  # {s.location}" for s in states), ")"]
    return lines


def _missing(draft: Draft) -> list[str]:
    names = dict.fromkeys(name.partition(".")[0] for name in draft.absent_modules)
    return [f"    replace_modules({', '.join(map(json.dumps, names))})  # not installed here", ""] if names else []


# --- what people say


def _says(draft: Draft, table: ImportTable) -> list[str]:
    if not draft.inputs:
        return []
    lines = ["    # What a person can say to the robot, with the numbers in it."]
    lines += ["    says = {"]
    for thing in draft.inputs:
        kind = table.use(thing.message.module, thing.message.name)
        for command, variant in thing.commands:
            values = list(_values(draft, thing, variant, table))
            notes = [note for _, note in values if note]
            mark = notes[0] if len(notes) == 1 else str(variant.location)
            if len(notes) < 2:
                arguments = ", ".join([kind, *(text for text, _ in values)])
                lines.append(f'        "{command}": Say({arguments}),  # {mark}')
                continue
            lines += [f'        "{command}": Say(  # {mark}', f"            {kind},"]
            lines += [f"            {text},{f'  # {note}' if note else ''}" for text, note in values]
            lines += ["        ),"]
    return [*lines, "    }"]


def _values(draft: Draft, thing: Input, variant: Variant, table: ImportTable) -> Iterator[tuple[str, str]]:
    """The fields of a message, each with a note; those of which nothing is known have their default, or are neutral."""
    values, ranges = dict(variant.values), dict(variant.ranges)
    for part in thing.message.fields:
        if part.name in values:
            yield f"{part.name}={table.text(values[part.name], part.imports)}", ""
        elif part.kind == "float":
            text, note = number_range(draft, thing, part, ranges.get(part.name))
            yield f"{part.name}={text}", note
        elif not part.default:
            yield f"{part.name}={table.text(part.neutral or 'None', part.imports)}", ""


# --- the driver


def _driver(draft: Draft, table: ImportTable) -> list[str]:
    entry = draft.entry
    lines = ["    driver = Driver("]
    if entry is None:
        names = ", ".join(f"import_module({json.dumps(name)})" for name in draft.code.modules)
        lines += ["        # TODO: nothing was found to call: what runs the robot?", f"        lambda: [{names}],"]
    else:
        lines += [f"        {table.use(entry.module, entry.name)},  # {entry.location}"]
        lines += _ports(draft, "ports", entry.ports, table)
    if entry is not None and entry.method:
        lines += [f'        method="{entry.method}",', *_ports(draft, "method_ports", entry.method_ports, table)]
    if entry is not None and entry.period_s:
        lines += [f"        period_s={entry.period_s:g},  # TODO: how often?"]
    lines += _inner(draft, table)
    lines += ["        says=says,"] if draft.inputs else []
    calls = [message for message in draft.code.inputs if message.form == "call"]
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
    lines += ["        may_end=True,"] if "early" in draft.allowed_endings else []
    lines += ['        cross="state and manner",'] if _has_cross(draft) else []
    lines += ["        is_async=True,"] if draft.is_async else []
    return [*lines, "    )"]


def _kinds(messages: tuple[Message, ...] | list[Message], table: ImportTable) -> str:
    names = [table.use(message.module, message.name) for message in messages]
    return f"({', '.join(names)}{',' if len(names) == 1 else ''})"


def _ports(draft: Draft, keyword: str, ports: tuple[Port, ...], table: ImportTable) -> list[str]:
    given = [port for port in ports if not port.default]
    lines = [f'            "{port.name}": {_port(draft, port, table)},  # {port.location}' for port in given]
    return [f"        {keyword}={{", *lines, "        },"] if lines else []


def _inner(draft: Draft, table: ImportTable) -> list[str]:
    """The objects that the code makes itself."""
    lines = []
    for port in draft.code.inner:
        target = f"Replace({json.dumps(port.made_from)}, {_port(draft, port, table)})"
        lines.append(f'            "{port.name}": {target},  # {port.location}; TODO: a simulator')
    return ["        inner={", *lines, "        },"] if lines else []


def _port(draft: Draft, port: Port, table: ImportTable) -> str:
    """What the code gets for a port."""
    if port.role == "bus":
        return "BusPort()"
    if port.role == "clock":
        is_called = any(operation.name == "__call__" for operation in port.operations)
        form = ("sleep" if port.name == "sleep" else "now") if is_called else ""
        return f'Clock("{form}")' if form else "Clock()"
    if port.role == "publish" or (port.role == "queue" and port.direction == "published"):
        return "OutboxPort()"
    if port.role == "queue":
        kinds = []
        for thing in draft.inputs:
            message = thing.message
            if message.form == "call" or message.channel not in ("", port.name.strip("_")):
                continue
            is_item = message.form == "item"
            kinds.append(f"{{{_converted(message, table)}}}" if is_item else table.use(message.module, message.name))
        return f"InboxPort({', '.join(kinds)})"
    if port.role == "device":
        return _device(draft, port, table)
    if port in draft.parameters:
        return f'Drawn("{port.name}"{", is_whole=True" if port.annotation == "int" else ""})'
    neutral = table.text(port.neutral or "None", port.imports)
    return f"Make(lambda: {neutral})" if "(" in neutral or "[" in neutral or "{" in neutral else neutral


def _converted(message: Message, table: ImportTable) -> str:
    how = table.text(message.delivery, message.delivery_imports)
    return f"{table.use(message.module, message.name)}: {how}"


def _device(draft: Draft, port: Port, table: ImportTable) -> str:
    sensors = [sensor.operation.name for sensor in draft.sensors if sensor.port == port.name]
    answers = {each.name: table.text(each.neutral, each.imports) for each in port.operations
               if each.neutral and each.name not in sensors and not each.is_set}  # fmt: skip
    attributes = [each.name for each in port.operations if not each.is_method and not each.is_set
                  and (each.name in sensors or each.name in answers)]  # fmt: skip
    coroutines = [each.name for each in port.operations if each.is_async and each.is_method]
    parts = [f"senses={tuple_text(sensors)}"] if sensors else []
    if answers:
        made = ", ".join(f"{json.dumps(name)}: lambda: {text}" for name, text in answers.items())
        parts += [f"answers={{{made}}}"]
    parts += [f"attributes={tuple_text(attributes)}"] if attributes else []
    parts += [f"coroutines={tuple_text(coroutines)}"] if coroutines else []
    taken = [f"{json.dumps(thing.message.channel.partition('.')[2])}: {{{_converted(thing.message, table)}}}"
             for thing in draft.inputs if thing.message.channel.partition(".")[0] == port.name
             and "." in thing.message.channel and thing.message.form == "item"]  # fmt: skip
    parts += [f"inboxes={{{', '.join(taken)}}}"] if taken else []
    return f"Device({', '.join(parts)})"


def _senses(draft: Draft) -> list[str]:
    if not draft.sensors:
        return []
    lines = ["        # What the code reads first. TODO: what is right for your robot?", "        senses={"]
    lines += [f'            "{s.port}.{s.operation.name}": {_initial(s)},  # {s.operation.location}'
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
    return repr(float(f"{sum(numbers) / len(numbers):.6g}"))


# --- the testbench


def _testbench(draft: Draft) -> list[str]:
    lines = ["", *model_lines(draft), *command_table_lines(draft, "says", "say.parameters", "say")]
    for sensor in draft.sensors:
        lines += _sensor_commands(sensor)
    lines += ["            },"]
    if draft.parameters:
        lines += ["            run={", *(_parameter(port) for port in draft.parameters), "            },"]
    lines += [
        "        ),",
        '        requirements=HERE / "requirements.toml",',
        "        messages=driver.messages,",
        "        signals=driver.signals,",
        *_fields(draft),
        f"        code={tuple_text(draft.code.modules)},",
        "        run=driver.run,",
        *time_lines(draft, draft.code.virtual),
        *_state_part(draft),
    ]
    disturbances = list(_disturbances(draft))
    lines += ["        disturbances={", *disturbances, "        },"] if disturbances else []
    return [*lines, "    )"]


def _others(draft: Draft, message: Message, part: MessageField) -> list[str]:
    """A text that a person says too, and the code does not know."""
    return [OTHER] if draft.has_others and message.direction != "published" and is_open(part) else []


def _fields(draft: Draft) -> list[str]:
    lines = []
    for message in draft.messages:
        for part in message.fields:
            name = f"{message.topic}.{part.name}"
            if part.values and part.kind == "str" and (not part.by_type or message.module == OWN_MODULE):
                texts = [*(value.text for value in part.values), *_others(draft, message, part)]
                if message.form == "called":
                    continue
                is_known = not part.is_partial or name == draft.code.state
                head = "" if is_known else "# "  # a testbench that declares some refuses the others
                mark = str(part.values[0].location) + ("" if is_known else "; TODO: which others?")
                lines.append(f'            {head}"{name}": Field(values={tuple_text(texts)}),  # {mark}')
            if part.unit:
                lines.append(f'            "{name}": Field(unit="{part.unit}"),')
    return ["        fields={", *lines, "        },"] if lines else []


def _has_cross(draft: Draft) -> bool:
    return bool(draft.states and draft.inputs)


def _state_part(draft: Draft) -> list[str]:
    if not draft.states:
        return []
    lines = ["        state=StateField(", f'            "{draft.code.state}",']
    if draft.transitions:
        lines += ["            transitions=("]
        lines += [f"                ({json.dumps(a)}, {json.dumps(b)}),  # {at}" for a, b, at in draft.transitions]
        lines += ["            ),"]
    lines += ["        ),"]
    if _has_cross(draft):
        lines += ['        cross={"state and manner": CrossProduct({"state": STATES, "manner": tuple(TIMES)})},']
    return lines


def _sensor_commands(sensor: Sensor) -> list[str]:
    lines = []
    for level, text in sensor.levels:
        value = f'{{"value": {text}}}' if sensor.field.kind == "float" else "{}"
        mark = "  # TODO: between which numbers?" if sensor.field.kind == "float" else ""
        lines.append(f'                "set_{word(sensor.name)} {level}": {value},{mark}')
    return lines


def _parameter(port: Port) -> str:
    unit = unit_of(port.name)
    low, high = (20.0, 30.0) if unit == "s" else (1.0, 2.0)
    return f'                "{port.name}": Uniform({low}, {high}, "{unit}"),  # {port.location}; TODO: which values?'


def _disturbances(draft: Draft) -> Iterator[str]:
    state_topic = draft.code.state.partition(".")[0]
    for message in draft.code.messages:
        topic = message.topic
        if message.form == "called":
            continue
        # Without the message that tells a state, the robot would seem to go from the one before to the one after.
        if topic != state_topic:
            yield f'            "{topic}_lost": Drop("{topic}"),'
        if message.direction != "published":
            ends, mark = lateness(draft, topic)
            yield f'            "{topic}_late": Delay("{topic}", Uniform({ends}, "s")),  # {mark}'
            yield f'            "{topic}_doubled": Duplicate("{topic}", Uniform(0.1, 5.0, "s")),  # TODO: how late?'
