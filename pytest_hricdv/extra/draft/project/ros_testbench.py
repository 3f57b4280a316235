"""The testbench of a draft for a node of ROS 2."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence

from pytest_hricdv.extra.draft.code.classes import ARRAY_LENGTH, FAR
from pytest_hricdv.extra.draft.project.declarations import (
    command_table_lines,
    disturbance_lines,
    is_constant,
    model_lines,
    state_lines,
    time_lines,
    times_lines,
    tuple_text,
)
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.driver import comment_lines
from pytest_hricdv.extra.draft.project.inputs import Input
from pytest_hricdv.extra.draft.project.ranges import command_lines
from pytest_hricdv.extra.draft.ros_model import Endpoint, RosStart

_MAPS = {
    "TOPICS": ("publisher", "subscription"),
    "SERVICES": ("service", "client"),
    "ACTIONS": ("action server", "action client"),
}

_FILLED = '''

def made(kind: str, fields: Mapping[str, Any]) -> Any:
    """A message of a type such as "std_msgs/msg/Bool", with these fields; those of messages in it have paths."""
    package, folder, name = kind.split("/")
    message = getattr(import_module(f"{package}.{folder}"), name)()
    for path, value in fields.items():
        *owners, last = path.split(".")
        part = message
        for owner in owners:
            part = getattr(part, owner)
        setattr(part, last, value)
    return message
'''

_PERSON = """
    def person() -> None:
        node = ros.node("{person}")
        publishers = {name: node.publisher(name, TOPICS[name]) for name in HEARD}
        services = {name: node.client(name, SERVICES[name]) for name in SERVED}
        actions = {name: node.action(name, ACTIONS[name]) for name in DONE}
        answers = [node.subscribe(name, TOPICS[name]) for name in SAID]

        def say(what: str, numbers: Mapping[str, float]) -> None:
            name, fields = said(what, numbers)
{tells}            if name in publishers:
                publishers[name].publish(made(TOPICS[name], fields))
            elif name in services:
                services[name].call(ANSWER_S, **fields)
            else:
                actions[name].call(ANSWER_S, **fields)

        for action in run.actions():
            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))
            what, _, how = action.command.rpartition(" ")
{stays}            if action.command == "wait_answer":
                ends_s = run.kernel.now_s + (ANSWER_S if answers else 1.0)
                while run.kernel.now_s < ends_s and all(answer.poll() is None for answer in answers):
                    run.kernel.sleep(LOOKS_EACH_S)
                continue
            for answer in answers:
                while answer.poll() is not None:  # what was said before is no answer
                    pass
            say(what, action.parameters)
            if how == "twice":
                run.kernel.sleep(float(action.parameters["again_s"]))
                say(what, action.parameters)
{leaves}        run.kernel.stop("the person has left")

    run.kernel.spawn("{person}", person)
    return Outcome(run.go(LIMIT_S))
"""

_TELLS = """            for field, value in fields.items():
                if isinstance(value, list):  # of it the record has the length: a signal tells the numbers
                    signal = f"{name.strip('/')}_{field}".replace("/", "_").replace(".", "_")
                    run.recorder.signal(run.kernel.now_s, signal, value[0])
"""

_STAYS = """            if what == "stay":  # after_s has passed
                continue
"""


def ros_conftest(draft: Draft, start: RosStart) -> str:
    """The module `conftest`."""
    body = "\n".join(
        [*_constants(draft), "", *_declarations(draft, start), *_testbench(draft, start), *_message_function(draft)]
    )
    body += _FILLED + "\n" + "\n".join(_run(draft, start))
    names = ("BeliefSpace", "Concretization", "Delay", "Drop", "Duplicate", "Field", "Model", "Outcome",
             "Ros2", "RosNode", "Run", "StateField", "Testbench", "Uniform", "VirtualTime")  # fmt: skip
    head = [
        f'"""The testbench of {draft.robot}, a node of ROS 2, drafted from its code: values have their locations.',
        "",
        'TODO marks what the code does not say."""',
        "",
        "from __future__ import annotations",
        "",
        "from collections.abc import Mapping",
        "from importlib import import_module",
        "from pathlib import Path",
        "from typing import Any",
        "",
        *(["from pytest_hricdv.draft import replace_modules"] if draft.absent_modules else []),
        "from pytest_hricdv.testbench import (",
        *(f"    {name}," for name in names if f"{name}(" in body or name == "Run"),
        ")",
        "",
        "",
    ]
    return "\n".join(head) + body


def _constants(draft: Draft) -> list[str]:
    """Times, and what a person can say."""
    lines = times_lines(draft, "LOOKS_EACH_S = 0.25  # how often a person looks whether there is one")
    if draft.inputs:
        lines += ["", "# What a person can say to the robot, with the numbers in it.",
                  "SAYS: dict[str, dict[str, Uniform]] = {"]  # fmt: skip
        lines += [line for thing in draft.inputs for line in command_lines(thing)]
        lines += ["}"]
    said = {command for thing in draft.inputs for command, _ in thing.commands}
    rest = [line for thing in draft.whole.inputs for line in command_lines(thing.without(said))]
    return [*lines, *comment_lines(rest)]


def _declarations(draft: Draft, start: RosStart) -> list[str]:
    """The topics, services, actions and parameters of the node, each with its place."""
    lines = []
    for name, kinds in _MAPS.items():
        declared = _unique([endpoint for endpoint in start.declared if endpoint.kind in kinds])
        entries = [f"    {json.dumps(e.name)}: {json.dumps(e.type)},  # {e.location}" for e in declared]
        lines += [f"{name}: dict[str, str] = {{", *entries, "}"] if entries else [f"{name}: dict[str, str] = {{}}"]
    lines += ["", "# What the person says to the node, asks of it, and lets it do; and what they wait for."]
    for name, kind in (
        ("HEARD", "subscription"),
        ("SERVED", "service"),
        ("DONE", "action server"),
        ("SAID", "publisher"),
    ):
        texts = [endpoint.name for endpoint in _unique([e for e in start.declared if e.kind == kind])]
        lines.append(f"{name}: tuple[str, ...] = {tuple_text(texts)}")
    parameters: dict[str, str] = {}
    for parameter in draft.code.ros.parameters:
        if is_constant(parameter.default):
            parameters.setdefault(
                parameter.name, f"    {json.dumps(parameter.name)}: {parameter.default},  # {parameter.location}"
            )
    lines += ["", "# As the code declares them. TODO: with which values does your robot start it?"]
    return [*lines, "PARAMETERS: dict[str, Any] = {", *parameters.values(), "}"]


def _unique(endpoints: Sequence[Endpoint]) -> list[Endpoint]:
    return list({endpoint.name: endpoint for endpoint in reversed(endpoints)}.values())[::-1]


def _testbench(draft: Draft, start: RosStart) -> list[str]:
    machine = draft.code.machine
    values = [(f"{m.topic}.{p.name}", [v.text for v in p.values], p.values[0].location)
              for m in draft.messages for p in m.fields if p.values]  # fmt: skip
    values += [(machine.field, list(draft.states), machine.location)] if machine is not None else []
    interfaces = [os.path.relpath(folder, draft.folder) for folder in start.interfaces]
    ros = "".join(f'HERE / "{folder}", ' for folder in interfaces)
    virtual = list(dict.fromkeys(name.partition(".")[0] for name in draft.code.modules if "." in name))
    lines = [
        "", "", "def pytest_hricdv_testbench(config: object) -> Testbench:",
        '    """What the plugin asks for."""',
        *draft.replacement_lines,
        *model_lines(draft),
    ]  # fmt: skip
    lines += command_table_lines(draft, "SAYS", "numbers", "numbers")
    lines += ["            },", "        ),",
              '        requirements=HERE / "requirements.toml",', "        messages=(),"]  # fmt: skip
    signals = ['"person_is_there": bool'] if draft.tells_presence else []
    signals += [f'"{name}": float' for name in _lists(draft)]
    lines.append(f"        signals={{{', '.join(signals)}}},")
    if values:
        lines += [
            "        fields={",
            *(f'            "{n}": Field(values={tuple_text(t)}),  # {p}' for n, t, p in values),
            "        },",
        ]
    lines += [
        f"        code={tuple_text(draft.code.modules)},",
        "        ros2=Ros2(",
        "            topics=TOPICS,",
        "            services=SERVICES,",
        "            actions=ACTIONS,",
        *([f"            interfaces=({ros.rstrip()}),"] if interfaces else []),
        *([f"            packages={tuple_text(virtual)},  # all of them see virtual time"] if virtual else []),
        "        ),",
        "        run=run,",
        *time_lines(draft),
        *state_lines(draft),
    ]
    return [*lines, *disturbance_lines(draft), "    )"]


def _lists(draft: Draft) -> list[str]:
    """The signals that tell what a person says in lists of numbers, such as the ranges of a scan."""
    return [f"{thing.message.channel.strip('/')}_{part.name}".replace("/", "_").replace(".", "_")
            for thing in draft.inputs for part in thing.message.fields if part.type == "list"]  # fmt: skip


def _message_function(draft: Draft) -> list[str]:
    """The function that says what a command means."""
    lines = [
        "", "", "def said(what: str, numbers: Mapping[str, float]) -> tuple[str, dict[str, Any]]:",
        '    """The topic, service or action of a command, and the fields of the message, request or goal."""',
    ]  # fmt: skip
    for thing in draft.inputs:
        for command, variant in thing.commands:
            texts = ", ".join(
                f"{json.dumps(name)}: {text}" for name, text in _fields(thing, dict(variant.values)).items()
            )
            lines += [
                f'    if what == "{command}":',
                f"        return {json.dumps(thing.message.channel)}, {{{texts}}}  # {variant.location}",
            ]
    return [*lines, '    raise ValueError(f"nobody says {what}")', ""]


def _fields(thing: Input, values: dict[str, str]) -> dict[str, str]:
    """Source text of each field that is set."""
    texts = {}
    for part in thing.message.fields:
        number = f'numbers["{part.name}"]'
        if part.name in values:
            texts[part.name] = values[part.name]
        elif part.kind == "float":
            texts[part.name] = {"int": f"round({number})", "list": f"[{number}] * {ARRAY_LENGTH}"}.get(
                part.type, number
            )
    return texts


def _run(draft: Draft, start: RosStart) -> list[str]:
    lines = [
        "", "def run(run: Run) -> Outcome:",
        '    """One test: a person and the node, in virtual time."""',
        f'    ros = run.ros2(RosNode(entry="{start.entry}", parameters=[PARAMETERS]))',
    ]  # fmt: skip
    asked = _unique([endpoint for endpoint in start.declared if endpoint.kind in ("client", "action client")])
    served = {e.name for e in start.declared if e.kind in ("service", "action server")}
    asked = [endpoint for endpoint in asked if endpoint.name not in served]
    if asked:
        lines += ["", "    # What the node asks of others. TODO: what do they answer, and what do they do?",
                  '    others = ros.node("others")']  # fmt: skip
    for endpoint in asked:
        name = json.dumps(endpoint.name)
        if endpoint.kind == "client":
            lines.append(
                f"    others.serve({name}, SERVICES[{name}], lambda request, response: response)  # {endpoint.location}"
            )
        else:
            lines.append(
                f"    others.serve_action({name}, ACTIONS[{name}], lambda goal: goal.succeed())  # {endpoint.location}"
            )
    silent = draft.tells_presence
    leaves = '        run.recorder.signal(run.kernel.now_s, "person_is_there", False)\n' if silent else ""
    if silent:
        lines += ['    run.recorder.signal(0.0, "person_is_there", True)']
    lines += [f'    run.recorder.signal(0.0, "{name}", {FAR})' for name in _lists(draft)]
    person = _PERSON.replace("{stays}", _STAYS if draft.is_alone else "")
    person = person.replace("{tells}", _TELLS if _lists(draft) else "")
    return [*lines, person.replace("{person}", draft.person).replace("{leaves}", leaves).rstrip("\n"), ""]
