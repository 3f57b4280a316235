"""The controller's ports for clock, arm and hand, as blocking calls in virtual time.

The calls do little, because they run in the controller's greenlet, where code coverage is traced. Paths are planned by
a separate node.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress

from controller.ports import JointPose, Path, PlanningError
from pytest_hricdv.runtime import Kernel, Node
from sim.leg_supply import PressureSensor
from sim.planner import Query, find_path, is_cached
from sim.timing import ArmPath, Segment, time_path
from sim.world import World

ARRIVED_RAD = 0.005
"""A joint this near to its goal has arrived. Chosen: from 0.002 to 0.02 the records are the same, as of LATE_S."""

START_RAD = 0.02
"""An arm follows a path only from a pose this near to its start. Chosen: from 0.005 to 0.1 the records are the same."""

LATE_S = 1.0
"""An arm that is not at rest this long after the planned time has been blocked. From 0.3 to 3 s the records are the
same (as of `sim.world.REST_TICKS`): who is not blocked is at rest after `sim.timing.SETTLE_S`."""

CLOSING_LIMIT_S = 3.0
OPENING_LIMIT_S = 1.0
"""How long the hand waits until its fingers are at rest."""


class RobotClock:
    """The simulated time; a `controller.ports.Clock`."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel

    def now_s(self) -> float:
        """Seconds since the start of the run."""
        self._kernel.count_poll()
        return self._kernel.now_s

    def sleep(self, duration_s: float) -> None:
        """Block for some seconds of simulated time."""
        self._kernel.sleep(duration_s)


class RobotArm:
    """Plans and follows paths of the arm; a `controller.ports.Arm`. Create it outside of any node: it spawns one."""

    def __init__(self, kernel: Kernel, world: World, pressure: PressureSensor) -> None:
        self._kernel = kernel
        self._world = world
        self._pressure = pressure
        self._task: Query | None = None
        self._waiting_node: Node | None = None
        self._planner = kernel.spawn("planner", self._plan_on_demand)

    def plan(self, waypoints: Sequence[JointPose], max_speed_rad_s: float) -> ArmPath:
        """A path from the arm's present pose through `waypoints` (rad), all joints slower than `max_speed_rad_s`.

        Raises:
            PlanningError: a waypoint is not a pose within the limits, or the path collides with table, bin, torso or
                somebody in the way.
        """
        start = self._world.torso.arm_angles()
        time_path(start, waypoints, max_speed_rad_s)  # refuses waypoints that are no poses
        query = (start, tuple(waypoints), self._world.bystander.places, self._world.engine_name)
        if not is_cached(*query):
            self._request_search(query)
        return time_path(start, find_path(*query), max_speed_rad_s)

    def follow(self, path: Path) -> bool:
        """Move along `path`, with a stop at each waypoint; blocks until the arm is at rest; True when it has arrived.

        Returns False without moving if the arm is not at the path's start: it would move too fast.
        """
        if not isinstance(path, ArmPath):
            raise TypeError(f"an arm follows a path of its own plan(), not {path!r}")
        arrived = self._world.torso.stands_at(path.start, START_RAD)
        for segment in path.segments:
            if not arrived:
                break
            arrived = self._go(segment)
        self._pressure.tare()
        return arrived

    def _go(self, segment: Segment) -> bool:
        torso = self._world.torso
        self._world.unfreeze()
        torso.move_arm(segment.goal, segment.duration_s, segment.ramp_s)
        self._kernel.sleep(segment.duration_s)
        return wait_until(self._kernel, self._world, lambda: torso.stands_at(segment.goal, ARRIVED_RAD), LATE_S)

    def _request_search(self, query: Query) -> None:
        self._task, self._waiting_node = query, self._kernel.current()
        self._kernel.wake(self._planner)
        self._kernel.block()

    def _plan_on_demand(self) -> None:
        while True:
            if self._task is not None and self._waiting_node is not None:
                with suppress(PlanningError):  # cached, and raised again in plan()
                    find_path(*self._task)
                asking, self._task, self._waiting_node = self._waiting_node, None, None
                self._kernel.wake(asking)
            self._kernel.block()


class RobotHand:
    """Closes and opens the fingers; a `controller.ports.Hand`."""

    def __init__(self, kernel: Kernel, world: World, pressure: PressureSensor) -> None:
        self._kernel = kernel
        self._world = world
        self._pressure = pressure

    def close(self) -> bool:
        """Close the fingers; blocks until they are at rest; True when a leg is held then."""
        self._world.unfreeze()
        self._world.gripper.close()
        wait_until(self._kernel, self._world, self._world.gripper.at_rest, CLOSING_LIMIT_S)
        self._pressure.tare()
        return self.holds()

    def open(self) -> bool:
        """Open the fingers; blocks until they are at rest, at most 1 s; True when they are measured to be open."""
        self._world.unfreeze()
        self._world.gripper.open()
        wait_until(self._kernel, self._world, self._world.gripper.at_rest, OPENING_LIMIT_S)
        return self._world.gripper.seen_open()

    def holds(self) -> bool:
        """True while a leg is held."""
        return self._world.legs.in_hand is not None


class Robot:
    """All ports of the robot: `clock`, `arm`, `hand`; and its `pressure` sensor, which the sensors node reads."""

    def __init__(self, kernel: Kernel, world: World) -> None:
        self.pressure = world.pressure
        self.clock = RobotClock(kernel)
        self.arm = RobotArm(kernel, world, self.pressure)
        self.hand = RobotHand(kernel, world, self.pressure)


def wait_until(kernel: Kernel, world: World, condition: Callable[[], bool], limit_s: float) -> bool:
    """Block the calling node until `condition` holds at a control tick, at most `limit_s`; True when it held."""
    node = kernel.current()
    watch = world.watch(condition, lambda: kernel.wake(node))
    held = kernel.block(limit_s)
    world.unwatch(watch)
    return held
