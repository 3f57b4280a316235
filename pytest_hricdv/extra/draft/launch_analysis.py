"""The analysis of a launch file for a draft: the nodes that it starts are one system under test."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.code_model import CodeModel, Message, Problem
from pytest_hricdv.extra.draft.node_analysis import analyse_node
from pytest_hricdv.extra.draft.ros.executable import Executable, find_executable, ros_tools
from pytest_hricdv.extra.draft.ros_model import CodeLine, Endpoint, LaunchedNodes, RosNodes, RosStart, StartedNode

T = TypeVar("T")

_ENDS = {"subscription": "publisher", "service": "client", "action server": "action client"}
"""Kind of a receiving endpoint -> kind of the sending endpoint of another node of the system."""


def read_launch_file(asked: str, start: Path) -> LaunchedNodes:
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
    try:
        processes = ros_tools().launch(file, arguments)
    except InputError as error:
        raise DraftError(f"--launch={file}: {error}") from None
    if processes is None:
        raise DraftError(
            f"--launch={file}: the launch system reads it: source a distribution of ROS 2, or install launch, "
            "launch_ros and rclpy (docs/ros2.md#launch-files)"
        )
    nodes = tuple(StartedNode(location=CodeLine(file.name, 0), **process) for process in processes)
    return LaunchedNodes(file, arguments, nodes)


def analyse_launch(nodes: LaunchedNodes, start: Path) -> tuple[CodeModel, RosStart, Executable]:
    """The model for a testbench of these nodes, how it starts them, and one of their executables.

    Raises:
        DraftError: none of them is a node of Python.
    """
    analysed: list[tuple[CodeModel, RosStart, Executable, StartedNode]] = []
    problems: list[Problem] = []
    left_out: list[str] = []
    for node in nodes.nodes:
        try:
            program = _program(node, nodes.file, start)
            model, own = analyse_node(program, node)
        except DraftError as error:
            left_out.append(node.key)
            text = f"{node.key} is left out: {str(error).replace('--ros2: ', '')}; what does it do for the others?"
            problems.append(Problem("launch", text, node.location))
        else:
            analysed.append((model, own, program, node))
    if not analysed:
        reasons = "; ".join(problem.text for problem in problems) or "it starts nothing"
        raise DraftError(f"--launch={nodes.file}: no node of Python is started by it: {reasons}")
    model = _join([model for model, *_ in analysed], problems)
    declared = _outside([own.declared for _, own, *_ in analysed])
    started = RosStart(
        asked=str(nodes.file.name),
        entry="",
        declared=declared,
        interfaces=tuple(dict.fromkeys(folder for _, own, *_ in analysed for folder in own.interfaces)),
        launch=nodes,
        left_out=tuple(dict.fromkeys(left_out)),
    )
    return _from_outside(model, analysed), started, analysed[0][2]


def _program(node: StartedNode, file: Path, start: Path) -> Executable:
    if not node.package:
        raise DraftError("it is a command of the system, and no node of Python")
    return find_executable(f"{node.package} {node.executable}", start, near=file.parent)


def _join(models: Sequence[CodeModel], problems: Sequence[Problem]) -> CodeModel:
    """The models of several nodes as that of one system."""
    messages: dict[str, Message] = {}
    for message in (message for model in models for message in model.messages):
        there = messages.get(message.topic)
        if there is None:
            messages[message.topic] = message
        else:
            direction = there.direction if there.direction == message.direction else "both"
            fields = there.fields if any(part.values for part in there.fields) else message.fields
            messages[message.topic] = replace(there, direction=direction, fields=fields)
    ros = RosNodes(*(_unique(part for model in models for part in getattr(model.ros, name))
                     for name in ("nodes", "endpoints", "parameters")))  # fmt: skip
    names = ("modules", "machines", "waits", "virtual", "constants", "parameters", "questions", "problems")
    joined: dict[str, Any] = {
        name: _unique(item for model in models for item in getattr(model, name)) for name in names
    }
    joined["problems"] += tuple(problems)
    roots = _unique(model.root for model in models)
    return replace(models[0], **joined, messages=tuple(messages.values()), ros=ros, roots=roots[1:])


def _unique(items: Iterable[T]) -> tuple[T, ...]:
    return tuple(dict.fromkeys(items))


def _inside(declared: Sequence[Sequence[Endpoint]]) -> set[tuple[str, str]]:
    """Kind and name of what a node of the system receives, and another one sends."""
    return {
        (endpoint.kind, endpoint.name)
        for number, own in enumerate(declared)
        for endpoint in own
        if endpoint.kind in _ENDS
        for other, others in enumerate(declared)
        if other != number and any((e.kind, e.name) == (_ENDS[endpoint.kind], endpoint.name) for e in others)
    }


def _outside(declared: Sequence[Sequence[Endpoint]]) -> tuple[Endpoint, ...]:
    """All declarations, without endpoints that nodes receive from each other: their other ends are declared."""
    inside = _inside(declared)
    return tuple(e for own in declared for e in own if (e.kind, e.name) not in inside)


def _from_outside(
    model: CodeModel, analysed: Sequence[tuple[CodeModel, RosStart, Executable, StartedNode]]
) -> CodeModel:
    """Drop messages that nodes of the system send each other: a person does not send them."""
    inside = {name for _, name in _inside([own.declared for _, own, *_ in analysed])}
    return replace(model, messages=tuple(_internal(model.messages, inside)))


def _internal(messages: Sequence[Message], inside: set[str]) -> Iterator[Message]:
    for message in messages:
        yield replace(message, direction="published") if message.channel in inside else message
