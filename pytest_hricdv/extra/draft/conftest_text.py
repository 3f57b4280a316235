"""The testbench of a draft."""

from __future__ import annotations

import json
from collections.abc import Iterable

from pytest_hricdv.extra.draft.drafted import Draft, Sensor, Thing
from pytest_hricdv.extra.draft.findings import Message, Port
from pytest_hricdv.extra.draft.model_text import groups, levels, neutral_beliefs, start_beliefs
from pytest_hricdv.extra.draft.naming import word
from pytest_hricdv.extra.draft.ports_text import bus_kind, device_class

_BLANKS = {"tuple": "()", "list": "[]", "dict": "{}", "set": "set()", "bytes": 'b""'}


def conftest(draft: Draft) -> str:
    """The module `conftest`."""
    lines = [*constants(draft), *_testbench(draft), *_says(draft), "", "", *_run(draft)]
    body = "\n".join(line.rstrip() for line in lines) + "\n"
    names = [
        "BeliefSpace",
        "Concretization",
        "CrossProduct",
        "Doubled",
        "Late",
        "Lost",
        "Model",
        "Outcome",
        "Range",
        "Run",
        "Testbench",
    ]
    used = [name for name in names if f"{name}(" in body or name in ("Outcome", "Run", "Testbench")]
    head = [
        f'"""The testbench of {draft.robot}, drafted from its code: values have the place that they come from.',
        "",
        'TODO marks what the code does not say."""',
        "",
        "from __future__ import annotations",
        "",
        *(["import asyncio"] if "asyncio." in body else []),
        *(["from collections.abc import Mapping"] if "Mapping[" in body else []),
        *(["from functools import partial"] if "partial(" in body else []),
        *(["from importlib import import_module"] if "import_module(" in body else []),
        "from pathlib import Path",
        *(["from typing import Any"] if "Any" in body else []),
        "",
        *(["from pytest_hricdv.runtime import text_of"] if "text_of(" in body else []),
        "from pytest_hricdv.testbench import (",
        *(f"    {name}," for name in used),
        ")",
        "",
        "",
    ]
    return "\n".join(head) + body


def constants(draft: Draft) -> list[str]:
    """The constants of a testbench: times, and what a person can say."""
    late_s, place = draft.late_s
    reason = f"longer than {place}" if place is not None else "TODO: the code has no time-out"
    lines = [
        "HERE = Path(__file__).parent",
        "",
        "LIMIT_S = 900.0  # no run needs as long; TODO",
        f"ANSWER_S = {max(draft.patience_s, min(late_s, 60.0)):g}  # so long a person waits for an answer; TODO",
        "LOOKS_EACH_S = 0.1  # how often a person looks whether there is one",
        "",
        "# When a person does something, and how often. TODO: what is right for your people?",
        "TIMES = {",
        '    "in_time": {"after_s": Range(0.5, 2.0, "s")},',
        '    "too_early": {"after_s": Range(0.0, 0.05, "s")},',
        f'    "too_late": {{"after_s": Range({late_s * 1.1:g}, {late_s * 1.5:g}, "s")}},  # {reason}',
        '    "twice": {"after_s": Range(0.5, 2.0, "s"), "again_s": Range(0.1, 1.0, "s")},',
        "}",
    ]
    if draft.things:
        lines += [
            "",
            "# What a person can say to the robot, with the numbers in it.",
            "SAYS: dict[str, dict[str, Range]] = {",
        ]
        for thing in draft.things:
            numbers = ", ".join(f'"{p.name}": Range(0.0, 1.0, "{p.unit}")' for p in thing.numbers)
            mark = "  # TODO: between which numbers?" if numbers else ""
            lines += [
                f'    "{command}": {{{numbers}}},{mark or f"  # {kind.place}"}' for command, kind in thing.commands
            ]
        lines.append("}")
    if draft.states:
        machine = next(machine for machine in draft.findings.machines if machine.told)
        lines += ["", "STATES = (", *(f"    {json.dumps(s.name)},  # {s.place}" for s in machine.states), ")"]
    return lines


OWN = ("ports", "world")
"""Modules of the draft."""


def _import(draft: Draft, needs: Iterable[tuple[str, str]]) -> list[str]:
    """Imports, sorted; those of the draft apart where the code is in another folder."""
    by_module: dict[str, list[str]] = {}
    for module, name in needs:
        if name not in by_module.setdefault(module, []):
            by_module[module].append(name)
    lines = {module: f"    from {module} import {', '.join(sorted(by_module[module]))}" for module in sorted(by_module)}
    is_apart = draft.findings.root != str(draft.folder)
    groups = [[module for module in lines if (module in OWN) == is_own] for is_own in (False, True)]
    if not is_apart or not all(groups):
        return list(lines.values())
    return [*(lines[module] for module in groups[0]), "", *(lines[module] for module in groups[1])]


def _classes(messages: Iterable[Message]) -> list[tuple[str, str]]:
    return [(message.module or "ports", message.name) for message in messages]


def _stand_in(draft: Draft) -> list[str]:
    if not draft.missing:
        return []
    return ["    from ports import stand_in_for_missing_modules", "", "    stand_in_for_missing_modules()"]


def declared_model(draft: Draft) -> list[str]:
    """The lines of a testbench down to its commands: name, model, beliefs."""
    covered = f'"{draft.person}", "robot"' if draft.things else f'"{draft.person}",'
    return [
        "    return Testbench(",
        f'        name="{draft.robot}",',
        "        model=Model(",
        f'            HERE / "models" / "{draft.robot}.mas2j",',
        f'            actor="{draft.person}",',
        f"            covered=({covered}),",
        "        ),",
        "        beliefs=BeliefSpace(",
        f"            start={tuple_text(start_beliefs(draft))},",
        "            groups={",
        *(f"                {json.dumps(name)}: {tuple_text(beliefs)}," for name, beliefs in groups(draft).items()),
        "            },",
        *([f"            neutral={tuple_text(neutral_beliefs(draft))},"] if neutral_beliefs(draft) else []),
        "        ),",
        "        concretization=Concretization(",
        "            commands={",
    ]


def _testbench(draft: Draft) -> list[str]:
    findings = draft.findings
    values = [
        (f"{m.topic}.{p.name}", [v.text for v in p.values], p)
        for m in draft.messages for p in m.fields if p.values and not p.by_type and p.kind == "str"
    ]  # fmt: skip
    units = [(f"{m.topic}.{p.name}", p.unit) for m in draft.messages for p in m.fields if p.unit]
    units += [(s.name, p.unit) for s in draft.signals for m in draft.messages if m.topic == s.topic
              for p in m.fields if p.name == s.field and p.unit]  # fmt: skip
    names = ", ".join(message.name for message in draft.messages)
    lines = [
        "",
        "",
        "def pytest_hricdv_testbench(config: object) -> Testbench:",
        '    """What the plugin asks for."""',
        *_stand_in(draft),
        *_import(draft, [*_classes(draft.messages), ("world", "SIGNALS")]),
        "",
        *declared_model(draft),
    ]
    if draft.things:
        lines += [
            "                **{",
            '                    f"{what} {how}": {**times, **numbers}',
            "                    for what, numbers in SAYS.items()",
            "                    for how, times in TIMES.items()",
            "                },",
        ]
    for sensor in draft.sensors:
        lines += _sensor_commands(sensor)
    lines += ['                "wait_answer": {},', "            },"]
    if draft.parameters:
        lines += ["            run={", *(_parameter(draft, port) for port in draft.parameters), "            },"]
    lines += [
        "        ),",
        '        requirements=HERE / "requirements.toml",',
        f"        messages=({names}{',' if len(draft.messages) == 1 else ''}),",
        "        signals=SIGNALS,",
    ]
    if values:
        lines += ["        values={"]
        for name, texts, part in values:
            likely = any(value.certainty == "likely" for value in part.values)
            mark = f"  # {part.values[0].place}" + ("; TODO: some are of a docstring" if likely else "")
            lines.append(f'            "{name}": {tuple_text(texts)},{mark}')
        lines.append("        },")
    if units:
        lines += ["        units={", *(f'            "{name}": "{unit}",' for name, unit in units), "        },"]
    lines.append(f"        code={tuple_text(findings.code)},")
    if findings.virtual:
        lines.append(f"        virtual={tuple_text(findings.virtual)},  # the code imports them")
    lines += ["        run=run,", '        may_end=("limit", "idle", "early", "cycle"),  # TODO: which ends are right?']
    lines += _state_part(draft)
    if draft.messages:
        lines += ["        disturbances={", *_disturbances(draft), "        },"]
    return [*lines, "    )"]


def _state_part(draft: Draft) -> list[str]:
    if not draft.states:
        return []
    lines = [f'        state="{draft.findings.state}",']
    if draft.transitions:
        lines += ["        transitions=("]
        lines += [f"            ({json.dumps(a)}, {json.dumps(b)}),  # {place}" for a, b, place in draft.transitions]
        lines += ["        ),"]
    if draft.things:
        lines += ['        cross={"state and manner": CrossProduct({"state": STATES, "manner": tuple(TIMES)})},']
    return lines


def _sensor_commands(sensor: Sensor) -> list[str]:
    name = word(sensor.name)
    if sensor.kind == "bool":
        return [f'                "set_{name} {level}": {{}},' for level in levels(sensor)]
    mark = f"  # {sensor.operation.place}" if sensor.is_certain else "  # TODO: between which numbers?"
    return [
        f'                "set_{name} {level}": {{"value": Range({low:g}, {high:g})}},{mark}'
        for level, (low, high) in zip(levels(sensor), (sensor.low, sensor.high), strict=True)
    ]


def _parameter(draft: Draft, port: Port) -> str:
    from pytest_hricdv.extra.draft.naming import unit_of

    unit = unit_of(port.name)
    low, high = (20.0, 30.0) if unit == "s" else (1.0, 2.0)
    return (
        f'                "{port.name}": Range({low}, {high}, "{unit}"),  # {port.place}; TODO: between which values?'
    )


def _disturbances(draft: Draft) -> list[str]:
    lines = []
    for message in draft.findings.messages:
        topic = message.topic
        lines.append(f'            "{topic}_lost": Lost("{topic}"),')
        if message.direction != "said":
            lines.append(f'            "{topic}_late": Late("{topic}", Range(0.5, 5.0, "s")),  # TODO: how late?')
            lines.append(
                f'            "{topic}_doubled": Doubled("{topic}", Range(0.1, 5.0, "s")),  # TODO: how much later?'
            )
    return lines


def _says(draft: Draft) -> list[str]:
    """The function that makes a message of a command."""
    if not draft.things:
        return []
    lines = [
        "",
        "",
        "def said(what: str, numbers: Mapping[str, float]) -> Any:",
        '    """The message that a person says, by the words of its command."""',
        *_import(draft, _needs(draft)),
        "",
    ]
    for thing in draft.things:
        for command, kind in thing.commands:
            arguments = ", ".join(_arguments(thing, dict(kind.values)))
            lines += [
                f'    if what == "{command}":',
                f"        return {thing.message.name}({arguments})  # {kind.place}",
            ]
    lines += ['    raise ValueError(f"nobody says {what}")']
    text = "\n".join(lines)
    if "_member(" in text:
        lines += ["", "", "def _member(kind: Any, text: str) -> Any:", '    """The member of an enumeration."""',
                  "    return next(member for member in kind if text_of(member) == text)"]  # fmt: skip
    return lines


def _needs(draft: Draft) -> list[tuple[str, str]]:
    needs = _classes(thing.message for thing in draft.things)
    for thing in draft.things:
        needs += [(thing.message.module or "ports", part.type) for part in thing.message.fields
                  if part.by_type and part.type.isidentifier() and part.kind == "str"
                  and any("_member(" in text for kind in thing.kinds for _, text in kind.values)]  # fmt: skip
    return needs


def _arguments(thing: Thing, values: dict[str, str]) -> list[str]:
    arguments = []
    for part in thing.message.fields:
        if part.name in values:
            arguments.append(f"{part.name}={values[part.name]}")
        elif part.kind == "float":
            number = f'numbers["{part.name}"]'
            arguments.append(f"{part.name}={f'round({number})' if part.type == 'int' else number}")
        elif not part.default:
            arguments.append(f"{part.name}={_BLANKS.get(part.type.partition('[')[0], 'None')}")
    return arguments


def _run(draft: Draft) -> list[str]:
    lines = [
        "def run(run: Run) -> Outcome:",
        '    """One test: a person, the robot\'s code, and the world, in virtual time."""',
        *_import(draft, [*_classes([*draft.answers, *draft.findings.said]), ("world", "World")]),
        "",
        "    world = World(run.kernel, run.recorder)",
        '    manner = ["in_time"]' if draft.states and draft.things else "",
        "    hits: list[tuple[str, str]] = []" if draft.states and draft.things else "",
        "",
        *_person(draft),
        "",
        *_notes(draft),
        *_robot(draft),
        "",
        f'    run.kernel.spawn("{draft.person}", person)',
        "    # Coverage is measured in here.",
        '    run.kernel.spawn("robot", run.measured(robot))',
        "    ended = run.go(LIMIT_S)",
        "    return Outcome(ended" + (', cross={"state and manner": hits})' if draft.states and draft.things else ")"),
    ]
    return [line for number, line in enumerate(lines) if line or (number and lines[number - 1])]


CLEARED = ["                for answer in answers:", "                    answer.clear()"]
"""What was said before is no answer."""


def _person(draft: Draft) -> list[str]:
    answers = ", ".join(message.name for message in draft.answers)
    answers += "," if len(draft.answers) == 1 else ""
    lines = [
        "    def person() -> None:",
        f'        bus = run.bus.port("{draft.person}")',
        f"        answers = [bus.subscribe(kind) for kind in ({answers})]" if answers else "",
        "        for action in run.actions():",
        '            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))',
        '            what, _, how = action.command.rpartition(" ")',
    ]
    branches: list[list[str]] = []
    if answers:
        branches.append(
            [
                '            if action.command == "wait_answer":',
                *([] if draft.things else ["                run.kernel.sleep(LOOKS_EACH_S)", *CLEARED]),
                "                ends_s = run.kernel.now_s + ANSWER_S",
                "                while run.kernel.now_s < ends_s and all(answer.poll() is None for answer in answers):",
                "                    run.kernel.sleep(LOOKS_EACH_S)",
            ]
        )
    else:
        branches.append(
            ['            if action.command == "wait_answer":', "                run.kernel.sleep(ANSWER_S / 10)"]
        )
    if draft.sensors:
        names = ", ".join(f'"set_{word(sensor.name)}": "{sensor.name}"' for sensor in draft.sensors)
        branches.append(
            [
                f"            elif what in (senses := {{{names}}}):",
                '                world.sense(senses[what], action.parameters.get("value", how == "yes"))',
            ]
        )
    if draft.things:
        branch = [
            "            else:",
            *(["                manner[0] = how"] if draft.states else []),
        ]
        if draft.answers:
            branch += CLEARED
        branch += [
            "                bus.publish(said(what, action.parameters))",
            '                if how == "twice":',
            '                    run.kernel.sleep(float(action.parameters["again_s"]))',
            "                    bus.publish(said(what, action.parameters))",
        ]
        branches.append(branch)
    lines += [line for branch in branches for line in branch]
    lines += [] if draft.findings.said else ['        world.record("person_is_there", False)']
    lines += ['        run.kernel.stop("the person has left")']
    return [line for line in lines if line]


def _notes(draft: Draft) -> list[str]:
    """Nodes that record what the robot says."""
    if not draft.signals:
        return []
    fields: dict[str, list[str]] = {}
    for signal in draft.signals:
        fields.setdefault(signal.topic, []).append(signal.field)
    state_topic, _, state_field = draft.findings.state.partition(".")
    lines = [
        "    def note(heard: Any, topic: str, fields: tuple[str, ...]) -> None:",
        "        while True:",
        "            message = heard.wait(LIMIT_S)",
        "            for field in fields if message is not None else ():",
        "                value = getattr(message, field)",
        "                value = value if isinstance(value, bool | int | float | str) else text_of(value)",
        "                signal = float(value) if type(value) is int else value",
        '                world.record(f"said_{topic}_{field}", signal)',
    ]
    if draft.states and draft.things:
        lines += [f'                if (topic, field) == ("{state_topic}", "{state_field}") and value in STATES:',
                  "                    hits.append((value, manner[0]))"]  # fmt: skip
    lines += ["", "    for kind, topic, fields in ("]
    for message in draft.findings.said:
        if message.topic in fields:
            lines.append(f'        ({message.name}, "{message.topic}", {tuple_text(fields[message.topic])}),')
    lines += ["    ):", '        heard = run.bus.port("observer").subscribe(kind)',
              "        run.kernel.spawn(f\"notes {topic}\", partial(note, heard, topic, fields))", ""]  # fmt: skip
    return lines


def _robot(draft: Draft) -> list[str]:
    entry = draft.entry
    if entry is None:
        return ["    def robot() -> None:", "        # TODO: nothing was found to call: call what runs the robot.",
                *(f"        import {name}  # noqa: F401" for name in draft.findings.code)]  # fmt: skip
    lines = []
    needs = [(entry.module, entry.name)]
    needs += [("ports", device_class(port)) for port in draft.devices]
    roles = {port.role for port in draft.ports if not port.default}
    needs += [("ports", "Stream")] if roles & {"reader", "writer"} and _streams(draft) else []
    channels = draft.findings.channels
    is_said = any(channel.direction == "said" for channel in channels)
    needs += [("ports", "Outbox")] if roles & {"publish", "queue"} or is_said else []
    is_heard = any(p.role == "queue" and p.direction != "said" for p in draft.ports)
    needs += [("ports", "Inbox")] if is_heard or any(channel.direction == "heard" for channel in channels) else []
    needs += _classes(message for message in draft.plain if message.form != "state")
    needs += [("ports", "look") for message in draft.plain if message.form == "state"]
    needs += [need for port in draft.ports if port.role in ("settings", "parameter") for need in port.needs]
    queues = [p for p in draft.ports if p.role == "queue" and p.direction != "said"]
    needs += _classes(thing.message for port in queues for thing in _things_of(draft, port))
    needs += [("ports", "Bus")] if bus_kind(draft) in ("async", "callback", "topics") else []
    imports = [line[4:] for line in _import(draft, needs)]
    making = f"make({', '.join(_handed(draft, port) for port in entry.ports if _is_handed(port))})"
    handed = ", ".join(_handed(draft, port) for port in entry.method_ports if _is_handed(port))
    called = f"made.{entry.method}({handed})" if entry.method else making
    if entry.is_made and not entry.method:
        called = ("asyncio.sleep" if entry.is_async else "run.kernel.sleep") + "(LIMIT_S)  # it is called back"
    made = [*_variables(draft), *([f"made = {making}"] if entry.is_made else []), *_attributes(draft)]
    looked_at = [message for message in draft.plain if message.form == "state"]
    made += [f'run.kernel.spawn("looks at {m.channel}", partial(look, run, made))  # {m.place}' for m in looked_at]
    body = [f"        {line}" for line in [*imports, "", f"make: Any = {entry.name}", *made]]
    if entry.is_async:
        lines = ["    async def program() -> None:", *body, f"        await {called}", ""]
        lines += ["    def robot() -> None:", "        asyncio.run(program())"]
    else:
        lines = ["    def robot() -> None:", *body, f"        {called}"]
    lines += [] if draft.findings.said else ['        world.record("robot_works", False)']
    return [*lines, '        run.kernel.stop("the robot has ended its work")']


def _variables(draft: Draft) -> list[str]:
    """Queues of the code's modules that are those of the test."""
    lines = []
    for channel in draft.findings.channels:
        if channel.variables:
            lines.append(f"{channel.name}_: Any = {_end(draft, channel.name, channel.direction)}  # {channel.place}")
            end = f"{channel.name}_"
            if channel.name == "print":
                end = 'lambda *parts, **_: print_(" ".join(map(str, parts)))'
            for module, name in channel.variables:
                lines += [f"import_module({json.dumps(module)}).__dict__[{json.dumps(name)}] = {end}"]
    return lines


def _attributes(draft: Draft) -> list[str]:
    """Queues that the robot makes itself, likewise."""
    return [
        f"made.{channel.attribute} = {_end(draft, channel.name, channel.direction)}  # {channel.place}"
        for channel in draft.findings.channels
        if channel.attribute
    ]


def _end(draft: Draft, name: str, direction: str) -> str:
    """The queue of the test for what comes or goes by a name."""
    if direction == "heard":
        things = [thing.message.name for thing in draft.things if thing.message.channel in ("", name)]
        return f"Inbox({', '.join(['run', *things])})"
    kinds = [m.name for m in draft.plain if m.channel in ("", name) and m.direction != "heard" and m.form != "state"]
    return f"Outbox({', '.join(['run', *kinds])})"


def _is_handed(port: Port) -> bool:
    return not port.default


def _handed(draft: Draft, port: Port) -> str:
    """What the code gets for a port."""
    name = f"{port.name}=" if port.keyword else ""
    if port.role == "bus":
        return name + ('run.bus.port("robot")' if bus_kind(draft) == "own" else "Bus(run)")
    if port.role == "clock":
        return name + "run.kernel"
    if port.role == "publish":
        return name + _end(draft, port.name.strip("_"), "said")
    if port.role == "queue":
        return name + _end(draft, port.name.strip("_"), "said" if port.direction == "said" else "heard")
    if port.role in ("reader", "writer") and _streams(draft):
        return name + f"Stream(run, {', '.join(_side(draft, port, side) for side in ('heard', 'said'))})"
    if port.role == "device":
        return name + f"{device_class(port)}(world)"
    if port in draft.parameters:
        number = f'run.test.run["{port.name}"]'
        return name + (f"round({number})" if port.annotation == "int" else number)
    return name + (port.made or "None")


def _streams(draft: Draft) -> bool:
    """Whether lines come or go."""
    return any(message.form == "line" for message in draft.plain)


def _side(draft: Draft, port: Port, side: str) -> str:
    """The messages that come or go by a stream."""
    names = [m.name for m in draft.plain if m.channel == port.name.strip("_") and m.direction == side]
    return f"({', '.join(names)}{',' if len(names) == 1 else ''})"


def _things_of(draft: Draft, port: Port) -> list[Thing]:
    """What comes through a queue."""
    return [thing for thing in draft.things if thing.message.channel in ("", port.name.strip("_"))]


def tuple_text(names: Iterable[str]) -> str:
    """Source text of a tuple of texts."""
    listed = [json.dumps(name, ensure_ascii=False) for name in names]
    return "(" + ", ".join(listed) + ("," if len(listed) == 1 else "") + ")"
