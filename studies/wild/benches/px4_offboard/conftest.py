import math
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
STATUS, MODE, PLACE = "/fmu/out/vehicle_status", "/fmu/in/offboard_control_mode", "/fmu/in/trajectory_setpoint"


@dataclass(frozen=True)
class FirstPlace:
    """Where the program wants the drone as soon as it has it."""

    distance_m: float


def pytest_hricdv_testbench(config):
    commands = ("arm", "disarm", "take_back", "hand_over short", "link_fails", "link_returns")
    times = {**{name: Uniform(0.5, 3.0, "s") for name in commands}, "hand_over long": Uniform(3.0, 9.0, "s")}
    return Testbench(
        name="px4_offboard",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(
            start=("one_flight", "two_flights", "not_armed"), groups={"flight": ("short", "long", "silent")}
        ),
        concretization=Concretization(commands={name: {"for_s": time} for name, time in times.items()}),
        requirements=HERE / "requirements.toml",
        messages=(FirstPlace,),
        signals={"handed_over": bool},
        code=("px4_offboard.offboard_control",),
        ros2=Ros2(
            topics={STATUS: "px4_msgs/msg/VehicleStatus", MODE: "px4_msgs/msg/OffboardControlMode",
                    PLACE: "px4_msgs/msg/TrajectorySetpoint"},
            interfaces=("src/px4_msgs",),
        ),
        run=run,
    )


def run(run):
    from px4_msgs.msg import TrajectorySetpoint, VehicleStatus
    parameters = [{"radius": 10.0, "altitude": 5.0, "omega": 0.5}]  # as its launch file has them
    ros = run.ros2(RosNode(entry="px4_offboard.offboard_control:main", parameters=parameters))
    status, link, place, fresh = VehicleStatus(), [True], [0.0, 0.0, -5.0], [True]
    status.arming_state, status.nav_state = VehicleStatus.ARMING_STATE_DISARMED, VehicleStatus.NAVIGATION_STATE_POSCTL

    def is_given():
        armed = status.arming_state == VehicleStatus.ARMING_STATE_ARMED
        return armed and status.nav_state == VehicleStatus.NAVIGATION_STATE_OFFBOARD

    def drone():
        sender = ros.node("drone").publisher(STATUS, VehicleStatus)
        while True:
            if link[0]:
                sender.publish(status)
            run.kernel.sleep(0.1)

    def motors():
        places = ros.node("motors").subscribe(PLACE, TrajectorySetpoint)
        while True:
            message = places.wait(60.0)
            if message is not None and is_given():
                if fresh[0]:
                    run.bus.port("motors").publish(FirstPlace(math.dist(place, message.position)))
                place[:], fresh[0] = [float(each) for each in message.position], False

    def person():
        run.recorder.signal(0.0, "handed_over", False)
        run.kernel.sleep(1.0)
        for action in run.actions():
            if action.command in ("arm", "disarm"):
                status.arming_state = 2 if action.command == "arm" else 1
            elif action.command.startswith("link"):
                link[0] = action.command == "link_returns"
            else:
                status.nav_state = 14 if action.command.startswith("hand") else 2
                place[0] += 3.0 * (status.nav_state == 2)  # the pilot flies elsewhere
                fresh[0] = True
            run.recorder.signal(run.kernel.now_s, "handed_over", is_given())
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the pilot has landed")

    for each in (drone, motors, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
