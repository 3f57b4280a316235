"""The names of `rclpy`'s extension: ours has all of them."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.clocks import Clock, ClockType, RosTimer
from pytest_hricdv.extra.ros2.extension import extension
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.services import Client, ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import Grasp, Reading, node, reading, run

_PINNED = Path(__file__).parent / "extension_names.json"
"""Name -> its members, of a class: those of rclpy 9.1.2 (kilted), as `python -m tests.extra.ros2.names` prints them."""

_NAMES: dict[str, list[str]] = json.loads(_PINNED.read_text(encoding="utf-8"))

_BELOW_RCLPY = ("EventsExecutor",)
"""Classes that are made below one of `rclpy`, and only where there is one."""


@cache
def _ours() -> Any:
    return extension()


def _has(kind: type[Any], member: str) -> bool:
    """Whether it is an attribute of the class, or one that its objects get when they are made."""
    made = [code.co_names for base in kind.__mro__ if (code := getattr(vars(base).get("__init__"), "__code__", None))]
    return hasattr(kind, member) or member in getattr(kind, "__annotations__", {}) or any(member in n for n in made)


@pytest.mark.parametrize("name", [name for name in _NAMES if name not in _BELOW_RCLPY])
def test_a_name_of_the_extension_is_there_with_its_members(name: str) -> None:
    assert hasattr(_ours(), name)
    assert [member for member in _NAMES[name] if not _has(getattr(_ours(), name), member)] == []


def test_callbacks_are_told_how_much_has_come() -> None:
    counts: list[tuple[str, int]] = []

    def robot(kernel: Kernel) -> None:
        made = node("robot")
        publisher = Publisher(made, Reading, "scan", Profile())
        subscription = TopicSubscription(made, Reading, "scan", Profile())
        service, client = (ServiceServer(made, Grasp, "grasp", Profile()), Client(made, Grasp, "grasp", Profile()))
        timer = RosTimer(Clock(ClockType.STEADY_TIME), made.context, 1000)
        for _ in range(2):
            publisher.publish(reading(1.0))
        subscription.set_on_new_message_callback(lambda number: counts.append(("message", number)))
        service.set_on_new_request_callback(lambda number: counts.append(("request", number)))
        client.set_on_new_response_callback(lambda number: counts.append(("response", number)))
        timer.set_on_reset_callback(lambda number: counts.append(("reset", number)))
        publisher.publish(reading(1.0))
        client.send_request(Grasp.Request())
        _, info = service.service_take_request(Grasp.Request)
        assert info is not None
        service.service_send_response(Grasp.Response(), info.request_id)
        timer.reset_timer()
        for clear in (
            subscription.clear_on_new_message_callback,
            service.clear_on_new_request_callback,
            client.clear_on_new_response_callback,
            timer.clear_on_reset_callback,
        ):
            clear()
        publisher.publish(reading(1.0))
        client.send_request(Grasp.Request())
        timer.reset_timer()

    run(robot)
    assert counts == [("message", 2), ("message", 1), ("request", 1), ("response", 1), ("reset", 1)]


def test_a_name_that_the_extension_lacks_is_said() -> None:
    with pytest.raises(AttributeError, match="rclpy_rewind of rclpy's extension is not simulated yet"):
        _ours().rclpy_rewind  # noqa: B018


@pytest.mark.slow
@pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy")
def test_the_installed_extension_has_no_name_that_is_not_pinned() -> None:
    done = subprocess.run([sys.executable, "-m", "tests.extra.ros2.names"], capture_output=True, text=True, check=False)
    if done.returncode == 3:
        pytest.skip(f"the real extension of rclpy cannot be loaded: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    installed = json.loads(done.stdout)
    missing = {name: sorted(set(members) - set(_NAMES.get(name, []))) for name, members in installed.items()}
    assert {name: members for name, members in missing.items() if members or name not in _NAMES} == {}
