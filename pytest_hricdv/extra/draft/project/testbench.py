"""The testbench of a draft."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from pytest_hricdv.extra.draft.code.naming import unit_of, word
from pytest_hricdv.extra.draft.code_model import Message, MessageField, Port
from pytest_hricdv.extra.draft.project.draft import Draft, Sensor, import_lines, message_imports, tuple_text
from pytest_hricdv.extra.draft.project.inputs import OTHER, is_open
from pytest_hricdv.extra.draft.project.model import (
    START_BELIEFS,
    STAY_S,
    UNTIL_QUIET,
    belief_groups,
    leaves,
    levels,
    neutral_beliefs,
)
from pytest_hricdv.extra.draft.project.ranges import (
    answer_s,
    command_lines,
    lateness,
    reaction_lines,
    times_of_lines,
)
from pytest_hricdv.extra.draft.project.run import command_function_lines, run_lines

MAX_PATIENCE_S, PATIENCE = 60.0, 1.1
"""A person waits a little longer for an answer than the robot waits for anything, up to a limit: a run is to end."""


def conftest(draft: Draft) -> str:
    """The module `conftest`."""
    lines = [*constants(draft), *_testbench(draft), *command_function_lines(draft), "", "", *run_lines(draft)]
    body = "\n".join(line.rstrip() for line in lines) + "\n"
    names = [
        "BeliefSpace",
        "Concretization",
        "CrossProduct",
        "Delay",
        "Drop",
        "Duplicate",
        "Field",
        "Model",
        "Outcome",
        "Run",
        "Signal",
        "StateField",
        "Testbench",
        "Uniform",
        "VirtualTime",
    ]
    used = [name for name in names if f"{name}(" in body or name in ("Outcome", "Run", "Testbench")]
    shadowed = [name for name in used if any(message.name == name for message in draft.messages)]
    body = _qualify(body, shadowed)
    head = [
        f'"""The testbench of {draft.robot}, drafted from its code: each value has the location that it comes from.',
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
        *(["from pytest_hricdv import testbench"] if shadowed else []),
        *(["from pytest_hricdv.runtime import text_of"] if "text_of(" in body else []),
        "from pytest_hricdv.testbench import (",
        *(f"    {name}," for name in used),
        ")",
        "",
        "",
    ]
    return "\n".join(head) + body


def _qualify(body: str, names: Sequence[str]) -> str:
    """The source text, in which a call is of the testbench where the code has a class of that name, too.

    Functions import the classes of messages; only `said` makes messages.
    """
    before, said, after = body.partition("\ndef said(")
    makes, end, rest = after.partition("\n\n\n")
    for name in names:
        called = re.compile(rf"(?<![\w.]){name}\(")
        before, rest = called.sub(f"testbench.{name}(", before), called.sub(f"testbench.{name}(", rest)
    return before + said + makes + end + rest


def constants(draft: Draft) -> list[str]:
    """The constants of a testbench: times, and what a person can say."""
    late_s, location = draft.late_s
    reason = f"longer than {location}" if location is not None else "TODO: the code has no time-out"
    waits_s, why = answer_s(draft, max(draft.patience_s, min(late_s, MAX_PATIENCE_S) * PATIENCE))
    lines = [
        "HERE = Path(__file__).parent",
        "",
        "LIMIT_S = 900.0  # no run needs as long; TODO",
        *reaction_lines(draft),
        f"ANSWER_S = {waits_s:g}  # so long a person waits for an answer; {why}",
        *(
            ["STAYS_S = 5 * ANSWER_S  # so long a person stays at most until the robot says nothing more; TODO"]
            if leaves(draft)
            else []
        ),
        "LOOKS_EACH_S = 0.25  # how often a person looks whether there is one",
        "",
        "# When a person does something, and how often. TODO: what is right for your people?",
        "TIMES = {",
        '    "in_time": {"after_s": Uniform(0.5, 2.0, "s")},',
        '    "too_early": {"after_s": Uniform(0.0, 0.05, "s")},',
        f'    "too_late": {{"after_s": Uniform({late_s * 1.1:g}, {late_s * 1.5:g}, "s")}},  # {reason}',
        '    "twice": {"after_s": Uniform(0.5, 2.0, "s"), "again_s": Uniform(0.1, 1.0, "s")},',
        "}",
    ]
    if draft.inputs:
        lines += [
            "",
            "# What a person can say to the robot, with the numbers in it.",
            "SAYS: dict[str, dict[str, Uniform]] = {",
        ]
        lines += [line for thing in draft.inputs for line in command_lines(draft, thing)]
        lines += ["}", *times_of_lines(draft)]
    if draft.code.machine is not None:
        states = draft.code.machine.states
        lines += ["", "STATES = (", *(f"    {json.dumps(s.name)},  # {s.location}" for s in states), ")"]
    return lines


def _stand_in(draft: Draft) -> list[str]:
    if not draft.absent_modules:
        return []
    return ["    from ports import stand_in_for_missing_modules", "", "    stand_in_for_missing_modules()"]


def model_lines(draft: Draft) -> list[str]:
    """The lines of a testbench down to its commands: name, model, beliefs."""
    covered = f'"{draft.person}", "robot"' if draft.inputs else f'"{draft.person}",'
    return [
        "    return Testbench(",
        f'        name="{draft.robot}",',
        "        model=Model(",
        f'            HERE / "models" / "{draft.robot}.mas2j",',
        f'            actor="{draft.person}",',
        f"            covered=({covered}),",
        "        ),",
        "        beliefs=BeliefSpace(",
        f"            start={tuple_text(START_BELIEFS)},",
        "            groups={",
        *(
            f"                {json.dumps(name)}: {tuple_text(beliefs)},"
            for name, beliefs in belief_groups(draft).items()
        ),
        "            },",
        *([f"            default_beliefs={tuple_text(neutral_beliefs(draft))},"] if neutral_beliefs(draft) else []),
        "        ),",
        "        concretization=Concretization(",
        "            commands={",
    ]


def command_table_lines(draft: Draft) -> list[str]:
    """The commands of what a person says, and of waiting."""
    waits = ['                "wait_answer": {},']
    if draft.is_alone:
        return [f'                "stay {how}": {{"after_s": Uniform({low}, {high}, "s")}},  # TODO: how long?'
                for how, (low, high) in STAY_S.items()]  # fmt: skip
    if not draft.inputs:
        return waits
    waits += [f'                "{UNTIL_QUIET}": {{}},'] if leaves(draft) else []
    times = (
        "**times, **TIMES_OF.get(what, {}).get(how, {}), **numbers" if times_of_lines(draft) else "**times, **numbers"
    )
    return [
        "                **{",
        f'                    f"{{what}} {{how}}": {{{times}}}',
        "                    for what, numbers in SAYS.items()",
        "                    for how, times in TIMES.items()",
        "                },",
        *waits,
    ]


def _others(draft: Draft, message: Message, part: MessageField) -> list[str]:
    """A text that a person says too, and the code does not know."""
    return [OTHER] if draft.has_others and message.direction != "published" and is_open(part) else []


def _testbench(draft: Draft) -> list[str]:
    code = draft.code
    values = [
        (f"{m.topic}.{p.name}", [*(v.text for v in p.values), *_others(draft, m, p)], p)
        for m in draft.messages for p in m.fields if p.values and not p.by_type and p.kind == "str"
    ]  # fmt: skip
    units = {f"{m.topic}.{p.name}": p.unit for m in draft.messages for p in m.fields if p.unit}
    signals = [(s.name, p.unit) for s in draft.signals for m in draft.messages if m.topic == s.topic
               for p in m.fields if p.name == s.field and p.unit]  # fmt: skip
    called = [*draft.classes_of_calls.values()]
    needs = [*message_imports(draft.messages), *(("ports", name) for name in called), ("world", "SIGNALS")]
    names = ", ".join((*(message.name for message in draft.messages), *called))
    lines = [
        "",
        "",
        "def pytest_hricdv_testbench(config: object) -> Testbench:",
        '    """What the plugin asks for."""',
        *_stand_in(draft),
        *import_lines(draft, needs),
        "",
        *model_lines(draft),
    ]
    lines += command_table_lines(draft)
    for sensor in draft.sensors:
        lines += _sensor_commands(sensor)
    lines += ["            },"]
    if draft.parameters:
        lines += ["            run={", *(_parameter(draft, port) for port in draft.parameters), "            },"]
    lines += [
        "        ),",
        '        requirements=HERE / "requirements.toml",',
        f"        messages=({names}{',' if len(draft.messages) + len(called) == 1 else ''}),",
        *_signal_lines(signals),
    ]
    if values or units:
        lines += ["        fields={"]
        for name, texts, part in values:
            location = part.values[0].location
            if part.is_partial and name != code.state:  # a testbench that declares some refuses the others
                lines.append(
                    f'            # "{name}": Field(values={tuple_text(texts)}),  # {location}; TODO: which others?'
                )
                continue
            lines.append(f'            "{name}": Field(values={tuple_text(texts)}),  # {location}')
        lines += [*(f'            "{name}": Field(unit="{unit}"),' for name, unit in units.items()), "        },"]
    lines.append(f"        code={tuple_text(code.modules)},")
    lines += ["        run=run,", *time_lines(draft, code.virtual)]
    lines += _state_part(draft)
    if draft.messages:
        lines += ["        disturbances={", *_disturbances(draft), "        },"]
    return [*lines, "    )"]


def _signal_lines(units: Sequence[tuple[str, str]]) -> list[str]:
    if not units:
        return ["        signals=SIGNALS,"]
    lines = [f'            "{name}": Signal(SIGNALS["{name}"], unit="{unit}"),' for name, unit in units]
    return ["        signals={", "            **SIGNALS,", *lines, "        },"]


def time_lines(draft: Draft, apis: Sequence[str] = ()) -> list[str]:
    """Which blocking APIs the code uses, and how runs may end without that the person leaves or the robot returns."""
    lines = [f"            apis={tuple_text(apis)},  # the code imports them"] if apis else []
    endings = draft.allowed_endings
    lines += [f"            allowed_endings={tuple_text(endings)},  # TODO: which ends are right?"] if endings else []
    return ["        time=VirtualTime(", *lines, "        ),"] if lines else []


def _state_part(draft: Draft) -> list[str]:
    if not draft.states:
        return []
    lines = ["        state=StateField(", f'            "{draft.code.state}",']
    if draft.transitions:
        lines += ["            transitions=("]
        lines += [
            f"                ({json.dumps(a)}, {json.dumps(b)}),  # {location}" for a, b, location in draft.transitions
        ]
        lines += ["            ),"]
    lines += ["        ),"]
    if draft.inputs:
        lines += ['        cross={"state and manner": CrossProduct({"state": STATES, "manner": tuple(TIMES)})},']
    return lines


def _sensor_commands(sensor: Sensor) -> list[str]:
    name = word(sensor.name)
    if sensor.kind == "bool":
        return [f'                "set_{name} {level}": {{}},' for level in levels(sensor)]
    return [
        f'                "set_{name} {level}": {{"value": Uniform({low}, {high})}},  # TODO: between which numbers?'
        for level, (low, high) in zip(levels(sensor), ((0.0, 1.0), (1.0, 2.0)), strict=True)
    ]


def _parameter(draft: Draft, port: Port) -> str:
    unit = unit_of(port.name)
    low, high = (20.0, 30.0) if unit == "s" else (1.0, 2.0)
    return f'                "{port.name}": Uniform({low}, {high}, "{unit}"),  # {port.location}; TODO: which values?'


def _disturbances(draft: Draft) -> list[str]:
    lines = []
    state_topic = draft.code.state.partition(".")[0]
    for message in draft.code.messages:
        topic = message.topic
        # Without the message that tells a state, the robot would seem to go from the one before to the one after.
        if topic != state_topic:
            lines.append(f'            "{topic}_lost": Drop("{topic}"),')
        if message.direction != "published":
            ends, mark = lateness(draft, topic)
            lines.append(f'            "{topic}_late": Delay("{topic}", Uniform({ends}, "s")),  # {mark}')
            lines.append(
                f'            "{topic}_doubled": Duplicate("{topic}", Uniform(0.1, 5.0, "s")),  # TODO: how much later?'
            )
    return lines
