from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
WAYS = {"ahead": (0.3, 0.0), "turns": (0.0, 0.6), "curve": (0.2, -0.4), "zero": (0.0, 0.0)}


@dataclass(frozen=True)
class Command:
    """The person's program has sent one that is not zero."""


@dataclass(frozen=True)
class Stopped:
    """The base went, and was told to stand by the node."""


def pytest_hricdv_testbench(config):
    sends = {"for_s": Uniform(0.05, 3.0, "s"), "period_s": Uniform(0.03, 0.19, "s")}
    return Testbench(
        name="command_timeout",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_drive", "two_drives"), groups={"way": ("ahead", "turns", "curve", "stops")}),
        concretization=Concretization(
            commands={**{f"drive {way}": sends for way in WAYS}, "leave": {"for_s": Uniform(0.6, 3.0, "s")}}
        ),
        requirements=HERE / "requirements.toml",
        messages=(Command, Stopped),
        signals={"speed": float},
        code=("scripts",),
        ros2=Ros2(topics={"/cmd_vel": "geometry_msgs/msg/Twist"}),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import Twist

    ros = run.ros2(RosNode(entry="scripts.command_timeout:main"))
    bus = run.bus.port("person")
    mine = []

    def base():
        commands = ros.node("base").subscribe("/cmd_vel", Twist)
        run.recorder.signal(0.0, "speed", 0.0)
        while True:
            message = commands.wait(60.0)
            if message is not None:
                if not mine:
                    bus.publish(Stopped())
                elif mine.pop(0):
                    bus.publish(Command())
                run.recorder.signal(run.kernel.now_s, "speed", abs(message.linear.x) + abs(message.angular.z))

    def person():
        sender = ros.node("person").publisher("/cmd_vel", Twist)
        for action in run.actions():
            end_s = run.kernel.now_s + action.parameters["for_s"]
            while run.kernel.now_s < end_s:
                if action.command != "leave":
                    message = Twist()
                    message.linear.x, message.angular.z = WAYS[action.command.partition(" ")[2]]
                    mine.append(any(WAYS[action.command.partition(" ")[2]]))
                    sender.publish(message)
                run.kernel.sleep(min(action.parameters.get("period_s", 1.0), max(end_s - run.kernel.now_s, 1e-3)))
        run.kernel.sleep(1.0)
        run.kernel.stop("the person has left")

    for each in (base, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
