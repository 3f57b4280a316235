"""The run of a drafted testbench: the person, the node that calls the robot's code, and what is recorded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code_model import MessageField, Port
from pytest_hricdv.extra.draft.project.draft import Draft, import_lines, message_imports, tuple_text
from pytest_hricdv.extra.draft.project.inputs import Input
from pytest_hricdv.extra.draft.project.model import UNTIL_QUIET, leaves
from pytest_hricdv.extra.draft.project.ports import bus_class, device_class


def command_function_lines(draft: Draft) -> list[str]:
    """The function that makes a message of a command."""
    if not draft.inputs:
        return []
    lines = [
        "",
        "",
        "def said(what: str, numbers: Mapping[str, float]) -> Any:",
        '    """The message that a person says, by the words of its command."""',
        *import_lines(draft, _imports(draft)),
        "",
    ]
    for thing in draft.inputs:
        for command, variant in thing.commands:
            arguments = ", ".join(_arguments(thing.message.fields, dict(variant.values)))
            lines += [
                f'    if what == "{command}":',
                f"        return {thing.message.name}({arguments})  # {variant.location}",
            ]
    lines += ['    raise ValueError(f"nobody says {what}")']
    text = "\n".join(lines)
    if "_member(" in text:
        lines += ["", "", "def _member(kind: Any, text: str) -> Any:", '    """The member of an enumeration."""',
                  "    return next(member for member in kind if text_of(member) == text)"]  # fmt: skip
    return lines


def _imports(draft: Draft) -> list[tuple[str, str]]:
    imports = message_imports(thing.message for thing in draft.inputs)
    for part in (part for thing in draft.inputs for part in thing.message.fields):
        if part.by_type or not (part.kind or part.default):
            imports += part.imports
    return imports


def _arguments(parts: Iterable[MessageField], values: Mapping[str, str]) -> Iterator[str]:
    """The fields of a message; those of which nothing is drawn have their defaults, or a neutral value."""
    for part in parts:
        if part.name in values:
            yield f"{part.name}={values[part.name]}"
        elif part.kind == "float":
            number = f'numbers["{part.name}"]'
            yield f"{part.name}={f'round({number})' if part.type == 'int' else number}"
        elif not part.default:
            yield f"{part.name}={part.neutral or 'None'}"


def run_lines(draft: Draft) -> list[str]:
    """The function that makes one run."""
    lines = [
        "def run(run: Run) -> Outcome:",
        '    """One test: a person, the robot\'s code, and the world, in virtual time."""',
        *import_lines(draft, [*message_imports([*draft.answers, *draft.code.outputs]), ("world", "World")]),
        "",
        f"    world = World(run.kernel, run.recorder{', run.bus' if draft.device_calls else ''})",
        '    manner = ["in_time"]' if draft.states and draft.inputs else "",
        "    hits: list[tuple[str, str]] = []" if draft.states and draft.inputs else "",
        "",
        *_person(draft),
        "",
        *_notes(draft),
        *_robot_lines(draft),
        "",
        f'    run.kernel.spawn("{draft.person}", person)',
        "    # Coverage is measured in here.",
        '    run.kernel.spawn("robot", run.measured(robot))',
        "    ended = run.go(LIMIT_S)",
        "    return Outcome(ended" + (', cross={"state and manner": hits})' if draft.states and draft.inputs else ")"),
    ]
    return [line for number, line in enumerate(lines) if line or (number and lines[number - 1])]


_UNTIL_QUIET = [
    f'            elif action.command == "{UNTIL_QUIET}":',
    "                ends_s = run.kernel.now_s + STAYS_S",
    "                quiet_s = run.kernel.now_s",
    "                while run.kernel.now_s < min(ends_s, quiet_s + ANSWER_S):",
    "                    if [message for each in hears for message in iter(each.poll, None)]:",
    "                        quiet_s = run.kernel.now_s",
    "                    run.kernel.sleep(LOOKS_EACH_S)",
]
"""A person leaves when nothing was said for as long as one waits for an answer."""

CLEARED = ["                for answer in answers:", "                    answer.clear()"]
"""What was said before is no answer."""


def _person(draft: Draft) -> list[str]:
    answers = ", ".join(message.name for message in draft.answers)
    answers += "," if len(draft.answers) == 1 else ""
    heard = ", ".join(message.name for message in draft.code.outputs)
    heard += "," if len(draft.code.outputs) == 1 else ""
    lines = [
        "    def person() -> None:",
        f'        bus = run.bus.port("{draft.person}")',
        f"        answers = [bus.subscribe(kind) for kind in ({answers})]" if answers else "",
        f"        hears = [bus.subscribe(kind) for kind in ({heard})]" if leaves(draft) else "",
        "        run.kernel.sleep(LOOKS_EACH_S)",
        "        for action in run.actions():",
        '            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))',
        "            if run.ending is not None:",
        "                return  # the robot has ended: only what was asked before is waited for",
        '            what, _, how = action.command.rpartition(" ")',
    ]
    branches: list[list[str]] = []
    if answers:
        branches.append(
            [
                '            if action.command == "wait_answer":',
                *([] if draft.inputs else ["                run.kernel.sleep(LOOKS_EACH_S)", *CLEARED]),
                "                ends_s = run.kernel.now_s + ANSWER_S",
                "                while run.kernel.now_s < ends_s and all(answer.poll() is None for answer in answers):",
                "                    run.kernel.sleep(LOOKS_EACH_S)",
            ]
        )
    else:
        branches.append(
            ['            if action.command == "wait_answer":', "                run.kernel.sleep(ANSWER_S / 10)"]
        )
    if leaves(draft):
        branches.append(_UNTIL_QUIET)
    if draft.sensors:
        names = ", ".join(f'"set_{word(sensor.name)}": "{sensor.name}"' for sensor in draft.sensors)
        branches.append(
            [
                f"            elif what in (senses := {{{names}}}):",
                '                world.sense(senses[what], action.parameters.get("value", how == "yes"))',
            ]
        )
    if draft.inputs:
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
            "                    if run.ending is None:",
            "                        bus.publish(said(what, action.parameters))",
        ]
        branches.append(branch)
    lines += [line for branch in branches for line in branch]
    lines += [] if not draft.tells_presence else ['        world.record("person_is_there", False)']
    lines += ['        run.kernel.stop("the person has left")']
    return [line for line in lines if line]


def _notes(draft: Draft) -> list[str]:
    """Nodes that record what the robot says."""
    if not draft.signals:
        return []
    fields: dict[str, list[str]] = {}
    for signal in draft.signals:
        fields.setdefault(signal.topic, []).append(signal.field)
    state_topic, _, state_field = draft.code.state.partition(".")
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
    if draft.states and draft.inputs:
        lines += [f'                if (topic, field) == ("{state_topic}", "{state_field}") and value in STATES:',
                  "                    hits.append((value, manner[0]))"]  # fmt: skip
    lines += ["", "    for kind, topic, fields in ("]
    for message in draft.code.outputs:
        if message.topic in fields:
            lines.append(f'        ({message.name}, "{message.topic}", {tuple_text(fields[message.topic])}),')
    lines += ["    ):", '        heard = run.bus.port("observer").subscribe(kind)',
              "        run.kernel.spawn(f\"notes {topic}\", partial(note, heard, topic, fields))", ""]  # fmt: skip
    return lines


# --- the robot

_TAKEN = ("run", "world", "person", "robot", "manner", "hits", "note", "instance", "make", "program")
"""Names of a run: where the code's own function has one of them, it is not imported under it."""

_STOPS = 'run.kernel.stop("the robot has ended its work")'
"""Where the robot may end before the person leaves, this ends a run; elsewhere it is a fault of the run."""


def _robot_lines(draft: Draft) -> list[str]:
    """The function `robot` of a run."""
    entry = draft.entry
    if entry is None:
        lines = ["# TODO: nothing was found to call: call what runs the robot."]
        lines += [f'import_module("{name}")' for name in draft.code.modules]
        return ["    def robot() -> None:", *(f"        {line}" for line in lines)]
    is_shadowed = entry.name in _TAKEN
    imports = _robot_imports(draft) + ([] if is_shadowed else [(entry.module, entry.name)])
    passed = ", ".join(_argument(draft, port) for port in entry.ports if not port.default)
    made = f"make({passed})"
    lines = [line[4:] for line in import_lines(draft, imports)]
    making = f'import_module("{entry.module}").{entry.name}' if is_shadowed else entry.name
    lines += ["", f"make: Any = {making}"]
    waits = ("asyncio.sleep" if entry.is_async else "run.kernel.sleep") + "(LIMIT_S)  # its bus calls it back"
    called = made
    if entry.is_class:
        lines.append(f"instance = {made}" if entry.method else f"_ = {made}")
        arguments = ", ".join(_argument(draft, port) for port in entry.method_ports if not port.default)
        called = f"instance.{entry.method}({arguments})" if entry.method else waits
    lines.append(f"await {called}" if entry.is_async else called)
    if entry.is_async:
        body = ["    async def program() -> None:", *(f"        {line}" if line else "" for line in lines), ""]
        body += ["    def robot() -> None:", "        asyncio.run(program())"]
    else:
        body = ["    def robot() -> None:", *(f"        {line}" if line else "" for line in lines)]
    body += [] if not draft.tells_presence else ['        world.record("robot_works", False)']
    return [*body, *(["        " + _STOPS] if "early" in draft.allowed_endings else [])]


def _robot_imports(draft: Draft) -> list[tuple[str, str]]:
    """Names of `ports.py` and of the code that the arguments need."""
    passed = [port for port in draft.ports if not port.default]
    imports = [("ports", device_class(port)) for port in draft.devices]
    published = [port for port in passed if port.role == "publish" or port.direction == "published"]
    received = [port for port in passed if port.role == "queue" and port.direction != "published"]
    imports += [("ports", "Outbox")] if published else []
    imports += [("ports", "Inbox")] if received else []
    imports += message_imports(thing.message for port in received for thing in _inputs_of(draft, port))
    imports += [("ports", "Bus")] if bus_class(draft) not in ("", "own") else []
    for port in passed:
        imports += port.imports if port.role in ("settings", "parameter") and port not in draft.parameters else ()
    return imports


def _argument(draft: Draft, port: Port) -> str:
    """What the code gets for a port."""
    name = f"{port.name}=" if port.is_keyword else ""
    if port.role == "bus":
        return name + ('run.bus.port("robot")' if bus_class(draft) == "own" else "Bus(run)")
    if port.role == "clock":
        is_called = any(operation.name == "__call__" for operation in port.operations)
        called = "run.kernel.sleep" if port.name == "sleep" else "lambda: run.kernel.now_s"
        return name + (called if is_called else "run.kernel")
    if port.role == "publish" or port.direction == "published":
        return name + "Outbox(run)"
    if port.role == "queue":
        messages = [thing.message.name for thing in _inputs_of(draft, port)]
        return name + f"Inbox({', '.join(['run', *messages])})"
    if port.role == "device":
        return name + f"{device_class(port)}(world)"
    if port in draft.parameters:
        number = f'run.test.run["{port.name}"]'
        return name + (f"round({number})" if port.annotation == "int" else number)
    return name + (port.neutral or "None")


def _inputs_of(draft: Draft, port: Port) -> list[Input]:
    """What comes through a queue."""
    return [thing for thing in draft.inputs if thing.message.channel in ("", port.name.strip("_"))]
