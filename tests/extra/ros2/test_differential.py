"""Small systems in virtual time, and on the real middleware where there is one: each node logs the same, by topic."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.overlay import replace_extension, virtual_rclpy
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.runtime import Kernel

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),  # of rclpy itself
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy, of a ROS 2 distribution"),
]

NAMES = (
    *("topic", "two listeners", "late listener", "incompatible", "service", "requests in a row", "nested services"),
    *(
        "action",
        "cancelled action",
        "rejected action",
        "parameters",
        "managed node",
        "wait for message",
        "timers",
        "logs",
    ),
)
LIMIT_S = 60.0

Logs = dict[str, dict[str, list[Any]]]
"""Process -> topic -> what it logged about it, in order."""


def _by_topic(lines: list[Any]) -> dict[str, list[Any]]:
    ordered = sorted(lines, key=lambda line: line[0])  # stable
    return {about: [what for _, what in found] for about, found in groupby(ordered, key=lambda line: line[0])}


def _virtual(name: str) -> tuple[Logs, str]:
    """The logs in virtual time, and why the run ended."""
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading", "asyncio"})
    lines: dict[str, list[Any]] = {}
    with virtual_rclpy("tests.extra.ros2.differential"):
        from tests.extra.ros2.differential.systems import SYSTEMS

        system = SYSTEMS[name]
        variables = ModuleVariables(["rclpy", "tests"])
        variables.update()
        left = set(system.ending)

        def enter(process: str, body: Any) -> None:
            lines[process] = []

            def main() -> None:
                body(lambda about, what: lines[process].append(json.loads(json.dumps([about, what]))))
                left.discard(process)
                if not left:
                    kernel.stop("all have ended")

            kernel.spawn(process, Process(kernel, variables, [process]).running(main))

        for process, body in {**system.servers, **system.ending}.items():
            enter(process, body)
        why = kernel.run(LIMIT_S)
        kernel.close()
    return {process: _by_topic(found) for process, found in lines.items()}, why


def _real(name: str, folder: Path) -> Logs:
    """The logs on the real middleware, each process one of the machine, in a domain of its own."""
    replace_extension()  # this process runs systems in virtual time, too
    from tests.extra.ros2.differential.systems import SYSTEMS

    system = SYSTEMS[name]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(10 + NAMES.index(name)), "PYTHONUNBUFFERED": "1"}

    def started(process: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "tests.extra.ros2.differential", name, process, str(folder / process)]
        return subprocess.Popen(command, cwd=Path(__file__).parents[3], env=environment)

    servers = [started(each) for each in system.servers]
    ending = [started(each) for each in system.ending]
    end_s = time.monotonic() + LIMIT_S
    try:
        for each in ending:
            assert each.wait(max(end_s - time.monotonic(), 0.1)) == 0
    finally:
        for each in (*ending, *servers):
            if each.poll() is None:
                each.send_signal(signal.SIGINT)
        for each in servers:
            each.wait(10)
    processes = (*system.servers, *system.ending)
    return {
        each: _by_topic([json.loads(line) for line in (folder / each).read_text().splitlines()]) for each in processes
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_system_logs_the_same_in_each_repeat(name: str) -> None:
    logs, why = _virtual(name)
    assert why == "all have ended"
    assert any(logs.values())
    assert _virtual(name) == (logs, why)


def _has_middleware() -> bool:
    """Whether there is the real extension of `rclpy`; found by a process that has not replaced it."""
    found = subprocess.run(
        [sys.executable, "-c", "import rclpy; rclpy.init(); rclpy.shutdown()"], capture_output=True, check=False
    )
    return found.returncode == 0


@pytest.fixture(scope="module")
def _middleware() -> None:
    if not _has_middleware():
        pytest.skip("needs a middleware of ROS 2")


@pytest.mark.usefixtures("_middleware")
@pytest.mark.parametrize("name", NAMES)
def test_a_system_logs_the_same_on_the_real_middleware(name: str, tmp_path: Path) -> None:
    assert _real(name, tmp_path) == _virtual(name)[0]
