import math
import os
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
os.environ["LDS_MODEL"] = "LDS-01"
TAPE = (-0.9, 0.1)  # where the reflecting tape at the parking place is: behind the robot, which starts at the origin


def pytest_hricdv_testbench(config):
    commands = ("wait", "scan stops", "scan free", "step_behind", "step_off")
    return Testbench(
        name="automatic_parking",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("early", "late"), groups={"trouble": ("cable", "person_behind", "no_echo")}),
        concretization=Concretization(commands={name: {"for_s": Uniform(2.0, 30.0, "s")} for name in commands}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"speed": float, "scanning": bool, "behind": bool},
        code=("turtlebot3_automatic_parking",),
        ros2=Ros2(),
        time=VirtualTime(apis=("time",), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from geometry_msgs.msg import Twist
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import LaserScan

    ros = run.ros2(RosNode(package="turtlebot3_automatic_parking", executable="turtlebot3_automatic_parking", workspace=["src"]))
    pose, origin, speed, scan, behind = [0.0] * 3, [0.0] * 3, [0.0, 0.0], ["works"], [False]

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def rays():
        for degree in range(360):
            tape_away, tape_angle = math.dist(pose[:2], TAPE), math.atan2(TAPE[1] - pose[1], TAPE[0] - pose[0])
            off = abs(math.remainder(math.radians(degree) + pose[2] - tape_angle, math.tau))
            if behind[0] and abs(degree - 180) < 30:
                yield 0.15, 100.0
            elif off < math.atan(0.12 / max(tape_away, 0.01)):
                yield tape_away, 6000.0
            else:
                yield (0.0 if scan[0] == "free" else 2.0), 100.0

    def robot():
        scans, odometry = ros.node("robot").publisher("/scan", LaserScan), ros.node("wheels").publisher("/odom", Odometry)
        while True:
            run.kernel.sleep(0.1)
            pose[2] += speed[1] * 0.1
            pose[0] += speed[0] * 0.1 * math.cos(pose[2])
            pose[1] += speed[0] * 0.1 * math.sin(pose[2])
            place = Odometry()
            place.pose.pose.position.x, place.pose.pose.position.y = pose[0] - origin[0], pose[1] - origin[1]
            place.pose.pose.orientation.z = math.sin((pose[2] - origin[2]) / 2)
            place.pose.pose.orientation.w = math.cos((pose[2] - origin[2]) / 2)
            odometry.publish(place)
            if scan[0] != "stops":
                ranges, intensities = zip(*rays())
                scans.publish(LaserScan(ranges=ranges, intensities=intensities))

    def base():
        commands, resets = ros.node("base").subscribe("/cmd_vel", Twist), ros.node("base").subscribe("/reset", "std_msgs/msg/Empty")
        while True:
            message = commands.wait(0.1)
            if resets.poll() is not None:
                origin[:] = pose
            if message is not None:
                speed[:] = message.linear.x, message.angular.z
                record(speed=message.linear.x)

    def person():
        record(speed=0.0, scanning=True, behind=False)
        for action in run.actions():
            verb, _, what = action.command.partition(" ")
            scan[0] = what or scan[0]
            behind[0] = {"step_behind": True, "step_off": False}.get(verb, behind[0])
            record(scanning=scan[0] != "stops", behind=behind[0])
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.sleep(60.0)
        run.kernel.stop("the person has left")

    for each in (robot, base, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=300.0))
