"""ROS 2 knowledge for drafts of testbenches: packages, console scripts, names, and what a launch file starts."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_hricdv.declarations.ros2 import Launch, LaunchError, Ros2
from pytest_hricdv.extra.ros2.arguments import parse
from pytest_hricdv.extra.ros2.executables import command
from pytest_hricdv.extra.ros2.launch_processes import LaunchedProcess
from pytest_hricdv.extra.ros2.names import expand
from pytest_hricdv.extra.ros2.packages import SourcePackage, console_scripts, packages_around, sources_in
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Bus, Kernel, Recorder

LAUNCH_SYSTEM = ("launch", "launch_ros", "rclpy")

LIMIT_S = 60.0
"""Simulated time in which a launch file starts its processes: timers of launch files wait for some seconds."""

FOR_EVER_S = 1e6


class Ros2Tools:
    """See `pytest_hricdv.extra.draft.ros.executable`, whose protocol this is."""

    def packages(self, *folders: Path) -> dict[str, Path]:
        """Packages around folders and in them: name -> folder."""
        packages: dict[str, Path] = {}
        for folder in folders:
            for package in (*packages_around(folder / "package.xml").values(), *sources_in(folder)):
                packages.setdefault(package.name, package.folder)
        return packages

    def console_scripts(self, package: str, packages: Mapping[str, Path]) -> dict[str, str] | None:
        """Name -> "package.module:function"; None for a package that is neither source nor installed."""
        return console_scripts(package, {name: SourcePackage(name, folder) for name, folder in packages.items()})

    def expand(self, name: str, node: str, namespace: str) -> str:
        """The full name of a topic, service or action. Raises ValueError for what is no name."""
        return expand(name, node, namespace)

    def launch(self, file: Path, arguments: Mapping[str, str]) -> list[dict[str, Any]] | None:
        """The processes that a launch file starts; none of them is started. None without the launch system.

        Raises:
            InputError: the launch system refuses the file or the arguments.
        """
        if any(importlib.util.find_spec(name) is None for name in LAUNCH_SYSTEM):
            return None
        from pytest_hricdv.extra.ros2.system import Ros2Overlay

        processes: list[dict[str, Any]] = []

        def note(process: LaunchedProcess) -> None:
            processes.append(_describe(process))  # now: files of its parameters go with the launch system
            process.sleep(FOR_EVER_S)

        kernel, recorder = Kernel(), Recorder()
        test = ConcreteTest(id="launch", suite="launch", seed=0, actions=())
        run = Run(test, kernel, Bus(kernel, (), recorder), recorder, lambda body: body, MonitorSet(()))
        overlay = Ros2Overlay(Ros2(), ())
        run.middleware, kernel.virtual = overlay, overlay.virtual
        try:
            with overlay.modules.install():
                run.ros2(Launch(file, arguments=arguments, executables={"*": note}))
                run.go(LIMIT_S)
        except Exception as error:
            cause = error.__cause__ if isinstance(error.__cause__, LaunchError) else error
            raise LaunchError(" ".join(str(cause).split())) from None
        return processes


def _describe(process: LaunchedProcess) -> dict[str, Any]:
    wanted, parsed = command(process.argv), parse(process.argv)
    package, slash, executable = wanted.name.partition("/")
    remappings = tuple((f"{rule.node}:{rule.source}" if rule.node else rule.source, rule.target)
                       for rule in parsed.remappings if not rule.source.startswith("__"))  # fmt: skip
    return {
        "package": package if slash else "",
        "executable": executable if slash else wanted.name,
        "name": parsed.new_name("__node", "") or "",
        "namespace": parsed.new_name("__ns", "") or "",
        "remappings": remappings,
        "parameters": (dict(process.parameters),) if process.parameters else (),
        "arguments": process.arguments,
    }


ROS_TOOLS = Ros2Tools()
"""The tools for drafts."""
