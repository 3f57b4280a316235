"""With the Python of `rclpy`, where there is one: of a ROS 2 distribution, or from pip."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.docs.page import blocks, follow, run, write_files

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy, of a ROS 2 distribution or from pip"),
]


def test_the_page_leads_from_a_package_to_a_generated_test(tmp_path: Path) -> None:
    assert follow("ros2.md", tmp_path) == 2


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """The project of docs/ros2.md; its sessions run each test once."""
    run("hricdv init . --robot=cell", tmp_path)
    write_files(blocks("ros2.md"), tmp_path)
    with (tmp_path / "pytest.ini").open("a", encoding="utf-8") as settings:
        settings.write("hri_audit = off\nhri_diagnose = 0\n")
    return tmp_path


def _edit(file: Path, *replacements: tuple[str, str]) -> None:
    text = file.read_text(encoding="utf-8")
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")


def _hashes(folder: Path) -> list[str]:
    report = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))
    return sorted(test["record_sha256"] for test in report["tests"])


def test_a_run_is_the_same_in_each_repeat_worker_process_and_hash_seed(cell: Path) -> None:
    found = []
    for seed, options in (("0", []), ("2", ["-n", "2"])):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-m", "pytest", *options], cwd=cell, env=environment, check=True)
        found.append(_hashes(cell))
    assert len(found[0]) == 6
    assert found[0] == found[1]


def _report(folder: Path) -> list[Any]:
    tests: list[Any] = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))["tests"]
    return tests


MAP = """
[messages.request]
topic = "/request"

[messages.done]
topic = "/done"

[signals.arm_moves]
topic = "/arm/moving"
value = "data"

[signals.person_near]
topic = "/somebody_near"
value = "data"
"""


def test_a_failing_run_leaves_its_bag_and_bags_are_judged_as_their_runs_were(cell: Path) -> None:
    """By what topics say: R1 is about them. R2 is about the world, whose signals no topic has in time."""
    _edit(cell / "conftest.py", ('{"period_s": 0.1}', '{"period_s": 0.4}'))
    assert "bags of ROS 2: of 2 tests that failed, next to the report" in run("pytest", cell)[1]
    tests = _report(cell)
    assert {test["id"]: test["outcome"] == "failed" for test in tests} == {
        test["id"]: test.get("trace", {}).get("bag") is not None for test in tests
    }
    assert [test["trace"]["file"] for test in tests if "trace" in test] == [None, None]
    run("pytest --hri-mcap-all", cell)
    (cell / "map.toml").write_text(MAP)
    bags = {Path(test["trace"]["bag"]).name: test["requirements"]["R1"] for test in _report(cell)}
    _, printed = run(f"hricdv check {' '.join(f'hri-report/traces/{bag}' for bag in bags)} --map map.toml --json", cell)
    logs = (json.loads(line) for line in printed.splitlines() if line.startswith("{"))  # between notes
    judged = {log["log"]: log["requirements"]["R1"] for log in logs}
    assert {name: (made["verdict"], made["margin"]) for name, made in judged.items()} == {
        name: (made["verdict"], pytest.approx(made["margin"])) for name, made in bags.items()
    }
    assert len(judged) == 6


_CALL = (
    (
        "from std_msgs.msg import Bool, Empty\n",
        "from std_msgs.msg import Bool, Empty\nfrom std_srvs.srv import Trigger\n",
    ),
    ("        self.left_s = 2.0\n", '        self.create_client(Trigger, "grasp").call(Trigger.Request())\n'),
)
_ACTION = (
    (
        "from std_msgs.msg import Bool, Empty\n",
        "from test_msgs.action import Fibonacci\nfrom rclpy.action import ActionClient\n"
        "from std_msgs.msg import Bool, Empty\n",
    ),
    ("        self.left_s = 2.0\n", '        ActionClient(self, Fibonacci, "count").wait_for_server()\n'),
)
_WAITS_FOR_SERVICE = """gripper = self.create_client(Trigger, "grasp")
        while not gripper.wait_for_service(timeout_sec=1.0):
            self.get_logger().info("no gripper yet")
        """
_SERVER = "ros.node('gripper').serve('/grasp', 'std_srvs/srv/Trigger', lambda request, response: response)\n    "


@pytest.mark.parametrize(
    ("edits", "message"),
    [
        (
            (*_CALL,),
            "arm_node has waited at arm_node.py:22 since 0.645 s: for the response of the service /grasp, which nobody "
            "serves",
        ),
        (
            (_CALL[0], ("self.moving =", _WAITS_FOR_SERVICE + "self.moving =")),
            "arm_node has waited at arm_node.py:15 since 0.000 s: for the service /grasp, which nobody serves",
        ),
        (
            (_CALL[0], (_CALL[1][0], _CALL[1][1].replace(".call(", ".call_async("))),
            "arm_node calls the service /grasp at arm_node.py:22 at 0.645 s: nobody serves it",
        ),
        (
            _ACTION,
            "arm_node has waited at arm_node.py:23 since 0.645 s: for the action /count, which nobody serves",
        ),
        (
            (("Bool(data=moves and self.left_s > 0.0)", "Bool(data=3)"),),
            "the code under test raised AssertionError: The 'data' field must be of type 'bool' in node arm_node",
        ),
        (
            (
                ("import rclpy\nfrom", "import threading\n\nimport rclpy\nfrom"),
                ("        self.left_s = 2.0\n", "        threading.Event().wait()\n"),
            ),
            "arm_node has waited at arm_node.py:23 since 0.645 s: in a callback, for 30.0 s so far, without a time-out",
        ),
    ],
)
def test_a_mistake_is_said_in_a_line(cell: Path, edits: tuple[tuple[str, str], ...], message: str) -> None:
    _edit(cell / "arm_control" / "arm_node.py", *edits)
    status, printed = run("pytest -x", cell)
    assert status in (1, 4)
    assert message in " ".join(printed.split())


_OTHER = """
class Other(Node):
    def __init__(self):
        super().__init__("other")
        self.holding = self.create_client(Trigger, "hold")
        self.create_service(Trigger, "grasp", self.on_grasp)

    def on_grasp(self, _, response):
        return self.holding.call(Trigger.Request())


def main():"""


def test_two_nodes_that_wait_for_each_other_are_both_said(cell: Path) -> None:
    serves = (
        "self.moving =",
        'self.create_service(Trigger, "hold", lambda _, response: response)\n        self.moving =',
    )
    _edit(cell / "arm_control" / "arm_node.py", *_CALL, serves, ("\ndef main():", _OTHER))
    _edit(cell / "conftest.py", ("run.ros2(", 'run.ros2(RosNode(entry="arm_control.arm_node:Other"), '))
    printed = " ".join(run("pytest -x", cell)[1].split())
    wait = "arm_node has waited at arm_node.py:23 since 0.645 s"
    assert f"{wait}: for the response of the service /grasp of /other," in printed
    assert "Other has waited at arm_node.py:45 since 0.645 s: for the response of the service /hold of /arm," in printed


def test_an_answer_that_only_the_waiting_executor_could_take_is_a_deadlock(cell: Path) -> None:
    _edit(cell / "arm_control" / "arm_node.py", *_CALL)
    _edit(cell / "conftest.py", ("for each in (scanner", f"{_SERVER}for each in (scanner"))
    assert "which only the executor that waits here could take" in run("pytest -x", cell)[1]
