"""Packages of ros2/examples, unmodified: each with a requirement, the same in each repeat, worker and hash seed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.docs.page import run

_PREFIX = "examples_rclpy_"


@dataclass(frozen=True)
class System:
    """Some nodes of the examples, what of them requirements can name, and a requirement."""

    nodes: tuple[str, ...]
    declared: str
    requirement: str

    @property
    def packages(self) -> list[str]:
        """Those that the nodes are in."""
        return sorted({_PREFIX + node.partition(".")[0] for node in self.nodes})


_HEARD = 'always(on({topic}) -> eventually[0:0.1](on(rosout) & rosout.name == "{listener}"))'
_SUM = (
    "always(on(add_two_ints_request) -> eventually[0:0.1](on(add_two_ints_response) & add_two_ints_response.sum == 42))"
)
_RESULT = (
    "always(on(fibonacci_goal) -> eventually[0:12](on(fibonacci_result) & fibonacci_result.sequence.length == 11))"
)
_CHATTER = 'topics={"/chatter": "std_msgs/msg/String"}'
_TOPIC = 'topics={"/topic": "std_msgs/msg/String"}'
_SERVICE = 'services={"/add_two_ints": "example_interfaces/srv/AddTwoInts"}'
_ACTION = 'actions={"/fibonacci": "example_interfaces/action/Fibonacci"}'

SYSTEMS = {
    "topics": System(
        ("minimal_publisher.publisher_member_function", "minimal_subscriber.subscriber_member_function"),
        _TOPIC,
        _HEARD.format(topic="topic", listener="minimal_subscriber"),
    ),
    "topics, as functions": System(
        ("minimal_publisher.publisher_local_function", "minimal_subscriber.subscriber_lambda"),
        _TOPIC,
        _HEARD.format(topic="topic", listener="minimal_subscriber"),
    ),
    "service": System(("minimal_service.service", "minimal_client.client_async_member_function"), _SERVICE, _SUM),
    "service, as functions": System(("minimal_service.service", "minimal_client.client"), _SERVICE, _SUM),
    "action": System(("minimal_action_server.server", "minimal_action_client.client"), _ACTION, _RESULT),
    "action, queued goals": System(
        ("minimal_action_server.server_queue_goals", "minimal_action_client.client_not_composable"), _ACTION, _RESULT
    ),
    "callback groups": System(
        ("executors.callback_group",), _CHATTER, _HEARD.format(topic="chatter", listener="listener")
    ),
    "composed": System(("executors.composed",), _CHATTER, _HEARD.format(topic="chatter", listener="listener")),
}

pytestmark = pytest.mark.skipif(
    any(find_spec(package) is None for system in SYSTEMS.values() for package in ("rclpy", *system.packages)),
    reason="needs rclpy and the packages of ros2/examples",
)

CONFTEST = """
from pathlib import Path

from pytest_hricdv.testbench import (
    BeliefSpace,
    Concretization,
    Model,
    Outcome,
    Ros2,
    RosNode,
    Testbench,
    Uniform,
    VirtualTime,
)

HERE = Path(__file__).parent


def pytest_hricdv_testbench(config):
    return Testbench(
        name="examples",
        model=Model(HERE / "models" / "cell.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_wish", "two_wishes"), groups={{"manner": ("keeps_away", "comes_near")}}),
        concretization=Concretization(
            commands={{
                each: {{"after_s": Uniform(0.2, 2.0, "s")}} for each in ("ask", "come_near", "go_away", "wait_done")
            }}
        ),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={{}},
        code={packages},
        ros2=Ros2({declared}),
        time=VirtualTime(allowed_endings=("limit", "idle", "early")),
        run=run,
    )


def run(run):
    run.ros2(*(RosNode(entry=f"{prefix}{{each}}:main") for each in {nodes}))
    return Outcome(run.go(limit_s=20.0))
"""

_PERSON = """
def run(run):
    ros = run.ros2(RosNode(entry="examples_rclpy_minimal_action_server.server:main"))

    def person():
        fibonacci = ros.node("person").action("/fibonacci", "example_interfaces/action/Fibonacci")
        for action in run.actions():
            run.kernel.sleep(action.parameters["after_s"])
            if action.command == "ask":
                over = fibonacci.call(30.0, order=10)
                assert over.status == 4 and over.result.sequence[-1] == 55, over
        run.kernel.stop("the person has left")

    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=100.0))
"""


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_package_of_the_examples_runs_unmodified(name: str, tmp_path: Path) -> None:
    system = SYSTEMS[name]
    run("hricdv init . --robot=cell", tmp_path)
    text = CONFTEST.format(
        packages=tuple(system.packages), declared=system.declared, nodes=system.nodes, prefix=_PREFIX
    )
    (tmp_path / "conftest.py").write_text(text)
    (tmp_path / "requirements.toml").write_text(f"[R1]\ntitle = \"as it says\"\nformula = '''{system.requirement}'''\n")
    found = []
    for seed, options in (("0", ["--hri-no-cov"]), ("1", []), ("2", ["-n", "2"])):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout
        tests = json.loads((tmp_path / "hri-report" / "report.json").read_text())["tests"]
        assert {test["requirements"]["R1"]["verdict"] for test in tests} == {"Passed"}
        found.append(sorted(test["record_sha256"] for test in tests))
    assert len(found[0]) == 6
    assert found[0] == found[1] == found[2]


def test_a_person_of_the_model_calls_an_action_of_an_example(tmp_path: Path) -> None:
    run("hricdv init . --robot=cell", tmp_path)
    given, _, _ = CONFTEST.partition("def run(run):")
    packages = ("examples_rclpy_minimal_action_server",)
    (tmp_path / "conftest.py").write_text(given.format(packages=packages, declared=_ACTION) + _PERSON)
    formula = "always(on(fibonacci_goal) & fibonacci_goal.order == 10 -> eventually[8:12](on(fibonacci_result)))"
    (tmp_path / "requirements.toml").write_text(f'[R1]\ntitle = "ten steps, a second each"\nformula = "{formula}"\n')
    done = subprocess.run([sys.executable, "-m", "pytest"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    tests = json.loads((tmp_path / "hri-report" / "report.json").read_text())["tests"]
    assert {(test["requirements"]["R1"]["verdict"], test["requirements"]["R1"]["triggers"]) for test in tests} == {
        ("Passed", 1),
        ("Passed", 2),
    }
