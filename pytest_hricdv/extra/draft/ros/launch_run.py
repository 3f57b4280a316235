"""Reading a launch file with the launch system of ROS 2, which is installed: it runs, and what it starts is noted."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_hricdv._base.message import InputError
from pytest_hricdv.declarations.ros2 import Launch, Ros2
from pytest_hricdv.extra.draft.found.launched import LaunchedNodes, StartedNode
from pytest_hricdv.extra.draft.found.place import Place
from pytest_hricdv.extra.draft.reading.sources import DraftError
from pytest_hricdv.extra.ros2.arguments import parse
from pytest_hricdv.extra.ros2.executables import command
from pytest_hricdv.extra.ros2.launched import LaunchedProcess
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Bus, Kernel, Recorder

NEEDED = ("launch", "launch_ros", "rclpy")

LIMIT_S = 60.0
"""So long a launch file may take, in simulated time, until it has started all (chosen: timers of launch files wait for
some seconds)."""

FOR_EVER_S = 1e6


def is_launch_installed() -> bool:
    """Whether launch files can be run here."""
    return all(importlib.util.find_spec(name) is not None for name in NEEDED)


def run_launch(file: Path, arguments: Mapping[str, str]) -> LaunchedNodes:
    """What a launch file starts; nothing of it is started.

    Raises:
        DraftError: the launch system refuses the file or the arguments.
    """
    from pytest_hricdv.extra.ros2.system import Ros2Overlay

    nodes: list[StartedNode] = []
    place = Place(file.name, 0)

    def note(process: LaunchedProcess) -> None:
        nodes.append(_node(process, place))  # now: files of its parameters go with the launch system
        process.sleep(FOR_EVER_S)

    kernel, recorder = Kernel(), Recorder()
    test = ConcreteTest(id="launch", suite="launch", seed=0, actions=())
    run = Run(test, kernel, Bus(kernel, (), recorder), recorder, lambda body: body, MonitorSet(()))
    try:
        overlay = Ros2Overlay(Ros2(), ())
        run.middleware, kernel.virtual = overlay, overlay.virtual
        with overlay.modules.installed():
            run.ros2(Launch(file, arguments=arguments, executables={"*": note}))
            run.go(LIMIT_S)
    except InputError as error:
        raise DraftError(f"--launch={file}: {error}") from None
    except Exception as error:
        cause = error.__cause__ if isinstance(error.__cause__, InputError) else error
        raise DraftError(f"--launch={file}: {' '.join(str(cause).split())}") from None
    return LaunchedNodes(file, arguments, tuple(nodes), is_run=True)


def _node(process: LaunchedProcess, place: Place) -> StartedNode:
    wanted, parsed = command(process.argv), parse(process.argv)
    package, slash, executable = wanted.name.partition("/")
    remappings = tuple(
        (f"{rule.node}:{rule.source}" if rule.node else rule.source, rule.target)
        for rule in parsed.remappings
        if not rule.source.startswith("__")
    )
    parameters: tuple[Mapping[str, Any] | str, ...] = (dict(process.parameters),) if process.parameters else ()
    return StartedNode(
        package if slash else "", executable if slash else wanted.name, place, parsed.renamed("__node", "") or "",
        parsed.renamed("__ns", "") or "", remappings, parameters, process.arguments,
    )  # fmt: skip
