"""Names, ROS arguments, parameters and loggers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.extra.ros2 import arguments, names
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import node, run


@pytest.mark.parametrize(
    ("name", "what", "index"),
    [
        ("", "must not be empty", 0),
        ("scan/", "must not end with a forward slash", 4),
        ("sc an", "must not contain characters other than", 2),
        ("left/2nd", "must not start with a number", 5),
        ("2nd", "must not start with a number", 0),
        ("~scan", "must not have a tilde", 1),
        ("scan/~", "must not have '~'", 5),
        ("{node", "unbalanced", 0),
        ("node}", "unbalanced", 4),
        ("{a{b}}", "unbalanced", 2),
    ],
)
def test_a_wrong_name_is_refused_with_the_place(name: str, what: str, index: int) -> None:
    fault = names.topic_name_fault(name)
    assert fault is not None
    assert what in fault[0]
    assert fault[1] == index
    with pytest.raises(ValueError, match="topic name is invalid"):
        names.expand(name, "arm", "/")


@dataclass
class _Parameter:
    name: str
    kind: str
    value: Any

    class Type:
        @staticmethod
        def from_parameter_value(value: object) -> str:
            return type(value).__name__


def test_parameters_come_from_files_and_arguments(tmp_path: Path) -> None:
    """The same pattern of names may be there several times, and the later value wins."""
    file = tmp_path / "parameters.yaml"
    file.write_text(
        "/**:\n  ros__parameters: {speed: 1.0, name: arm}\n"
        "/cell/*:\n  ros__parameters: {gains: [1, 2], grip: {force: 3}}\n"
        "/**:\n  ros__parameters: {on: true}\n"
        "/other:\n  ros__parameters: {speed: 9.0}\n"
    )
    found = {}

    def robot(kernel: Kernel) -> None:
        made = node("arm", "--ros-args", "--params-file", str(file), "-p", "speed:=2.5", namespace="/cell")
        found.update(made.get_parameters(_Parameter))

    run(robot)
    assert {name: (each.kind, each.value) for name, each in found.items()} == {
        "speed": ("float", 2.5),
        "name": ("str", "arm"),
        "gains": ("list", [1, 2]),
        "grip.force": ("int", 3),
        "on": ("bool", True),
    }


@pytest.mark.parametrize(
    ("given", "error", "text"),
    [
        (["-p"], arguments.InvalidROSArgsError, "'-p' has no value"),
        (["-p", "speed=1"], arguments.InvalidROSArgsError, "'speed=1' is not of the form name:=value"),
        (["-p", "speed:=["], arguments.InvalidROSArgsError, "is not YAML"),
        (["--params-file", "none.yaml"], arguments.InvalidROSArgsError, r"parameter file /.*none\.yaml: No such file"),
        (["--quickly"], arguments.UnknownROSArgsError, r"\['--quickly'\]"),
    ],
)
def test_wrong_arguments_are_refused(given: list[str], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        arguments.parse(["--ros-args", *given])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"arm:\n  ros__parameters:\n    speed: 1\nhand: 3\n", r"parameters\.yaml:4: expected names with values"),
        (b"[1, 2]", r"parameters\.yaml:1: expected names with values"),
        (b"arm:\n  ros__parameters:\n    gains: [1,\n", r"parameters\.yaml:4: expected the node content"),
        (b"arm:\n  ros__parameters:\n    at: !!python/name:os.sep\n", r"parameters\.yaml:3: could not determine"),
        (b"arm: \xff", r"parameters\.yaml: 'utf-8' codec can't decode"),
    ],
)
def test_a_file_of_another_form_is_refused_in_one_line(content: bytes, message: str, tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_bytes(content)
    with pytest.raises(arguments.InvalidROSArgsError, match=message) as caught:
        arguments.parse(["--ros-args", "--params-file", str(file)])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(
            ("1e-3", 0.001),
            ("1:30", "1:30"),
            ("2020-01-01", "2020-01-01"),
            ("1_000", "1_000"),
            ("010", 8),
            ("0x1F", 31),
        ),
        *(("'5'", "5"), ('"yes"', "yes"), ("yes", True), ("Off", False), ("-.inf", -math.inf), ("1.", 1.0), ("~", "~")),
        *(("[1, 2.5e1]", [1, 25.0]), ("9223372036854775808", 9223372036854775808.0), ("09", 9.0), ("1.2.3", "1.2.3")),
    ],
)
def test_values_are_read_as_rcl_does(text: str, value: object) -> None:
    (parameter,) = arguments.parse(["--ros-args", "-p", f"speed:={text}"]).parameters
    assert parameter[2] == value
    assert type(parameter[2]) is type(value)


@pytest.mark.parametrize(("text", "levels"), [("warn", [("", "warn")]), ("arm.left:=DEBUG", [("arm.left", "DEBUG")])])
def test_levels_of_loggers_are_arguments(text: str, levels: list[tuple[str, str]]) -> None:
    assert arguments.parse(["--ros-args", "--log-level", text]).log_levels == levels
    with pytest.raises(arguments.InvalidROSArgsError, match="is not a level"):
        arguments.parse(["--ros-args", "--log-level", "loud"])
