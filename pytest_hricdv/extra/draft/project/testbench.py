"""Writes the `conftest.py` of a draft: its testbench, with the driver that runs the robot among stand-ins."""

from __future__ import annotations

import json
import re

from pytest_hricdv.extra.draft.code.naming import unit_of, word
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Message, MessageField, Port
from pytest_hricdv.extra.draft.project.declarations import (
    ImportTable,
    command_table_lines,
    disturbance_lines,
    import_lines,
    model_lines,
    state_lines,
    times_lines,
    tuple_text,
    virtual_time_lines,
)
from pytest_hricdv.extra.draft.project.draft import Draft, Sensor
from pytest_hricdv.extra.draft.project.driver import driver_lines, has_cross, say_lines
from pytest_hricdv.extra.draft.project.inputs import OTHER, is_open
from pytest_hricdv.extra.draft.project.node_driver import node_driver_lines, ros2_lines

TESTBENCH = ("BeliefSpace", "Concretization", "CrossProduct", "Delay", "Drop", "Duplicate", "Field", "Model",
             "StateField", "Testbench", "Uniform", "VirtualTime")  # fmt: skip
STAND_INS = ("Array", "Neutral", "BusPort", "CallbackCall", "ClockPort", "ConnectionPort", "Device", "RunParameter",
             "Driver", "InboxPort", "Make", "Manners", "MethodCall", "NodeDriver", "OutboxPort", "ProgramPort",
             "Replace", "Say", "Script", "member", "replace_modules", "unknown")  # fmt: skip
STANDARD = ("Path", "json", "import_module")
TAKEN = ("HERE", "TIMES", "STATES", "LIMIT_S", "ANSWER_S", "STAYS_S", "says", "driver", "config", "name")
"""Names that `conftest.py` uses, with those above: equal names of the code are imported under others."""

_CROSS = '        cross={"state and manner": CrossProduct({"state": STATES, "manner": tuple(TIMES)})},'


def conftest(draft: Draft) -> str:
    """The text of `conftest.py`."""
    table = ImportTable((*TESTBENCH, *STAND_INS, *STANDARD, *TAKEN))
    driver = node_driver_lines(draft, draft.ros) if draft.ros is not None else driver_lines(draft, table)
    function = [*say_lines(draft, table), *driver, *_testbench(draft)]
    body = [
        *_constants(draft),
        "",
        "",
        "def pytest_hricdv_testbench(config: object) -> Testbench:",
        '    """The testbench that the plugin runs."""',
        *draft.replacement_lines,
        *table.lines(),
        "",
        *function,
    ]
    text = "\n".join(line.rstrip() for line in body) + "\n"
    return "\n".join([*_head(draft, text), "", ""]) + text


def _head(draft: Draft, body: str) -> list[str]:
    def used(names: tuple[str, ...]) -> list[str]:
        code = re.sub(r"^ *#.*", "", body, flags=re.MULTILINE)
        return [name for name in names if re.search(rf"(?<![\w.'\"]){name}\b", code)]

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
        "",
        *import_lines("pytest_hricdv.draft", used(STAND_INS)),
        *import_lines("pytest_hricdv.testbench", used(TESTBENCH)),
    ]


def _constants(draft: Draft) -> list[str]:
    """Times and states."""
    lines = times_lines(draft)
    if draft.code.machine is not None and draft.ros is None:
        states = draft.code.machine.states
        lines += ["", "STATES = (", *(f"    {json.dumps(s.name)},  # {s.location}" for s in states), ")"]
    return lines


# --- the testbench


def _testbench(draft: Draft) -> list[str]:
    lines = ["", *model_lines(draft), *command_table_lines(draft)]
    for sensor in draft.sensors:
        lines += _sensor_commands(sensor)
    lines += ["            },"]
    if draft.parameters:
        lines += ["            run={", *(_parameter(port) for port in draft.parameters), "            },"]
    lines += [
        "        ),",
        '        requirements=HERE / "requirements.toml",',
        f"        messages={'driver.messages' if draft.ros is None else '()'},",
        "        signals=driver.signals,",
        *_fields(draft),
        f"        code={tuple_text(draft.code.modules)},",
        *(ros2_lines(draft, draft.ros) if draft.ros is not None else []),
        "        run=driver.run,",
        *virtual_time_lines(draft),
        *state_lines(draft),
        *([_CROSS] if has_cross(draft) else []),
    ]
    return [*lines, *disturbance_lines(draft), "    )"]


def _others(message: Message, part: MessageField) -> list[str]:
    """A text that a person says too, and the code does not know."""
    return [OTHER] if message.direction != "published" and is_open(part) else []


def _fields(draft: Draft) -> list[str]:
    lines = []
    for message in draft.messages:
        for part in message.fields:
            name = f"{message.topic}.{part.name}"
            if part.values and part.kind == "str" and (not part.by_type or message.module == OWN_MODULE):
                texts = [*(value.text for value in part.values), *_others(message, part)]
                if message.form == "called":
                    continue
                is_known = not draft.has_open_states if name == draft.code.state else not part.is_partial
                head = "" if is_known else "# "  # a testbench that declares some refuses the others
                mark = str(part.values[0].location) + ("" if is_known else "; TODO: which others?")
                lines.append(f'            {head}"{name}": Field(values={tuple_text(texts)}),  # {mark}')
            if part.unit:
                lines.append(f'            "{name}": Field(unit="{part.unit}"),')
    return ["        fields={", *lines, "        },"] if lines else []


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
