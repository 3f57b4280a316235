import os
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import (BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform,
                                     VirtualTime)

HERE = Path(__file__).parent
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "0"  # as by default; it sets velocities to whole numbers
ACTION, KIND = "/joint_trajectory_controller/follow_joint_trajectory", "control_msgs/action/FollowJointTrajectory"


@dataclass(frozen=True)
class Failed:
    """A goal was refused or aborted."""


@dataclass(frozen=True)
class Complained:
    """The program has logged an error."""


@dataclass(frozen=True)
class Begun:
    """A trajectory whose first point is due at once begins: how far (rad) the arm is from there."""

    away_rad: float


def pytest_hricdv_testbench(config):
    return Testbench(
        name="example_move",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_run",), groups={"manner": ("watches", "stops", "is_off")}),
        concretization=Concretization(
            commands={"wait": {"for_s": Uniform(2.0, 30.0, "s")}, "emergency_stop": {}, "refuse": {}}
        ),
        requirements=HERE / "requirements.toml",
        messages=(Failed, Complained, Begun),
        signals={},
        code=("example_move",),
        ros2=Ros2(actions={ACTION: KIND}, interfaces=("src/control_msgs/control_msgs",)),
        time=VirtualTime(allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from rcl_interfaces.msg import Log

    ros = run.ros2(RosNode(entry="example_move:main"))
    bus, pressed, refuses, at = run.bus.port("arm"), [False], [False], [[0.0] * 6]

    def accept(goal):
        if refuses[0]:
            bus.publish(Failed())
        return not refuses[0]

    def follow(goal):
        points = goal.request.trajectory.points
        if not points[0].time_from_start.sec:
            bus.publish(Begun(max(abs(a - b) for a, b in zip(points[0].positions, at[0]))))
        for _ in range(10 * points[-1].time_from_start.sec):
            if goal.wait(0.1) or pressed[0]:
                bus.publish(Failed())
                return goal.abort(error_code=-4, error_string="emergency stop")
        at[0] = list(points[-1].positions)
        goal.succeed()

    ros.node("controller").serve_action(ACTION, KIND, follow, accept=accept)

    def log():
        lines = ros.node("log").subscribe("/rosout", Log)
        while True:
            line = lines.wait(60.0)
            if line is not None and line.level >= 40:
                bus.publish(Complained())

    def person():
        for action in run.actions():
            pressed[0] |= action.command == "emergency_stop"
            refuses[0] |= action.command == "refuse"
            run.kernel.sleep(action.parameters.get("for_s", 0.0))
        run.kernel.sleep(31.0)
        run.kernel.stop("the person has left")

    for each in (log, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=200.0))
