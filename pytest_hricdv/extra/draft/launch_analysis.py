"""What a draft for a launch file is made of: the nodes that it starts, together as one system under test."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from pytest_hricdv.extra.draft.found.findings import Findings, Message, Problem
from pytest_hricdv.extra.draft.found.launched import LaunchedNodes, StartedNode
from pytest_hricdv.extra.draft.found.nodes import Endpoint, RosNodes, RosStart
from pytest_hricdv.extra.draft.node_analysis import ros_findings
from pytest_hricdv.extra.draft.reading.sources import DraftError
from pytest_hricdv.extra.draft.ros.executable import Executable, executable, workspace
from pytest_hricdv.extra.draft.ros.launch_run import is_launch_installed, run_launch
from pytest_hricdv.extra.draft.ros.launch_text import read_launch

T = TypeVar("T")

_ENDS = {"subscription": "publisher", "service": "client", "action server": "action client"}
"""What a node hears -> what another node of the system says into it."""


def launched(asked: str, start: Path) -> LaunchedNodes:
    """Read a launch file.

    Args:
        asked: "FILE [name:=value ...]", as of `ros2 launch`.
        start: the folder of the workspace.

    Raises:
        DraftError: there is no such file, or it cannot be read here.
    """
    name, *rest = asked.split()
    file = (start / name).expanduser().resolve()
    wrong = next((word for word in rest if ":=" not in word), None)
    if wrong is not None:
        raise DraftError(f'--launch={asked!r}: expected "FILE name:=value ...", and {wrong!r} came')
    if not file.is_file():
        raise DraftError(f"--launch={asked!r}: there is no file {file}")
    arguments = {word.partition(":=")[0]: word.partition(":=")[2] for word in rest}
    if is_launch_installed():
        return run_launch(file, arguments)
    return read_launch(file, arguments, workspace(file.parent, start))


def launch_findings(nodes: LaunchedNodes, start: Path) -> tuple[Findings, RosStart, Executable]:
    """What a testbench for these nodes needs, how it starts them, and one of their executables.

    Raises:
        DraftError: none of them is a node of Python.
    """
    made: list[tuple[Findings, RosStart, Executable, StartedNode]] = []
    problems = [Problem("launch", text, place) for place, text in nodes.problems]
    left_out: list[str] = []
    for node in nodes.nodes:
        try:
            program = _program(node, nodes.file, start)
            findings, own = ros_findings(program, node)
        except DraftError as error:
            left_out.append(node.key)
            text = f"{node.key} is left out: {str(error).replace('--ros2: ', '')}; what does it do for the others?"
            problems.append(Problem("launch", text, node.place))
        else:
            made.append((findings, own, program, node))
    if not made:
        reasons = "; ".join(problem.text for problem in problems) or "it starts nothing"
        raise DraftError(f"--launch={nodes.file}: no node of Python is started by it: {reasons}")
    findings = _together([findings for findings, *_ in made], problems)
    declared = _outside([own.declared for _, own, *_ in made])
    started = RosStart(
        asked=str(nodes.file.name),
        entry="",
        declared=declared,
        interfaces=tuple(dict.fromkeys(folder for _, own, *_ in made for folder in own.interfaces)),
        nodes=tuple((program.entry, node) for *_, program, node in made),
        launch=nodes if nodes.is_run else None,
        left_out=tuple(dict.fromkeys(left_out)),
    )
    return _heard_from_outside(findings, made), started, made[0][2]


def _program(node: StartedNode, file: Path, start: Path) -> Executable:
    if not node.package:
        raise DraftError("it is a command of the system, and no node of Python")
    return executable(f"{node.package} {node.executable}", start, near=file.parent)


def _together(all_findings: Sequence[Findings], problems: Sequence[Problem]) -> Findings:
    """The findings of several nodes as those of one system."""
    first = all_findings[0]
    messages: dict[str, Message] = {}
    for message in (message for findings in all_findings for message in findings.messages):
        there = messages.get(message.topic)
        if there is None:
            messages[message.topic] = message
        else:
            direction = there.direction if there.direction == message.direction else "both"
            fields = there.fields if any(part.values for part in there.fields) else message.fields
            messages[message.topic] = replace(there, direction=direction, fields=fields)
    ros = RosNodes(*(_unique(part for findings in all_findings for part in getattr(findings.ros, name))
                     for name in ("nodes", "endpoints", "parameters", "timers")))  # fmt: skip
    roots = _unique(findings.root for findings in all_findings)
    return replace(
        first,
        code=_unique(name for findings in all_findings for name in findings.code),
        messages=tuple(messages.values()),
        machines=_unique(machine for findings in all_findings for machine in findings.machines),
        waits=_unique(wait for findings in all_findings for wait in findings.waits),
        virtual=_unique(name for findings in all_findings for name in findings.virtual),
        constants=_unique(constant for findings in all_findings for constant in findings.constants),
        parameters=_unique(parameter for findings in all_findings for parameter in findings.parameters),
        questions=_unique(question for findings in all_findings for question in findings.questions),
        problems=(*_unique(problem for findings in all_findings for problem in findings.problems), *problems),
        ros=ros,
        roots=roots[1:],
    )


def _unique(items: Iterable[T]) -> tuple[T, ...]:
    return tuple(dict.fromkeys(items))


def _inside(declared: Sequence[Sequence[Endpoint]]) -> set[tuple[str, str]]:
    """Kind and name of what a node of the system hears, and another one says."""
    return {
        (endpoint.kind, endpoint.name)
        for number, own in enumerate(declared)
        for endpoint in own
        if endpoint.kind in _ENDS
        for other, others in enumerate(declared)
        if other != number and any((e.kind, e.name) == (_ENDS[endpoint.kind], endpoint.name) for e in others)
    }


def _outside(declared: Sequence[Sequence[Endpoint]]) -> tuple[Endpoint, ...]:
    """All that is declared, without what nodes hear of each other: its other end is declared."""
    inside = _inside(declared)
    return tuple(e for own in declared for e in own if (e.kind, e.name) not in inside)


def _heard_from_outside(
    findings: Findings, made: Sequence[tuple[Findings, RosStart, Executable, StartedNode]]
) -> Findings:
    """What nodes of the system hear of each other, a person does not say to them."""
    inside = {name for _, name in _inside([own.declared for _, own, *_ in made])}
    return replace(findings, messages=tuple(_internal(findings.messages, inside)))


def _internal(messages: Sequence[Message], inside: set[str]) -> Iterator[Message]:
    for message in messages:
        yield replace(message, direction="said") if message.channel in inside else message
