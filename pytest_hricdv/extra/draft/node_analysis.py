"""What a draft for a node of ROS 2 is made of: the messages of its topics, services and actions, with their fields."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import replace

from pytest_hricdv.extra.draft.analysis import analysed
from pytest_hricdv.extra.draft.found.findings import (
    Direction,
    Findings,
    FoundValue,
    Message,
    MessageField,
    Problem,
    Question,
)
from pytest_hricdv.extra.draft.found.launched import StartedNode
from pytest_hricdv.extra.draft.found.nodes import Endpoint, Kind, RosStart
from pytest_hricdv.extra.draft.found.place import Place
from pytest_hricdv.extra.draft.reading.sources import DraftError, Function, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.ros.executable import Executable
from pytest_hricdv.extra.draft.ros.interfaces import fields, is_installed
from pytest_hricdv.extra.draft.ros.launch_names import renamed
from pytest_hricdv.extra.draft.ros.nodes import FOLDERS

_FORMS: dict[Kind, tuple[str, str, Direction, int]] = {
    "publisher": ("topic", "", "said", 0), "subscription": ("topic", "", "heard", 0),
    "service": ("service", "_request", "heard", 0), "client": ("service", "_request", "said", 0),
    "action server": ("action", "_goal", "heard", 0), "action client": ("action", "_goal", "said", 0),
}  # fmt: skip
"""Kind of an endpoint -> the form of its message, the end of its topic in requirements, direction, part of the type."""

_ANSWERS = {"service": "_response", "action server": "_result"}
OWN = "rclpy"


def ros_findings(executable: Executable, started: StartedNode | None = None) -> tuple[Findings, RosStart]:
    """What a testbench for the node needs, and how it starts it.

    Args:
        executable: the code of the node.
        started: how a launch file starts it; None where none does.

    Raises:
        DraftError: the code does not use `rclpy`.
    """
    if not any(name.partition(".")[0] == OWN for name, _ in executable.sources.outside):
        asked = (
            f"--ros2={executable.asked!r}: expected a node of ROS 2; {executable.entry} and what it imports of the code"
        )
        raise DraftError(f"{asked} beside it use no rclpy: --from drafts for other code")
    findings = analysed(executable.sources, executable.asked, "")
    if started is not None:
        findings = replace(findings, ros=renamed(findings.ros, started))
    start, problems = _start(executable, findings)
    messages = _with_values(_messages(executable, start), findings.ros.endpoints, executable.sources)
    questions = [q for q in findings.questions if q.about in ("publisher", "subscription", "service", "client",
                                                             "action server", "action client")]  # fmt: skip
    machines = tuple(replace(machine, told="") for machine in findings.machines)
    made = replace(
        findings, messages=tuple(messages), machines=machines, entry=None, problems=problems,
        code=executable.sources.code_without(OWN.encode()),  # other nodes of the package are not under test
    )  # fmt: skip
    return replace(made, questions=(*questions, *_questions(made))), start


def _start(executable: Executable, findings: Findings) -> tuple[RosStart, tuple[Problem, ...]]:
    """What is declared and provided; what is missing is said."""
    needed = {dotted.partition(".")[0]: place for dotted, place in reversed(executable.sources.outside)
              if len(dotted.split(".")) > 1 and dotted.split(".")[1] in FOLDERS}  # fmt: skip
    provided = [name for name in sorted(needed) if not is_installed(name) and name in executable.packages]
    problems = [_without_stand_in(p) for p in findings.problems
                if p.kind != "missing module" or p.text.split("`")[1] not in {*provided, *needed, OWN}]  # fmt: skip
    absent = {name for name in needed if not is_installed(name) and name not in provided}
    for name in sorted(absent):
        text = (
            f"the messages of `{name}` are neither installed here nor in the workspace: the node cannot start, and "
            "their fields are not drafted; install them, or put their packages into the workspace, and draft again"
        )
        problems.append(Problem("missing module", text, needed[name]))
    if not is_installed(OWN):
        place = next((place for name, place in executable.sources.outside if name.partition(".")[0] == OWN), None)
        text = "`rclpy` is not installed here, so that the draft was not run: docs/ros2.md says how to get it"
        problems.append(Problem("missing module", text, place))
    declared = tuple(endpoint for endpoint in findings.ros.endpoints if endpoint.is_whole)
    folders = tuple(str(executable.packages[name].folder) for name in provided)
    return RosStart(executable.asked, executable.entry, declared, folders), tuple(problems)


def _without_stand_in(problem: Problem) -> Problem:
    if problem.kind == "terminal":
        text = (
            "reads a terminal, at which nobody types in the draft: docs/ros2.md says how a person does (`run.terminal`)"
        )
        return replace(problem, text=text)
    if problem.kind not in ("missing module", "hardware"):
        return problem
    subject = problem.text.partition(":")[0]
    return replace(
        problem, text=f"{subject}: the node cannot be started as it is; install it, or put a module in its place"
    )


def _messages(executable: Executable, start: RosStart) -> list[Message]:
    messages: dict[str, Message] = {}
    for endpoint in start.declared:
        form, end, direction, part = _FORMS[endpoint.kind]
        parts = fields(endpoint.type, part, executable.packages, endpoint.place)
        _add(messages, _message(endpoint, form, end, direction, parts or ()))
        if endpoint.kind in _ANSWERS:
            answer = fields(endpoint.type, 1, executable.packages, endpoint.place)
            _add(messages, _message(endpoint, form, _ANSWERS[endpoint.kind], "said", answer or ()))
    return list(messages.values())


def _message(endpoint: Endpoint, form: str, end: str, direction: Direction, parts: Sequence[MessageField]) -> Message:
    topic = endpoint.name.strip("/").replace("/", "_") + end
    name = endpoint.name + end.replace("_", ", ")
    return Message(
        name, topic, endpoint.type, direction, tuple(parts), endpoint.place, (endpoint.place,), form, endpoint.name
    )  # fmt: skip


def _add(messages: dict[str, Message], message: Message) -> None:
    """Add a message; what a node both says and hears is one."""
    there = messages.get(message.topic)
    if there is None:
        messages[message.topic] = message
    elif there.direction != message.direction:
        messages[message.topic] = replace(there, direction="both")


def _with_values(messages: Sequence[Message], endpoints: Sequence[Endpoint], sources: Sources) -> Iterator[Message]:
    """The messages, with the texts that callbacks compare their fields with."""
    callbacks = {(e.name, e.kind): e.callback.rpartition(".")[2] for e in endpoints if not e.is_said}
    for message in messages:
        names = (
            [callbacks[key] for key in callbacks if key[0] == message.channel] if message.direction != "said" else []
        )
        functions = [scope for scope in sources.functions if scope.node.name in names]
        parts = []
        for part in message.fields:
            texts: list[FoundValue] = []
            for scope in functions if part.kind == "str" else ():
                texts += _compared(_function(scope), part.name, scope.module.file)
            first = {value.text: value for value in reversed(texts)}
            parts.append(replace(part, values=tuple(sorted(first.values(), key=lambda value: value.place))))
        yield replace(message, fields=tuple(parts))


def _compared(function: Function, field: str, file: str) -> Iterator[FoundValue]:
    held = {field}
    for node in ast.walk(function):  # text = message.data
        if isinstance(node, ast.Assign) and _is_field(node.value, {field}):
            held |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    for node in ast.walk(function):
        options: list[ast.expr] = []
        if isinstance(node, ast.Compare) and _is_field(node.left, held):
            options = [
                e for c in node.comparators for e in (c.elts if isinstance(c, ast.Tuple | ast.List | ast.Set) else [c])
            ]
        elif isinstance(node, ast.Match) and _is_field(node.subject, held):
            options = [p.value for case in node.cases for p in ast.walk(case.pattern) if isinstance(p, ast.MatchValue)]
        for option in options:
            if isinstance(option, ast.Constant) and isinstance(option.value, str):
                yield FoundValue(option.value, Place(file, option.lineno))


def _is_field(node: ast.expr, names: set[str]) -> bool:
    """Whether it is `message.FIELD`, a variable that holds it, or either of them with `.lower()` and the like."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not node.args:
        node = node.func.value
    return bool(set(dotted_name(node).split(".")[-1:]) & names)


def _questions(findings: Findings) -> Iterator[Question]:
    if not findings.heard:
        yield Question("Nothing was found that the node hears: what makes it act?", "messages", None)
    for message in findings.heard:
        for part in message.fields:
            if part.kind == "str" and not part.values:
                text = f"Which texts can `{message.topic}.{part.name}` have? Its callback compares none with it"
                yield Question(text, f"{message.topic}.{part.name}", message.place)
    for endpoint in findings.ros.of("client", "action client"):
        yield Question(f"What does {endpoint.name or 'it'} answer, which the node asks?", "answer", endpoint.place)


def _function(scope: Scope) -> Function:
    """The function of a scope that is no class."""
    assert not isinstance(scope.node, ast.ClassDef)
    return scope.node
