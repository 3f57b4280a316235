"""The testbench of a draft."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from pytest_hricdv.extra.draft.found.findings import Message, MessageField, Port
from pytest_hricdv.extra.draft.reading.naming import unit_of, word
from pytest_hricdv.extra.draft.surroundings.sensing import Sensor
from pytest_hricdv.extra.draft.writing.devices import called_classes
from pytest_hricdv.extra.draft.writing.drafted import OTHER, Draft, is_open
from pytest_hricdv.extra.draft.writing.model import (
    PASSES_S,
    SHORT,
    STAY_S,
    UNTIL_QUIET,
    WHOLE,
    groups,
    leaves,
    levels,
    meanwhile,
    neutral_beliefs,
    start_beliefs,
)
from pytest_hricdv.extra.draft.writing.observed import answer_s, lateness, reaction_lines, said_lines_of, times_of_lines
from pytest_hricdv.extra.draft.writing.run import run_lines, said_lines
from pytest_hricdv.extra.draft.writing.source_text import import_lines, message_classes, tuple_text

MOST_PATIENT_S, PATIENT = 60.0, 1.1
"""A person waits a little longer for an answer than the robot for anything, as far as that is not longer than this
(chosen: a run is to end some time)."""


def conftest(draft: Draft) -> str:
    """The module `conftest`."""
    lines = [*constants(draft), *_testbench(draft), *said_lines(draft), "", "", *run_lines(draft)]
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
    shadowed = [name for name in used if any(message.name == name for message in draft.messages)]
    body = _qualified(body, shadowed)
    head = [
        f'"""The testbench of {draft.robot}, drafted from its code: values have the place that they come from.',
        "",
        'TODO marks what the code does not say."""',
        "",
        "from __future__ import annotations",
        "",
        *(["import asyncio"] if "asyncio." in body else []),
        *(["import json"] if "json." in body else []),
        *(["from collections.abc import Mapping"] if "Mapping[" in body else []),
        *(["from functools import partial"] if "partial(" in body else []),
        *(["from importlib import import_module"] if "import_module(" in body else []),
        "from pathlib import Path",
        *(["from types import SimpleNamespace"] if "SimpleNamespace(" in body else []),
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


def _qualified(body: str, names: Sequence[str]) -> str:
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
    late_s, place = draft.late_s
    reason = f"longer than {place}" if place is not None else "TODO: the code has no time-out"
    waits_s, why = answer_s(draft, max(draft.patience_s, min(late_s, MOST_PATIENT_S) * PATIENT))
    lines = [
        "HERE = Path(__file__).parent",
        "",
        "LIMIT_S = 900.0  # no run needs as long; TODO",
        *reaction_lines(draft),
        *(["STEP_S = 0.1  # how often the robot's step is called; TODO"] if draft.is_step else []),
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
        lines += [line for thing in draft.things for line in said_lines_of(draft, thing)]
        lines += ["}", *times_of_lines(draft)]
    if draft.states:
        machine = next(machine for machine in draft.findings.machines if machine.told)
        lines += ["", "STATES = (", *(f"    {json.dumps(s.name)},  # {s.place}" for s in machine.states), ")"]
    return lines


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


def said_commands(draft: Draft) -> list[str]:
    """The commands of what a person says, and of waiting."""
    waits = ['                "wait_answer": {},']
    if draft.is_alone:
        return [f'                "stay {how}": {{"after_s": Range({low}, {high}, "s")}},  # TODO: how long?'
                for how, (low, high) in STAY_S.items()]  # fmt: skip
    if not draft.things:
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
    return [OTHER] if draft.has_others and message.direction != "said" and is_open(part) else []


def _testbench(draft: Draft) -> list[str]:
    findings = draft.findings
    values = [
        (f"{m.topic}.{p.name}", [*(v.text for v in p.values), *_others(draft, m, p)], p)
        for m in draft.messages for p in m.fields if p.values and not p.by_type and p.kind == "str"
    ]  # fmt: skip
    units = [(f"{m.topic}.{p.name}", p.unit) for m in draft.messages for p in m.fields if p.unit]
    units += [(s.name, p.unit) for s in draft.signals for m in draft.messages if m.topic == s.topic
              for p in m.fields if p.name == s.field and p.unit]  # fmt: skip
    called = [*called_classes(draft).values()]
    needs = [*message_classes(draft.messages), *(("ports", name) for name in called), ("world", "SIGNALS")]
    names = ", ".join((*(message.name for message in draft.messages), *called))
    lines = [
        "",
        "",
        "def pytest_hricdv_testbench(config: object) -> Testbench:",
        '    """What the plugin asks for."""',
        *_stand_in(draft),
        *import_lines(draft, needs),
        "",
        *declared_model(draft),
    ]
    lines += said_commands(draft)
    for sensor in draft.sensors:
        lines += _sensor_commands(sensor)
    for how, (low, high) in PASSES_S.items() if meanwhile(draft) else ():
        lines.append(f'                "let_pass {how}": {{"after_s": Range({low}, {high}, "s")}},  # TODO: how long?')
    lines += ["            },"]
    if draft.parameters:
        lines += ["            run={", *(_parameter(draft, port) for port in draft.parameters), "            },"]
    lines += [
        "        ),",
        '        requirements=HERE / "requirements.toml",',
        f"        messages=({names}{',' if len(draft.messages) + len(called) == 1 else ''}),",
        "        signals=SIGNALS,",
    ]
    if values:
        lines += ["        values={"]
        for name, texts, part in values:
            if part.is_partial and name != findings.state:  # a testbench that declares some refuses the others
                place = part.values[0].place
                lines.append(f'            # "{name}": {tuple_text(texts)},  # {place}; TODO: which others?')
                continue
            likely = any(value.certainty == "likely" for value in part.values)
            mark = f"  # {part.values[0].place}" + ("; TODO: some are of a docstring" if likely else "")
            lines.append(f'            "{name}": {tuple_text(texts)},{mark}')
        lines.append("        },")
    if units:
        lines += ["        units={", *(f'            "{name}": "{unit}",' for name, unit in units), "        },"]
    lines.append(f"        code={tuple_text(findings.code)},")
    if findings.virtual:
        lines.append(f"        virtual={tuple_text(findings.virtual)},  # the code imports them")
    lines += ["        run=run,", *may_end_lines(draft)]
    lines += _state_part(draft)
    if draft.messages:
        lines += ["        disturbances={", *_disturbances(draft), "        },"]
    return [*lines, "    )"]


def may_end_lines(draft: Draft) -> list[str]:
    """How runs may end, beside that the person leaves or the robot returns; none where all first runs did so."""
    if not draft.may_end:
        return []
    return [f"        may_end={tuple_text(draft.may_end)},  # TODO: which ends are right?"]


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
    if sensor.motion is not None:
        short = f'                "set_{name} {SHORT}": {{"share": Range(0.1, 0.9)}},  # TODO: how short?'
        return [short, f'                "set_{name} {WHOLE}": {{}},']
    if sensor.kind == "bool":
        return [f'                "set_{name} {level}": {{}},' for level in levels(sensor)]
    mark = f"  # {sensor.operation.place}" if sensor.is_certain else "  # TODO: between which numbers?"
    return [
        f'                "set_{name} {level}": {{"value": Range({low:g}, {high:g})}},{mark}'
        for level, (low, high) in zip(levels(sensor), (sensor.low, sensor.high), strict=True)
    ]


def _parameter(draft: Draft, port: Port) -> str:
    unit = unit_of(port.name)
    low, high = (20.0, 30.0) if unit == "s" else (1.0, 2.0)
    return (
        f'                "{port.name}": Range({low}, {high}, "{unit}"),  # {port.place}; TODO: between which values?'
    )


def _disturbances(draft: Draft) -> list[str]:
    lines = []
    state_topic = draft.findings.state.partition(".")[0]
    for message in draft.findings.messages:
        topic = message.topic
        # Without the message that tells a state, the robot would seem to go from the one before to the one after.
        if topic != state_topic:
            lines.append(f'            "{topic}_lost": Lost("{topic}"),')
        if message.direction != "said":
            ends, mark = lateness(draft, topic)
            lines.append(f'            "{topic}_late": Late("{topic}", Range({ends}, "s")),  # {mark}')
            lines.append(
                f'            "{topic}_doubled": Doubled("{topic}", Range(0.1, 5.0, "s")),  # TODO: how much later?'
            )
    return lines
