from __future__ import annotations

import subprocess
import sys
import tomllib
from array import array
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.draft.first_runs import FirstRuns
from pytest_hricdv.extra.draft.node_analysis import analyse_node, with_state_topic
from pytest_hricdv.extra.draft.observe.observations import Observations
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.ros.executable import find_executable
from pytest_hricdv.extra.draft.settlement import Settlement
from pytest_hricdv.extra.draft.stand_ins.node_driver import NodeDriver, _fill
from pytest_hricdv.extra.draft.stand_ins.visit import Array, Say
from pytest_hricdv.extra.ros2.interface_packages import provide_interfaces
from pytest_hricdv.testbench import Uniform
from tests.extra.draft import ros_robots

INTERFACES = {
    "std_msgs/package.xml": "<package><name>std_msgs</name></package>",
    "std_msgs/msg/Bool.msg": "bool data\n",
    "std_msgs/msg/Empty.msg": "",
    "std_msgs/msg/String.msg": "string data\n",
    "std_srvs/package.xml": "<package><name>std_srvs</name></package>",
    "std_srvs/srv/SetBool.srv": "bool data\n---\nbool success\nstring message\n",
    "scan_msgs/package.xml": "<package><name>scan_msgs</name></package>",
    "scan_msgs/msg/Limits.msg": "float32 low\nfloat32 high\nuint8 count\n",
    "scan_msgs/msg/Scan.msg": "scan_msgs/Limits limits\nfloat32[] ranges\nstring<=9 frame\nuint8[] data\n",
}
SCANNER = """
import rclpy
from rclpy.node import Node
from scan_msgs.msg import Scan


class Scanner(Node):
    def __init__(self):
        super().__init__("scanner")
        self.create_subscription(Scan, "scan", self.on_scan, 10)

    def on_scan(self, message):
        pass
"""
SETUP = """
from setuptools import setup

setup(name="home_robot", entry_points={"console_scripts": ["door = home_robot.door:main"]})
"""


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A workspace with a package of nodes and packages of messages, as sources."""
    texts = {
        **INTERFACES,
        "home_robot/package.xml": "<package><name>home_robot</name></package>",
        "home_robot/setup.py": SETUP,
        "home_robot/home_robot/__init__.py": "",
        "home_robot/home_robot/door.py": ros_robots.DOOR,
        "home_robot/home_robot/arm.py": ros_robots.ARM,
        "home_robot/home_robot/scanner.py": SCANNER,
    }
    for name, text in texts.items():
        (tmp_path / "src" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "src" / name).write_text(text, encoding="utf-8")
    return tmp_path


def drafted(workspace: Path, asked: str) -> tuple[Draft, dict[str, str]]:
    model, start = analyse_node(find_executable(asked, workspace))
    draft = Draft(model, "node_tests", "person", workspace / "draft", ros=start)
    return draft, dict(files(draft))


def test_an_executable_is_the_console_script_of_its_package(workspace: Path) -> None:
    assert find_executable("home_robot door", workspace).entry == "home_robot.door:main"
    assert find_executable("src/home_robot/home_robot/arm.py", workspace).entry == "home_robot.arm:main"
    assert find_executable("src/home_robot/home_robot/scanner.py", workspace).entry == "home_robot.scanner:Scanner"


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("home_robot dor", "package 'home_robot' has no Python executable 'dor'; nearest: door; it has door"),
        ("home_robt door", "package 'home_robt' is neither installed nor in "),
        ("home_robot", 'expected "PACKAGE EXECUTABLE"'),
        ("nothing/here.py", "there is no file "),
        ("src/home_robot/home_robot/arm.py:start", "has no start; give PATH.py:FUNCTION"),
        ("", 'expected "PACKAGE EXECUTABLE"'),
        ("plain.py", "expected a node of ROS 2; plain:main and the code that it imports use no rclpy"),
        ("src/home_robot/setup.py", "has no function main and no node class"),
    ],
)
def test_what_is_no_executable_is_one_sentence(
    asked: str, message: str, workspace: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (workspace / "plain.py").write_text("def main():\n    pass\n", encoding="utf-8")
    monkeypatch.chdir(workspace)
    assert main(["init", "draft", "--ros2", asked]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: init: --ros2")
    assert message in said
    assert said.count("\n") == 1


def test_values_parameters_and_names_have_their_places(workspace: Path) -> None:
    _, texts = drafted(workspace, "home_robot door")
    conftest = texts["conftest.py"]
    assert '"/home/lock": "std_srvs/srv/SetBool",  # home_robot/door.py:28' in conftest
    assert '"limits.open_s": 5.0,  # home_robot/door.py:12' in conftest
    assert 'Say("/home/commands", data="open"),  # home_robot/door.py:17' in conftest
    assert 'NodeDriver(\n        "home_robot.door:main",' in conftest
    assert "@home_commands_too_early " in texts["models/person.asl"]
    assert "on(home_commands) & home_commands.data == 'close'" in texts["requirements.toml"]


def test_fields_are_those_of_the_interface_files(workspace: Path) -> None:
    draft, texts = drafted(workspace, "src/home_robot/home_robot/scanner.py")
    parts = {part.name: (part.kind, part.type) for part in draft.code.inputs[0].fields}
    assert parts == {
        "limits.low": ("float", "float"),
        "limits.high": ("float", "float"),
        "limits.count": ("float", "int"),
        "ranges": ("float", "list"),
        "frame": ("str", "str"),
    }
    assert '**{"limits.count": Uniform(0, 10)},' in texts["conftest.py"]
    assert "ranges=Array(Uniform(" in texts["conftest.py"]
    assert 'HERE / "../src/scan_msgs"' in texts["conftest.py"]


def test_messages_that_are_nowhere_are_said_with_their_place(tmp_path: Path) -> None:
    (tmp_path / "transport.py").write_text(ros_robots.TRANSPORT, encoding="utf-8")
    draft, texts = drafted(tmp_path, "transport.py")
    missing = [problem for problem in draft.code.problems if "`transport_msgs`" in problem.text]
    assert [str(problem.location) for problem in missing] == ["transport.py:7"]
    assert '"/fetch": "transport_msgs/action/Fetch",  # transport.py:19' in texts["conftest.py"]


GUARDED = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool

try:
    from lamp_not_there_msgs.msg import Lamp
except ImportError:
    Lamp = None


class Guarded(Node):
    def __init__(self):
        super().__init__("guarded")
        self.create_subscription(Bool, "near", print, 10)
        if Lamp is not None:
            self.create_subscription(Lamp, "lamp", print, 10)
"""


def test_messages_whose_import_is_guarded_are_neither_missing_nor_declared(workspace: Path) -> None:
    (workspace / "guarded.py").write_text(GUARDED)
    model, start = analyse_node(find_executable("guarded.py", workspace))
    assert not [problem for problem in model.problems if "lamp_not_there_msgs" in problem.text]
    assert [endpoint.name for endpoint in start.declared] == ["/near"]


@pytest.mark.slow
@pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy")
def test_a_draft_for_a_node_is_green_at_once(workspace: Path) -> None:
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--ros2", "home_robot door", "--budget", "16"]
    made = subprocess.run(command, cwd=workspace, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    command = [sys.executable, "-m", "pytest", "-q", "--hri-audit=off", "--hri-tests=6"]
    done = subprocess.run(command, cwd=workspace / "draft", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "PASSED  6 passed" in done.stdout


PATROL = """
import rclpy
from rclpy.node import Node
from {package}.msg import Order


class Patrol(Node):
    def __init__(self):
        super().__init__("patrol")
        self.create_subscription(Order, "order", self.on_order, 10)

    def on_order(self, message):
        pass
"""


def test_a_package_of_messages_beside_a_node_is_no_code_under_test(tmp_path: Path) -> None:
    texts = {
        "bar_msgs/package.xml": "<package><name>bar_msgs</name></package>",
        "bar_msgs/msg/Order.msg": "string drink\n",
        "bar_msgs/msg/__init__.py": "from bar_msgs.msg._order import Order\n",  # of a build, in the sources of some
        "patrol.py": PATROL.replace("{package}", "bar_msgs"),
    }
    for name, text in texts.items():
        (tmp_path / "src" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "src" / name).write_text(text, encoding="utf-8")
    draft, _ = drafted(tmp_path, "src/patrol.py")
    assert draft.code.modules == ("patrol",)
    assert draft.ros is not None
    assert draft.ros.interfaces == (str(tmp_path / "src" / "bar_msgs"),)
    assert [part.name for part in draft.code.inputs[0].fields] == ["drink"]


@pytest.mark.skipif(find_spec("rosidl_adapter") is None, reason="needs rosidl_adapter")
def test_a_package_of_nodes_and_messages_is_both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    texts = {
        "package.xml": "<package><name>bar_robot</name></package>",
        "msg/Order.msg": "string drink\n",
        "bar_robot/__init__.py": "",
        "bar_robot/patrol.py": PATROL.replace("{package}", "bar_robot"),
        "bar_robot/tables.py": "TABLES = 3\n",
    }
    for name, text in texts.items():
        (tmp_path / "src" / "bar_robot" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "src" / "bar_robot" / name).write_text(text, encoding="utf-8")
    draft, _ = drafted(tmp_path, "src/bar_robot/bar_robot/patrol.py")
    assert draft.code.modules == ("bar_robot",)
    assert draft.ros is not None
    assert draft.ros.interfaces == (str(tmp_path / "src" / "bar_robot"),)
    monkeypatch.syspath_prepend(tmp_path / "src" / "bar_robot")
    provide_interfaces(draft.ros.interfaces)
    assert import_module("bar_robot.tables").TABLES == 3
    assert import_module("bar_robot.msg").Order(drink="tea").drink == "tea"


BEACON = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool


class Beacon(Node):
    def __init__(self):
        super().__init__("beacon")
        self.light = self.create_publisher(Bool, "light", 10)
        self.create_timer(0.05, lambda: self.light.publish(Bool(data=True)))
"""


def test_a_person_stays_with_a_node_that_hears_nothing_and_no_requirement_is_always_true(workspace: Path) -> None:
    (workspace / "beacon.py").write_text(BEACON, encoding="utf-8")
    model, start = analyse_node(find_executable("beacon.py", workspace))
    texts = dict(files(Draft(model, "beacon", "person", workspace / "hri", ros=start)))
    assert "stays_long <- stay(long)." in texts["models/person.asl"]
    assert '"stay long": {"after_s": Uniform(20.0, 60.0, "s")}' in texts["conftest.py"]
    formulas = [entry["formula"] for entry in tomllib.loads(texts["requirements.toml"]).values()]
    assert formulas[0] == "always(person_is_there -> eventually[0:60](on(light) | not person_is_there))"
    assert not [formula for formula in formulas if "once(" in formula]


def test_whole_numbers_of_which_nothing_is_known_are_more_than_0_and_1(workspace: Path) -> None:
    counter = SCANNER.replace("scan_msgs.msg import Scan", "scan_msgs.msg import Limits").replace("(Scan,", "(Limits,")
    (workspace / "counter.py").write_text(counter, encoding="utf-8")
    model, start = analyse_node(find_executable("counter.py", workspace))
    text = dict(files(Draft(model, "counter", "person", workspace / "hri", ros=start)))["conftest.py"]
    assert "count=Uniform(0, 10)" in text
    assert "low=Uniform(0.0, 1.0)" in text


def test_the_code_of_a_node_is_what_it_imports_and_not_the_other_nodes_of_its_package(workspace: Path) -> None:
    package = workspace / "src" / "home_robot" / "home_robot"
    (package / "hinges.py").write_text("COUNT = 2\n", encoding="utf-8")
    model, _ = analyse_node(find_executable("home_robot door", workspace))
    assert model.modules == ("home_robot.door", "home_robot.hinges")
    _, texts = drafted(workspace, "home_robot door")
    assert 'packages=("home_robot",),  # all of them see virtual time' in texts["conftest.py"]
    (package / "__init__.py").write_text("from home_robot import door\n", encoding="utf-8")
    model, _ = analyse_node(find_executable("home_robot door", workspace))
    assert model.modules == ("home_robot",)


SHUTTER = """
import json
import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Shutter(Node):
    def __init__(self):
        super().__init__("shutter")
        self.mode = "shut"
        self.pub = self.create_publisher(String, "mode", 10)
        self.create_subscription(String, "wish", self.on_wish, 10)

    def on_wish(self, msg):
        wish = json.loads(msg.data)
        if wish["do"] == "open":
            self.mode = "open"
        elif wish["do"] == "tilt":
            self.tilt(wish["angle"] / 2)
        self.pub.publish(String(data=self.mode))

    def tilt(self, angle):
        self.mode = "tilted"
"""


@pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy")
def test_a_person_says_the_json_that_a_callback_takes_a_text_for(tmp_path: Path) -> None:
    (tmp_path / "shutter.py").write_text(SHUTTER, encoding="utf-8")
    draft, texts = drafted(tmp_path, "shutter.py")
    (wish,) = draft.inputs
    assert [value.text for value in wish.message.fields[0].values] == ['{"do": "open"}', '{"do": "tilt", "angle": 1.0}']
    assert 'Say("/wish", data="{\\"do\\": \\"open\\"}")' in texts["conftest.py"]


@pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy")
def test_a_topic_that_has_only_states_of_an_attribute_is_the_state(tmp_path: Path) -> None:
    (tmp_path / "shutter.py").write_text(SHUTTER, encoding="utf-8")
    draft, _ = drafted(tmp_path, "shutter.py")
    assert (draft.code.state, draft.states) == ("", ("shut", "open", "tilted"))
    seen = Observations(states={"mode.data": {"shut": 2, "shut -> open": 1}, "wish.data": {"a": 1, "a -> b": 1}})
    made = replace(draft, declared=with_state_topic(draft.code, seen))
    assert (made.code.state, made.states) == ("mode.data", ("shut", "open", "tilted"))
    assert 'state=StateField(\n            "mode.data",' in dict(files(made))["conftest.py"]
    work = Settlement(made, None)
    assert work._drop_state(FirstRuns(1, 0, (), (), "ValueError: no state 'ajar'"))
    assert (work.draft.code.state, work.draft.states) == ("", made.states)  # declared, and not looked at


def test_a_package_that_is_one_node_is_drafted_as_a_node(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "door.py").write_text(ros_robots.DOOR, encoding="utf-8")
    (tmp_path / "arm.py").write_text(ros_robots.ARM, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "hri", "--from", "door.py", "--no-run"]) == 0
    assert "door.py is a node of ROS 2: drafted as with --ros2 door.py" in capsys.readouterr().out
    assert "NodeDriver(" in (tmp_path / "hri" / "conftest.py").read_text(encoding="utf-8")


def test_a_node_gets_stand_ins_for_libraries_that_are_not_installed(tmp_path: Path) -> None:
    source = "from wheel_driver_not_there import Wheels\n" + ros_robots.DOOR
    (tmp_path / "door.py").write_text(source, encoding="utf-8")
    draft, texts = drafted(tmp_path, "door.py")
    assert [problem.kind for problem in draft.code.problems] == ["missing module"]
    assert 'replace_modules("wheel_driver_not_there")  # not installed here' in texts["conftest.py"]
    compile(texts["conftest.py"], "conftest.py", "exec")


def test_numbers_in_arrays_are_signals_and_integers_are_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    class Limits:
        low, count = 0.0, 0

    class Scan:
        def __init__(self) -> None:
            self.limits, self.ranges = Limits(), array("f")

    monkeypatch.setitem(sys.modules, "scan_msgs.msg", SimpleNamespace(Scan=Scan))
    fields = {"limits.count": Uniform(0, 10), "ranges": Array(Uniform(0.0, 3.0), 2)}
    say = Say("/front/scan", **fields)
    driver = NodeDriver("scanner:main", subscriptions={"/front/scan": "scan_msgs/msg/Scan"}, says={"scan": say})
    assert driver.signals == {"person_is_there": bool, "front_scan_ranges": float}
    assert driver.ros2().topics == driver.subscriptions
    made = _fill("scan_msgs/msg/Scan", "", say.values({"limits.count": 3.7, "ranges": 1.5}))
    assert (made.limits.count, made.ranges) == (4, [1.5, 1.5])
