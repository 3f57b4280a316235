"""Stand-ins for what surrounds a node: each is used here as a testbench uses it."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import pytest

from pytest_hricdv.declarations.ros2 import Ros2
from pytest_hricdv.extra.ros2.messages import import_type
from pytest_hricdv.extra.ros2.world import StartedSystem
from pytest_hricdv.ros2 import JointTrajectoryFollower, Laser, ManagedNode, Navigation, PlanarBase, PlanarPose
from tests.docs.page import blocks
from tests.extra.ros2.test_bridge import Cell

SQUARE = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]


class World(Cell):
    """A run with a system whose nodes are all of the world."""

    def __init__(self) -> None:
        super().__init__(Ros2())
        self.ros: Any = StartedSystem(self.kernel)

    def play(self, body: Callable[[], None]) -> None:
        """Run it, and end with it."""

        def until_done() -> None:
            body()
            self.kernel.stop("done")

        self.run(until_done)


@pytest.fixture
def world(ros_messages: None) -> World:
    return World()


def message(kind: str, **fields: Any) -> Any:
    return import_type(kind, kind.split("/")[1])(**fields)


def about(x_m: float, y_m: float, heading_rad: float) -> Any:
    """A pose to compare with."""
    return PlanarPose(*(pytest.approx(value) for value in (x_m, y_m, heading_rad)))  # type: ignore[arg-type]


def twist(forward_m_s: float, turn_rad_s: float = 0.0) -> Any:
    made = message("geometry_msgs/msg/Twist")
    made.linear.x, made.angular.z = forward_m_s, turn_rad_s
    return made


def pose(x_m: float, y_m: float, heading_rad: float = 0.0) -> Any:
    made = message("geometry_msgs/msg/PoseStamped")
    made.pose.position.x, made.pose.position.y = x_m, y_m
    made.pose.orientation.z, made.pose.orientation.w = math.sin(heading_rad / 2), math.cos(heading_rad / 2)
    return made


def test_a_base_drives_as_it_is_told_and_says_where_it_is(world: World) -> None:
    base = PlanarBase(world.ros, stops_after_s=1.5)
    node = world.ros.node("driver")
    commands = node.publisher("/cmd_vel", "geometry_msgs/msg/Twist")
    odometry, transforms = (
        node.subscribe("/odom", "nav_msgs/msg/Odometry"),
        node.subscribe("/tf", "tf2_msgs/msg/TFMessage"),
    )
    last: dict[str, Any] = {}

    def driver() -> None:
        commands.publish(twist(0.5))
        world.kernel.sleep(1.0)
        commands.publish(twist(0.5, math.pi / 2))
        world.kernel.sleep(1.0)
        assert base.pose == about(0.5 + 1 / math.pi, 1 / math.pi, math.pi / 2)
        world.kernel.sleep(5.0)
        for name, queue in (("odom", odometry), ("tf", transforms)):
            while (received := queue.poll()) is not None:
                last[name] = received

    world.play(driver)
    assert (base.forward_m_s, base.turn_rad_s) == (0.0, 0.0)  # it has stopped without commands
    odom, transform = last["odom"], last["tf"].transforms[0]
    assert (odom.header.frame_id, odom.child_frame_id, transform.child_frame_id) == ("odom", "base_link", "base_link")
    where = odom.pose.pose.position
    assert (where.x, where.y) == (transform.transform.translation.x, transform.transform.translation.y)
    assert (where.x, where.y) == (base.pose.x_m, base.pose.y_m)


def test_a_laser_sees_walls_and_what_moves_with_seeded_noise(world: World) -> None:
    legs = [[(1.0, -0.1), (1.2, -0.1), (1.2, 0.1), (1.0, 0.1)]]
    polygons = lambda: [SQUARE, *(legs if world.kernel.now_s >= 0.5 else [])]  # noqa: E731
    base = PlanarBase(world.ros, PlanarPose(0.0, 0.0, math.pi / 2), odom="", tf="")
    Laser(world.ros, lambda: base.pose, polygons, samples=4, angle_max_rad=math.pi / 2, range_m=(0.5, 1.9))
    options: Any = {"samples": 9, "noise_m": 0.01}
    noisy = [
        Laser(
            world.ros, lambda: base.pose, [SQUARE], generator=random.Random(7), topic=topic, node=topic[1:], **options
        )
        for topic in ("/one", "/other")
    ]
    scans = world.ros.node("driver").subscribe("/scan", "sensor_msgs/msg/LaserScan")
    seen: list[Any] = []

    def driver() -> None:
        seen.extend([scans.wait(1.0)])
        world.kernel.sleep(0.55)
        while (scan := scans.poll()) is not None:
            seen.append(scan)

    world.play(driver)
    # Rays at -180, -90, 0 and 90 degrees from its heading, which is 90 degrees.
    assert list(seen[0].ranges) == [math.inf, math.inf, math.inf, math.inf]
    assert list(seen[-1].ranges) == [math.inf, pytest.approx(1.0), math.inf, math.inf]
    first, second = (laser.scan() for laser in noisy)
    assert first.ranges == second.ranges != noisy[0].scan().ranges
    assert first.ranges[4] == pytest.approx(2.0, abs=0.05)


def test_navigation_drives_a_base_to_a_pose(world: World) -> None:
    base = PlanarBase(world.ros, odom="", tf="")
    Navigation(world.ros, base, speed_m_s=0.5, reaches=lambda pose: pose.x_m < 10).navigate_to_pose()
    client = world.ros.node("commander").action("/navigate_to_pose", "nav2_msgs/action/NavigateToPose")
    seen: list[Any] = []

    def commander() -> None:
        goal = client.send(1.0, pose=pose(3.0, 4.0, 1.0))
        seen.append(goal.feedback(1.0).distance_remaining)
        seen.append((goal.result(60.0).status, world.kernel.now_s, base.pose))
        other = client.send(1.0, pose=pose(3.0, 0.0))
        world.kernel.sleep(2.0)
        seen.append((other.cancel(1.0), other.result(1.0).status, base.pose.y_m))
        seen.append(client.call(60.0, pose=pose(30.0, 0.0)).status)

    world.play(commander)
    assert seen == [
        pytest.approx(5.0),
        (4, pytest.approx(10.0), about(3.0, 4.0, 1.0)),
        (True, 5, pytest.approx(3.0, abs=0.06)),
        6,
    ]


def trajectory(*points: tuple[float, float, float], joints: tuple[str, ...] = ("lift", "turn")) -> Any:
    made = message("trajectory_msgs/msg/JointTrajectory", joint_names=[*joints])
    for time_s, *positions in points:
        point = message("trajectory_msgs/msg/JointTrajectoryPoint", positions=positions)
        point.time_from_start.sec, point.time_from_start.nanosec = int(time_s), round(time_s % 1 * 1e9)
        made.points.append(point)
    return made


def test_an_arm_follows_a_trajectory_and_refuses_a_wrong_one(world: World) -> None:
    arm = JointTrajectoryFollower(world.ros, {"lift": 0.0, "turn": 1.0})
    client = world.ros.node("planner").action(
        "/arm_controller/follow_joint_trajectory", "control_msgs/action/FollowJointTrajectory"
    )
    seen: list[Any] = []

    def planner() -> None:
        wrong = [trajectory((1.0, 0.0, 0.0), joints=("lift", "tilt")), trajectory()]
        wrong.append(trajectory((1.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
        seen.extend(client.call(1.0, trajectory=refused) for refused in wrong)
        goal = client.send(1.0, trajectory=trajectory((1.0, 1.0, 1.0), (2.5, 1.0, 4.0)))
        world.kernel.sleep(1.5)
        seen.append(dict(arm.positions))
        seen.append((goal.result(5.0).status, dict(arm.positions), world.kernel.now_s))
        other = client.send(1.0, trajectory=trajectory((2.0, 0.0, 0.0)))
        world.kernel.sleep(1.0)
        seen.append((other.cancel(1.0), other.result(1.0).status, arm.positions["lift"]))
        third = client.send(1.0, trajectory=trajectory((2.0, 0.0, 0.0)))
        fourth = client.send(1.0, trajectory=trajectory((1.0, 3.0, 3.0)))
        seen.append((third.result(5.0).status, third.result(5.0).result.error_code, fourth.result(5.0).status))

    world.play(planner)
    assert seen == [
        None,
        None,
        None,
        {"lift": 1.0, "turn": pytest.approx(2.0, abs=0.11)},
        (4, {"lift": 1.0, "turn": 4.0}, 2.5),
        (True, 5, pytest.approx(0.5)),
        (6, -1, 4),
    ]


def test_a_managed_node_goes_through_its_transitions(world: World) -> None:
    asked: list[str] = []

    def activates_at_the_second_attempt(label: str) -> bool:
        asked.append(label)
        return len(asked) != 2

    node = ManagedNode(world.ros, "map_server", activates_at_the_second_attempt)
    manager = world.ros.node("manager")
    change = manager.client("/map_server/change_state", "lifecycle_msgs/srv/ChangeState")
    state = manager.client("/map_server/get_state", "lifecycle_msgs/srv/GetState")
    possible = manager.client("/map_server/get_available_transitions", "lifecycle_msgs/srv/GetAvailableTransitions")
    states = manager.client("/map_server/get_available_states", "lifecycle_msgs/srv/GetAvailableStates")
    events = manager.subscribe("/map_server/transition_event", "lifecycle_msgs/msg/TransitionEvent")
    seen: list[Any] = []

    def going() -> None:
        for number in (3, 1, 3, 3):
            transition = message("lifecycle_msgs/msg/Transition", id=number)
            seen.append((change.call(1.0, transition=transition).success, state.call(1.0).current_state.label))
        by_label = message("lifecycle_msgs/msg/Transition", label="shutdown")
        seen.append((change.call(1.0, transition=by_label).success, node.state))
        seen.append(len(possible.call(1.0).available_transitions))
        seen.append(len(states.call(1.0).available_states))
        seen.append([events.poll().transition.label for _ in range(4)])

    world.play(going)
    assert seen[:5] == [
        (False, "unconfigured"),
        (True, "inactive"),
        (False, "inactive"),
        (True, "active"),
        (True, "finalized"),
    ]
    assert seen[5:] == [0, 11, ["configure", "transition_success", "activate", "transition_failure"]]
    assert asked == ["configure", "activate", "activate", "shutdown"]


def test_the_example_of_the_page_stands_in_for_a_robot(world: World) -> None:
    names: dict[str, Any] = {}
    exec(next(block.text for block in blocks("ros2.md") if block.name == "fakes.py"), names)
    seen: list[Any] = []

    def driver() -> None:
        base = names["fakes"](world.ros)
        client = world.ros.node("driver").action("/navigate_to_pose", "nav2_msgs/action/NavigateToPose")
        seen.append(client.call(60.0, pose=pose(1.0, 0.0)).status)
        scans = world.ros.node("driver").subscribe("/scan", "sensor_msgs/msg/LaserScan")
        seen.append((base.pose, min(scans.wait(1.0).ranges)))

    world.play(driver)
    assert seen == [4, (PlanarPose(1.0, 0.0), pytest.approx(1.0, abs=0.05))]
