
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import yaml
from pytest_hricdv.runtime.virtual.clocks import EPOCH
from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, Uniform

HERE = Path(__file__).parent
PLACES = {"far": (2.0, 0.0), "near": (0.3, 0.0), "middle": (0.6, 0.0), "left": (0.5, 1.0), "beside": (0.0, 0.6)}
PACKAGE = HERE / "src/leo_examples-ros2/leo_example_follow_aruco_marker"
VALUES = yaml.safe_load((PACKAGE / "config/follower.yaml").read_text())["/**"]["ros__parameters"]
made = ModuleType("leo_example_follow_aruco_marker.follower_parameters")  # that a build generates
made.follower_parameters = SimpleNamespace(Params=object, ParamListener=lambda node: SimpleNamespace(
    get_params=lambda: SimpleNamespace(**VALUES, follow_enabled=True), set_user_callback=lambda callback: None))
sys.modules.update({made.__name__.partition(".")[0]: ModuleType("package"), made.__name__: made})


def pytest_hricdv_testbench(config):
    commands = (*(f"walk {place}" for place in PLACES), "hide", "clock_ahead", "odometry_comes")
    return Testbench(
        name="aruco_follower",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_walk", "two_walks"), groups={
            "way": ("comes_near", "aside", "passes"), "end": ("hides", "hides_late", "odometry")}),
        concretization=Concretization(commands={name: {"for_s": Uniform(0.5, 4.0, "s")} for name in commands}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"speed": float, "turn": float, "near": bool, "on_left": bool, "in_sight": bool},
        code=("leo_follow_aruco",),
        ros2=Ros2(interfaces=("src/ros_aruco_opencv/aruco_opencv_msgs",)),
        run=run,
    )


def run(run):
    from aruco_opencv_msgs.msg import ArucoDetection, MarkerPose
    from geometry_msgs.msg import Twist
    from nav_msgs.msg import Odometry
    ros = run.ros2(RosNode(entry="leo_follow_aruco.aruco_follower_node:ArucoMarkerFollower"))
    seen, ahead_s, wheels = [None], [0.0], []

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    def stamp(header, ahead_s):
        header.stamp.sec = int(EPOCH.timestamp() + run.kernel.now_s + ahead_s)
        header.stamp.nanosec = run.kernel.now_us % 1_000_000 * 1000

    def camera():
        detections = ros.node("camera").publisher("/aruco_detections", ArucoDetection)
        odometry = ros.node("base").publisher("/merged_odom", Odometry)
        while True:
            message, place, marker = ArucoDetection(), Odometry(), MarkerPose(marker_id=0)
            stamp(message.header, ahead_s[0])
            stamp(place.header, 0.0)
            marker.pose.position.x, marker.pose.position.y = seen[0] or (0.0, 0.0)
            message.markers = [marker] * bool(seen[0])
            detections.publish(message)
            wheels and odometry.publish(place)
            run.kernel.sleep(0.1)

    def base():
        commands = ros.node("base").subscribe("/cmd_vel", Twist)
        while True:
            message = commands.wait(60.0)
            if message is not None:
                record(speed=message.linear.x, turn=message.angular.z)

    def person():
        record(speed=0.0, turn=0.0, near=False, on_left=False, in_sight=False)
        for action in run.actions():
            verb, _, place = action.command.partition(" ")
            ahead_s[0] += 3.0 * (verb == "clock_ahead")
            wheels.extend([True] * (verb == "odometry_comes"))
            seen[0] = PLACES.get(place)
            record(near=place == "near", on_left=place in ("left", "beside"), in_sight=bool(seen[0]))
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    for each in (camera, base, person):
        run.kernel.spawn(each.__name__, each)
    return Outcome(run.go(limit_s=120.0))
