"""The testbench of a robot: a person says go and stop; the robot's ports are a motor and counters. No physics."""

import importlib
import json
from pathlib import Path

from pytest_hricdv.testbench import (
    BeliefSpace,
    Concretization,
    Model,
    Outcome,
    Ros2,
    RosNode,
    Suites,
    Testbench,
    Uniform,
    VirtualTime,
)

HERE = Path(__file__).parent
RACE = json.loads((HERE / "race.json").read_text(encoding="utf-8"))
SIGNALS = {"moving": bool, "given": float, "active": float, "lost": float}


def pytest_hricdv_testbench(config):
    from messages import Done, Go, Stop

    pause = {"pause_s": Uniform(*RACE["pause_s"], "s")}
    topics = {"/go": "std_msgs/msg/Empty", "/stop": "std_msgs/msg/Empty"}
    return Testbench(
        name="race",
        model=Model(HERE / "race.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("go",), groups={"n": ("once", "twice")}, id_groups=("n",)),
        concretization=Concretization(commands=dict.fromkeys(RACE["commands"], pause)),
        requirements=HERE / "requirements.toml",
        messages=() if RACE["ros2"] else (Done, Go, Stop),
        signals=SIGNALS,
        code=tuple(RACE["code"]),
        run=run_nodes if RACE["ros2"] else run,
        ros2=Ros2(topics=topics) if RACE["ros2"] else None,
        time=VirtualTime(apis=("time", "threading", "asyncio"), allowed_endings=("limit",)),
        suites=Suites(random_test_length=(4, 8)),
    )


class Ports:
    """The robot's motor and counters."""

    def __init__(self, run):
        self._run = run
        self._values = {name: kind() for name, kind in SIGNALS.items()}
        self.asked = 0
        for name in SIGNALS:
            self.set(name, self._values[name])

    def set(self, name, value):
        self._values[name] = value
        self._run.recorder.signal(self._run.kernel.now_s, name, value)

    def move(self, on):
        self.set("moving", on)

    def give(self):
        self.set("given", self._values["given"] + 1)

    def begin(self):
        self.set("active", self._values["active"] + 1)

    def end(self):
        self.set("active", self._values["active"] - 1)

    def show(self, count):
        """A display of what two counters have counted: each counts what the person asks for."""
        self.set("lost", 2 * self.asked - count)


def person(run, ports, publish):
    for action in run.actions():
        run.kernel.sleep(action.parameters["pause_s"])
        ports.asked += action.command == "go"
        publish(action.command)
    run.kernel.sleep(2.5)
    run.kernel.stop("the person has left")


def run(run):
    from messages import Go, Stop

    module, ports = importlib.import_module("robot"), Ports(run)
    robot = getattr(module, RACE["class"])(ports, run.bus.port("robot"))
    bus = run.bus.port("person")
    sent = {"go": Go, "stop": Stop}
    run.kernel.spawn("person", lambda: person(run, ports, lambda command: bus.publish(sent[command]())))
    run.kernel.spawn("robot", run.measured(robot.work))
    return Outcome(run.go(limit_s=60.0))


def run_nodes(run):
    from std_msgs.msg import Bool, Empty

    ports = Ports(run)
    ros = run.ros2(RosNode(entry=f"robot:work_{RACE['class'].lower()}"))

    def motor():
        moving = ros.node("motor").subscribe("/moving", Bool)
        while True:
            message = moving.wait(60.0)
            if message is not None:
                ports.move(message.data)

    node = ros.node("person")
    sent = {command: node.publisher(f"/{command}", Empty) for command in RACE["commands"]}
    run.kernel.spawn("motor", motor)
    run.kernel.spawn("person", lambda: person(run, ports, lambda command: sent[command].publish(Empty())))
    return Outcome(run.go(limit_s=60.0))
