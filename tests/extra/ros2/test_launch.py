"""What is started, and processes that have variables of modules of their own."""

from __future__ import annotations

import importlib
import sys
from functools import partial
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.declarations.ros2 import Launch, LaunchError, MissingExecutableError, Ros2, Ros2Error, RosNode
from pytest_hricdv.extra.ros2 import system
from pytest_hricdv.extra.ros2.arguments import command_line, parse
from pytest_hricdv.extra.ros2.executables import load
from pytest_hricdv.extra.ros2.launch_files import find
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.extra.ros2.system import prepare
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.run import Run, TestbenchError
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from pytest_hricdv.runtime.virtual import VirtualModules

ARM = RosNode(
    entry="cell.arm:main",
    name="left",
    namespace="/cell",
    remappings=[("scan", "/front/scan")],
    parameters=[{"speed": 0.5, "names": ["a", "b's"], "limits": {"force": 1e-7, "on": True}}, "more.yaml"],
    arguments=["--fast"],
)


def test_the_command_line_is_that_of_a_launch_description() -> None:
    assert command_line(ARM) == [
        *("left", "--fast", "--ros-args", "-r", "__node:=left", "-r", "__ns:=/cell", "-r", "scan:=/front/scan"),
        *("-p", "speed:=0.5", "-p", "names:=['a', 'b''s']", "-p", "limits.force:=1.0e-07", "-p", "limits.on:=true"),
        *("--params-file", "more.yaml"),
    ]
    assert command_line(RosNode(entry="cell.arm:main")) == ["arm"]


_TEXTS = st.text(st.characters(codec="ascii", min_codepoint=32, max_codepoint=126))
_INTEGERS = st.integers(-(2**63), 2**63 - 1)  # beyond that rcl reads a float
_SCALARS = st.booleans() | _INTEGERS | st.floats(allow_nan=False) | _TEXTS
_NAMES = st.from_regex(r"[a-z]{1,5}", fullmatch=True)


@given(st.dictionaries(_NAMES, _SCALARS | st.lists(st.floats(allow_nan=False)) | st.lists(_TEXTS)))
def test_parameters_arrive_as_they_were_given(parameters: dict[str, Any]) -> None:
    node = RosNode(entry="cell.arm:main", parameters=[parameters])
    assert {name: value for _, name, value in parse(command_line(node)).parameters} == parameters


@pytest.mark.parametrize("given_", [{}, {"package": "cell"}, {"entry": "a:b", "package": "cell", "executable": "arm"}])
def test_a_node_is_an_executable_or_an_entry(given_: dict[str, Any]) -> None:
    with pytest.raises(LaunchError, match=r'expected package="\.\.\." and executable="\.\.\.", or entry='):
        RosNode(**given_)


_MAIN = """
import sys


def main({parameter}):
    return {value}
"""


@pytest.mark.parametrize(
    ("parameter", "value", "expected"),
    [
        ("args=None", "args, sys.argv", (None, sys.argv)),  # it reads it itself, in its process
        ("argv=sys.argv", "argv", ["left", "--ros-args", "-r", "__node:=left"]),
        ("*, argv=sys.argv[1:]", "argv", ["--ros-args", "-r", "__node:=left"]),
        ("args=[]", "args", []),
    ],
)
def test_a_main_function_gets_its_arguments_by_its_default(
    parameter: str, value: str, expected: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "with_default.py").write_text(_MAIN.format(parameter=parameter, value=value))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "with_default", raising=False)
    assert load(RosNode(entry="with_default:main", name="left"))() == expected


def _installed(folder: Path) -> None:
    """A package `cell_robot` with a console script, as colcon installs it."""
    info = folder / "cell_robot-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: cell-robot\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[console_scripts]\ngrasper = cell_robot.grasper:main\n")
    package = folder / "cell_robot"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "grasper.py").write_text("def main():\n    return 'grasped'\n")


def test_a_console_script_is_found_by_package_and_executable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _installed(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    assert load(RosNode(package="cell_robot", executable="grasper"))() == "grasped"
    with pytest.raises(LaunchError, match="no executable 'graspr'; it has grasper; nearest: grasper"):
        load(RosNode(package="cell_robot", executable="graspr"))
    with pytest.raises(LaunchError, match=r"cell_robot\.grasper has no 'man'; nearest: main"):
        load(RosNode(entry="cell_robot.grasper:man"))
    (tmp_path / "cell_robot" / "needy.py").write_text("import cv_not_there\n")
    needy = r"cell_robot\.needy cannot be imported: .*needy\.py:1 imports 'cv_not_there', which is not installed"
    with pytest.raises(LaunchError, match=needy):
        load(RosNode(entry="cell_robot.needy:main"))
    (tmp_path / "cell_robot" / "talks.py").write_text("from arm_msgs_not_there_msgs.msg import Arm\n")
    with pytest.raises(LaunchError, match=r"the folder of their interface files is enough: Ros2\(interfaces="):
        load(RosNode(entry="cell_robot.talks:main"))
    (tmp_path / "cell_robot" / "wrong.py").write_text("\nfrom cell_robot.grasper import nothing\n")
    with pytest.raises(LaunchError, match=r"cell_robot\.wrong cannot be imported: .*wrong\.py:2: cannot import name"):
        load(RosNode(entry="cell_robot.wrong:main"))
    with pytest.raises(LaunchError, match=r"there is no module 'cell_robot\.graspr'; is its folder on the path"):
        load(RosNode(entry="cell_robot.graspr:main"))
    with pytest.raises(LaunchError, match="package 'no_robot' is neither installed nor below"):
        load(RosNode(package="no_robot", executable="arm"))


def _write_source(folder: Path, executable: str = "grasper") -> None:
    """A package `source_robot` that is not built."""
    package = folder / "src" / "source_robot"
    (package / "source_robot").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>source_robot</name></package>")
    entries = f'entry_points={{"console_scripts": ["{executable} = source_robot.grasper:main"]}}'
    (package / "setup.py").write_text(f"from setuptools import setup\nsetup({entries})\n")
    (package / "source_robot" / "__init__.py").touch()
    (package / "source_robot" / "grasper.py").write_text("def main():\n    return 'grasped'\n")


@pytest.mark.parametrize(("where", "workspace"), [(".", ()), ("src/source_robot", ()), ("other", ("../src",))])
def test_a_node_of_a_workspace_needs_no_build(
    where: str, workspace: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _write_source(tmp_path)
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / where)
    monkeypatch.setattr(sys, "path", [*sys.path])
    for name in ("source_robot", "source_robot.grasper"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    assert load(RosNode(package="source_robot", executable="grasper", workspace=workspace))() == "grasped"
    with pytest.raises(MissingExecutableError, match="no executable 'gasper'; it has grasper; nearest: grasper"):
        load(RosNode(package="source_robot", executable="gasper", workspace=workspace))
    with pytest.raises(MissingExecutableError, match="nearest: source_robot"):
        load(RosNode(package="source_robt", executable="grasper", workspace=workspace))
    with pytest.raises(LaunchError, match="is not a folder"):
        load(RosNode(package="no_robot", executable="grasper", workspace=["not_there"]))


def test_another_launch_than_that_of_ros_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("launch", "launch_ros"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").touch()
        for loaded in [module for module in sys.modules if module.partition(".")[0] == name]:
            monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingExecutableError, match=r"'launch' in .*launch/__init__\.py is not that of ROS 2"):
        find(Launch("cell.launch.py"))


MODULE = """
import sys
import threading

context = None
made = 0

def init(log, sleep):
    global context, made
    made += 1
    assert context is None
    context = sys.argv[0]
    sleep(1.0)
    log.append((context, made))
    thread = threading.Thread(target=lambda: (sleep(1.0), log.append(("thread of", context))))
    thread.start()
    thread.join()
"""


def _processes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, ModuleVariables]:
    (folder / "one_context.py").write_text(MODULE)
    monkeypatch.syspath_prepend(folder)
    sys.modules.pop("one_context", None)
    module = importlib.import_module("one_context")
    variables = ModuleVariables(["one_context"])
    variables.update()
    return module, variables


def test_each_process_has_variables_of_its_own_and_so_do_its_threads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, variables = _processes(tmp_path, monkeypatch)
    argv = sys.argv
    for _ in range(2):
        assert _log_of_two(module, variables) == [
            ("left", 1),
            ("right", 1),
            None,
            ("thread of", "left"),
            ("thread of", "right"),
        ]
        assert (module.context, module.made, sys.argv) == (None, 0, argv)


def _log_of_two(module: Any, variables: ModuleVariables) -> list[Any]:
    """What two processes and the world find in the variables of the module."""
    kernel = Kernel()
    kernel.virtual = frozenset({"threading"})
    log: list[Any] = []
    with VirtualModules(["one_context"]).install():
        for name in ("left", "right"):
            body = Process(kernel, variables, [name]).wrap(partial(module.init, log, kernel.sleep))
            kernel.spawn(name, body)

        def world() -> None:
            kernel.sleep(1.0)
            log.append(module.context)

        kernel.spawn("world", world)
        assert kernel.run(10.0) == "idle"
        kernel.close()
    return log


@pytest.fixture
def _any_rclpy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A module in the place of `rclpy`, and a process that is left as it was."""
    (tmp_path / "rclpy.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(system, "replace_extension", lambda: None)
    monkeypatch.setenv("ROS_PYTHON_CHECK_FIELDS", "")


@pytest.mark.skipif(find_spec("rclpy") is not None, reason="there is rclpy")
def test_without_rclpy_it_says_how_to_get_it() -> None:
    with pytest.raises(
        Ros2Error, match=r"rclpy cannot be imported: run `source .*; or, on Linux, `pip install ros-rclpy "
    ):
        prepare()


@pytest.mark.parametrize(
    ("version", "is_refused"), [("3.3.11", True), ("7.0.1", True), ("7.1.3", False), ("10.0.0", False)]
)
@pytest.mark.usefixtures("_any_rclpy")
def test_a_version_that_is_too_old_is_refused(version: str, is_refused: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metadata, "version", lambda package: version)
    if is_refused:
        with pytest.raises(Ros2Error, match=f"rclpy {version} is not supported: expected 7.1 "):
            prepare()
    else:
        prepare()


def _run() -> Run:
    kernel, recorder = Kernel(), Recorder()
    test = ConcreteTest(id="t", suite="by-hand", seed=0, actions=())
    return Run(test, kernel, Bus(kernel, (), recorder), recorder, lambda body: body, MonitorSet(()))


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ("cell.arm:main", r"run\.ros2: expected RosNode\(\.\.\.\) or Launch\(\.\.\.\), not 'cell\.arm:main'"),
        (
            RosNode(entry="cell.arm:main", parameters=["no/arm.yaml"]),
            r"run\.ros2: RosNode cell\.arm:main: .*parameter file /.*no/arm\.yaml: No such file or directory",
        ),
        (RosNode(entry="cell.arm:main", remappings=[("", "scan")]), r"run\.ros2: RosNode cell\.arm:main: .*':=scan'"),
        (RosNode(entry="cell.arm:main", arguments=["--ros-args", "--fast"]), r"unknown ROS arguments: \['--fast'\]"),
        (RosNode(entry="cell.arm:main"), r"its package 'cell' is neither in the testbench's code nor in Ros2\("),
    ],
)
def test_what_cannot_be_started_is_said_before_anything_runs(
    node: Any, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(system, "prepare", lambda: None)
    monkeypatch.setattr(system, "_USED", ())  # there may be no rclpy
    run = _run()
    run.middleware = system.Ros2Overlay(Ros2(), ("other",))
    with pytest.raises(TestbenchError, match=message):
        run.ros2(node)
