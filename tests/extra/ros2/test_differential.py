"""Small systems in virtual time, and with the real `rclpy` on a real middleware: each node logs the same, by topic."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib import metadata
from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.overlay import virtual_rclpy
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.virtual.outside import guard_run
from tests.extra.ros2.differential import NAMES, system
from tests.extra.ros2.middleware import Logs, Middleware, NoMiddlewareError, middleware

pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),  # of rclpy itself
    # An executor that could not be made, in a context that is shut down, raises in its own __del__.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy: make test installs it where pip has it"),
]

LIMIT_S = 60.0

_FOR_ALL = frozenset(
    (
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
)
"""The others use what `rclpy` has since kilted."""

_QUICK = ("keep last", "error in a service", "callbacks of parameters", "lifecycle publisher", "tasks", "names")
"""Of one process each, and of what is most likely to break: the others take minutes on the middleware."""

DIFFERENT: dict[str, dict[str, str]] = {
    "lifespan": {"numbers": "a message that has arrived expires there, too, as DDS 1.4 says; in Fast DDS it stays"},
}
"""System -> what its logs are about that differs -> why: the rows of the table in docs/ros2.md."""


def _is_older() -> bool:
    """Whether `rclpy` is one from before kilted."""
    try:
        return int(metadata.version("rclpy").partition(".")[0]) < 9
    except metadata.PackageNotFoundError:
        return False


def _every(*quick: str) -> list[Any]:
    older = pytest.mark.skipif(_is_older(), reason="written for rclpy of kilted and later")
    found = []
    for name in (name for names in NAMES.values() for name in names):
        marks = [] if name in quick else [pytest.mark.slow]
        found.append(pytest.param(name, id=name, marks=marks if name in _FOR_ALL else [*marks, older]))
    return found


def _by_topic(logs: Logs, *left_out: str) -> dict[str, dict[str, list[Any]]]:
    """Process -> topic -> what it logged about it, in order."""
    found = {}
    for process, lines in logs.items():
        ordered = sorted((line for line in lines if line[0] not in left_out), key=lambda line: line[0])  # stable
        found[process] = {about: [line[1] for line in group] for about, group in groupby(ordered, lambda line: line[0])}
    return found


def _virtual(name: str) -> tuple[Logs, str]:
    """The logs in virtual time, and why the run ended."""
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading", "asyncio"})
    logs: Logs = {}
    with virtual_rclpy("tests.extra.ros2.differential"):
        chosen = system(name)
        variables = ModuleVariables(["rclpy", "tests"])
        variables.update()
        left = set(chosen.ending)

        def enter(process: str, body: Any) -> None:
            logs[process] = []

            def main() -> None:
                body(lambda about, what: logs[process].append(json.loads(json.dumps([about, what]))))
                left.discard(process)
                if not left:
                    kernel.stop("all have ended")

            kernel.spawn(process, Process(kernel, variables, [process]).wrap(main))

        for process, body in {**chosen.servers, **chosen.ending}.items():
            enter(process, body)
        with guard_run(kernel):
            why = kernel.run(LIMIT_S)
        kernel.close()
    return logs, why


@pytest.fixture(scope="session")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Middleware]:
    """The real middleware, for all systems of this worker."""
    try:
        with middleware(tmp_path_factory.mktemp("middleware")) as started:
            yield started
    except NoMiddlewareError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("name", _every(*_QUICK))
def test_a_system_logs_the_same_in_each_repeat(name: str) -> None:
    logs, why = _virtual(name)
    assert why == "all have ended"
    assert any(logs.values())
    assert _virtual(name) == (logs, why)


@pytest.mark.parametrize("name", _every(*_QUICK))
def test_a_system_logs_the_same_on_the_real_middleware(name: str, real: Middleware, tmp_path: Path) -> None:
    different = DIFFERENT.get(name, {})
    expected, virtual = real.logs(name, tmp_path), _virtual(name)[0]
    assert _by_topic(virtual, *different) == _by_topic(expected, *different)
    for about in different:
        others = {line[0] for lines in expected.values() for line in lines} - {about}
        assert _by_topic(virtual, *others) != _by_topic(expected, *others), f"{about!r} differs no more"
