"""The run of a drafted testbench: the person, what is recorded, and what a person says by the words of a command."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code_model import MessageField
from pytest_hricdv.extra.draft.project.draft import Draft, import_lines, message_imports, tuple_text
from pytest_hricdv.extra.draft.project.model import UNTIL_QUIET, leaves
from pytest_hricdv.extra.draft.project.robot import robot_lines


def said_lines(draft: Draft) -> list[str]:
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
        *import_lines(draft, [*message_imports([*draft.answers, *draft.code.published]), ("world", "World")]),
        "",
        f"    world = World(run.kernel, run.recorder{', run.bus' if draft.called else ''})",
        '    manner = ["in_time"]' if draft.states and draft.inputs else "",
        "    hits: list[tuple[str, str]] = []" if draft.states and draft.inputs else "",
        "",
        *_person(draft),
        "",
        *_notes(draft),
        *robot_lines(draft),
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
    heard = ", ".join(message.name for message in draft.code.published)
    heard += "," if len(draft.code.published) == 1 else ""
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
    for message in draft.code.published:
        if message.topic in fields:
            lines.append(f'        ({message.name}, "{message.topic}", {tuple_text(fields[message.topic])}),')
    lines += ["    ):", '        heard = run.bus.port("observer").subscribe(kind)',
              "        run.kernel.spawn(f\"notes {topic}\", partial(note, heard, topic, fields))", ""]  # fmt: skip
    return lines
