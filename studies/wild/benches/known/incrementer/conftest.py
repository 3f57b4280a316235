from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
SOURCE = HERE / "src/teleop_tools/joy_teleop/joy_teleop/incrementer_server.py"
PREFIX = "/joint_trajectory_controller" if "namespace=" in SOURCE.read_text() else ""  # both commits, one testbench
KIND = "teleop_tools_msgs/action/Increment"


@dataclass(frozen=True)
class Asked:
    by: float


@dataclass(frozen=True)
class Answered:
    """A goal has come to its end."""


def pytest_hricdv_testbench(config):
    asks = {"by": Uniform(-0.3, 0.3, "rad"), "then_s": Uniform(0.2, 2.0, "s")}
    return Testbench(
        name="incrementer",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_move", "two_moves"), groups={"manner": ("calm", "hasty")}),
        concretization=Concretization(commands={"move": asks, "rest": {"then_s": Uniform(0.5, 2.0, "s")}}),
        requirements=HERE / "requirements.toml",
        messages=(Asked, Answered),
        signals={"goal_rad": float, "asked_rad": float},
        code=("joy_teleop.incrementer_server",),
        ros2=Ros2(actions={f"{PREFIX}/increment": KIND},
                  interfaces=("src/teleop_tools/teleop_tools_msgs", "src/control_msgs/control_msgs")),
        run=run,
    )


def run(run):
    from control_msgs.msg import JointTrajectoryControllerState
    from trajectory_msgs.msg import JointTrajectory

    ros, bus = run.ros2(RosNode(entry="joy_teleop.incrementer_server:main", name="incrementer_server")), run.bus.port("person")
    position = [0.0]

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def controller():
        states = ros.node("controller").publisher(f"{PREFIX}/state", JointTrajectoryControllerState)
        while True:
            message = JointTrajectoryControllerState(joint_names=["spine"])
            message.actual.positions = [position[0]]
            states.publish(message)
            run.kernel.sleep(0.05)

    def joint():
        goals = ros.node("joint").subscribe(f"{PREFIX}/joint_trajectory" if PREFIX else "/command", JointTrajectory)
        while True:
            message = goals.wait(60.0)
            if message is not None:
                position[0] = message.points[0].positions[0]
                record(goal_rad=position[0])

    def person():
        record(goal_rad=0.0, asked_rad=0.0)
        increment = ros.node("person").action(f"{PREFIX}/increment", KIND)
        run.kernel.sleep(1.0)
        for action in run.actions():
            if action.command == "move":
                bus.publish(Asked(action.parameters["by"]))
                record(asked_rad=position[0] + action.parameters["by"])
                if increment.call(5.0, increment_by=[action.parameters["by"]]) is not None:
                    bus.publish(Answered())
            run.kernel.sleep(action.parameters["then_s"])
        run.kernel.stop("the person has left")

    for each in (controller, joint, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=60.0))
