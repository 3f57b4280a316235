"""The real `rclpy` on a real middleware, in a network of its own: a process runs small systems there, one at a time."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]

Logs = dict[str, list[Any]]
"""Process -> what it logged, in order: what it is about, and what it was."""

_PATIENCE_S = 90.0
"""A little more than `python -m tests.extra.ros2.differential` has with a system."""

_ENVIRONMENT = {
    "PYTHONUNBUFFERED": "1",
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    # Shared memory goes beyond a network namespace: two of them would use the same names in it.
    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
}


class NoMiddlewareError(Exception):
    """There is none that may be used; the message says why."""


def python_of_rclpy() -> str:
    """The interpreter with the real `rclpy`: HRICDV_ROS_PYTHON, that of its environment, or this one.

    That from pip needs libraries which the interpreter of its own environment looks for when it starts.
    """
    if chosen := os.environ.get("HRICDV_ROS_PYTHON"):
        return chosen
    spec = find_spec("rclpy")
    if spec is None or spec.origin is None:
        raise NoMiddlewareError("needs rclpy")
    # PREFIX/lib/pythonX.Y/site-packages/rclpy/__init__.py
    own = Path(spec.origin).parents[4] / "bin" / "python"
    return str(own) if own.exists() else sys.executable


def _in_own_network() -> list[str]:
    """The beginning of a command that has a network of its own; none in CI's containers, which do not allow it.

    Raises:
        NoMiddlewareError: it is not allowed here, and there may be other nodes on this machine.
    """
    command = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--net"]
    try:
        done = subprocess.run([*command, "true"], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        reason = "there is no unshare"
    else:
        if done.returncode == 0:
            return command
        reason = done.stderr.strip()
    if os.environ.get("CI"):
        return []
    raise NoMiddlewareError(f"needs a network namespace, so as not to meet other nodes: {reason}")


class Middleware:
    """A process that runs systems on the real middleware."""

    def __init__(self, process: subprocess.Popen[str], errors: Path) -> None:
        self._process, self._errors, self._domain = process, errors, 0
        assert self._line() == "ready\n", errors.read_text()

    def logs(self, system: str, folder: Path) -> Logs:
        """What the processes of a system log; fails if one of them does.

        Args:
            folder: an empty one, in which they may write.
        """
        self._domain = self._domain % 100 + 1  # what is left of a system is in another domain
        order = {"system": system, "domain": self._domain, "folder": str(folder)}
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        reply = json.loads(self._line())
        assert not reply["faults"], "\n".join(f"{name} {fault}" for name, fault in reply["faults"].items())
        logs: Logs = reply["logs"]
        return logs

    def _line(self) -> str:
        assert self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], _PATIENCE_S)[0]:
            raise AssertionError(f"no reply of {self._process.args!r} for {_PATIENCE_S} s: {self._errors.read_text()}")
        return self._process.stdout.readline()


@contextmanager
def middleware(folder: Path) -> Iterator[Middleware]:
    """In the block there is a middleware. Raises NoMiddlewareError where there is none.

    Args:
        folder: for what it says of errors.
    """
    python = python_of_rclpy()
    found = subprocess.run(
        [python, "-c", "import rclpy; rclpy.init(); rclpy.shutdown()"], capture_output=True, text=True
    )
    if found.returncode:
        raise NoMiddlewareError(f"needs a middleware: {found.stderr.strip().rpartition(chr(10))[2]}")
    command = [*_in_own_network(), python, "-m", "tests.extra.ros2.differential"]
    environment, errors = {**os.environ, **_ENVIRONMENT}, folder / "errors"
    with (
        errors.open("w") as stderr,
        subprocess.Popen(
            command, cwd=ROOT, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=stderr, text=True
        ) as process,
    ):
        yield Middleware(process, errors)
