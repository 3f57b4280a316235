"""The world of a run: time, the robot and its sensors, the person, the dog, and what requirements see of them."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

from carebot.messages import GripperCommand, GripperState, Pose, Scan, Velocity

from house.base import BODIES, FREE, Base, Contact, Mechanics, impact_n
from house.battery import Battery
from house.flat import BOXES, at_charger, clearance_m, in_reach
from house.gripper import Gripper
from house.laser import PERIOD_US, Disc, Laser, TurnedBox
from house.planar import Planar
from house.shapes import Gap, Point, moved
from house.walkers import DOG_RADIUS_M, DOG_SIZE_M, PERSON_RADIUS_M, Dog, Person
from pytest_hricdv.runtime import Kernel, Node, Recorder

STEP_US = 100_000
"""Between two looks at what moves: at 0.25 m/s the robot has come 25 mm (chosen). Motion itself is exact."""

US_PER_S = 1_000_000

SIGNALS: dict[str, type[bool] | type[float] | type[str]] = {
    "x": float,
    "y": float,
    "heading": float,
    "speed": float,
    "turning": float,
    "distance_to_person": float,
    "distance_to_dog": float,
    "distance_to_obstacle": float,
    "contact": str,
    "contact_force": float,
    "food_held": bool,
    "food_dropped": bool,
    "gripper_opening": float,
    "at": str,
    "at_charger": bool,
    "battery": float,
    "person_walking": bool,
    "person_seated": bool,
    "dog_moving": bool,
}
"""What the house records. `at` is what the gripper reaches; distances are between surfaces; the rest says itself."""

UNITS = {
    "x": "m",
    "y": "m",
    "heading": "rad",
    "speed": "m/s",
    "turning": "rad/s",
    "distance_to_person": "m",
    "distance_to_dog": "m",
    "distance_to_obstacle": "m",
    "contact_force": "N",
}

JUMPS_S = 0.2
"""In this time the published dog was somewhere else: for how fast it is when it lands in the robot."""

ROUNDING_M = 1e-6
"""A dog that stands at a wall may be as much nearer to it than its radius."""

PUSHED_M = 0.01
"""The robot is pushed in parts of this, until something is in its way (chosen)."""

VALUES = {
    "contact": ("nothing", "wall", "furniture", "person", "dog"),
    "at": ("nothing", "fridge", "sink", "table"),
}

DIGITS = 4
"""Of numbers that are recorded: 0.1 mm. The last bits of a sine differ between machines, and say nothing."""


class HouseError(Exception):
    """Something impossible was asked of the flat; the text says what and when."""


class House:
    """The flat with all that moves in it; `kernel.world`, and what the robot's code is handed as its ports.

    It is `carebot.ports.Base` (`pose`, `scan`, `drive`); `gripper_port` and `battery_port` are the other two.

    Args:
        kernel: its time; `kernel.world` is set by the caller.
        recorder: of the signals, which are `SIGNALS`.
        seed: of the laser's noise.
        mechanics: how the base moves; `house.planar.Planar` where none is given.
        battery: its level in the beginning, 0 to 1.
    """

    def __init__(
        self,
        kernel: Kernel,
        recorder: Recorder,
        seed: int,
        mechanics: Mechanics | None = None,
        battery: float = 1.0,
    ) -> None:
        self._kernel, self._recorder = kernel, recorder
        self.base, self.mechanics = Base(), mechanics or Planar()
        self.person, self.dog = Person(), Dog()
        self.gripper, self.battery = Gripper(), Battery(battery)
        self.gripper_port, self.battery_port = GripperPort(self), BatteryPort(self)
        self.contact = FREE
        self.skipped_us = 0
        """Of simulated time, how much was not stepped, as nothing moved."""
        self._laser = Laser(random.Random(f"{seed} laser").getrandbits(32))
        self._scan: Scan | None = None
        self._scanned_us = 0
        self._us = kernel.now_us
        self._recorded: dict[str, float | bool | str] = {}
        self._recorded_at: Point | None = None
        self._recorded_gaps: tuple[object, ...] = ()
        self._recorded_rest: tuple[object, ...] = ()
        self._watches: list[tuple[Callable[[], bool], Node]] = []
        self.observe()

    # --- the kernel's world

    def advance(self, target_us: int) -> int:
        """Make one step at most, or jump where nothing moves; returns the time reached (us)."""
        if self.still:
            reached_us = int(min(target_us, self.battery.changes_us(self._us)))
            self.skipped_us += reached_us - self._us
        else:
            reached_us = min(target_us, (self._us // STEP_US + 1) * STEP_US)
            self._step((reached_us - self._us) / US_PER_S)
        self._us = reached_us
        self.battery.plug(reached_us, charging=at_charger(self.base.at))
        return reached_us

    def observe(self) -> None:
        """Record what has changed, and let nodes go on that wait for it."""
        self._record()
        happened = [watch for watch in self._watches if watch[0]()] if self._watches else []
        for watch in happened:
            self._watches.remove(watch)
            self._kernel.wake(watch[1])

    @property
    def still(self) -> bool:
        """Whether nothing moves, so that time may jump."""
        quiet = self.base.resting and not self.gripper.moving and self.contact is FREE
        return quiet and not self.person.restless and not self.dog.restless

    # --- the robot's base

    def pose(self) -> Pose:
        """Where the robot is: its localization is exact."""
        return Pose(*self.base.at, self.base.heading_rad)

    def scan(self) -> Scan:
        """The last turn of the laser, which is at most `PERIOD_US` old."""
        if self._scan is None or self._us - self._scanned_us >= PERIOD_US:
            person = Disc(self.person.at, PERSON_RADIUS_M)
            dog = TurnedBox(self.dog.at, self.dog.heading_rad, DOG_SIZE_M)
            ranges = self._laser.ranges(self.base.at, self.base.heading_rad, (person,), (dog,))
            self._scan, self._scanned_us = Scan(tuple(ranges.tolist())), self._us
        return self._scan

    def drive(self, velocity: Velocity) -> None:
        """Go on with this velocity, until told otherwise.

        Raises:
            HouseError: it is no velocity.
        """
        if not (math.isfinite(velocity.forward) and math.isfinite(velocity.turn)):
            raise HouseError(f"{velocity!r} at {self._kernel.now_s:.3f} s: expected finite numbers, m/s and rad/s")
        self.base.told(velocity.forward, velocity.turn)

    # --- what people and dogs do

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Block the calling node until a condition on the world holds; whether it did within the time.

        >>> house.person.sit(1.0) and house.wait(lambda: not house.person.walking, 60.0)  # doctest: +SKIP
        """
        if condition():
            return True
        watch = (condition, self._kernel.current())
        self._watches.append(watch)
        woken = self._kernel.block(timeout_s)
        if not woken and watch in self._watches:
            self._watches.remove(watch)
        return woken or condition()

    def dog_jumps(self, dx_m: float, dy_m: float) -> bool:
        """The dog is somewhere else at once, as that of the published case, which was *set* each 0.2 s.

        Where it lands in the robot, that is pushed out of its way at once, as simulators do that resolve overlaps: no
        law of physics is meant. What of this walls do not allow, the dog is pushed back.

        Returns:
            False, without effect, where walls or furniture are in between, or do not leave it room.
        """
        to = self.dog.at[0] + dx_m, self.dog.at[1] + dy_m
        # Grown, as a segment could go through where two walls meet.
        if any(box.grown(DOG_RADIUS_M - ROUNDING_M).crosses(self.dog.at, to) for box in BOXES):
            return False
        self.dog.stay()
        self.dog.at, self.dog.heading_rad = to, math.atan2(dy_m, dx_m)
        gap = self.dog.gap_to(self.base.at, self.base.radius_m)
        if gap.width_m < 0.0:
            self._push_robot(gap)
            self.contact = Contact("dog", impact_n(math.hypot(dx_m, dy_m) / JUMPS_S, BODIES["dog"]))
        self._record()
        return True

    def battery_level(self) -> float:
        """How full the battery is, 0 to 1."""
        return self.battery.level(self._us)

    def battery_is(self, level: float) -> None:
        """The battery is this full now: emptier than one thought."""
        self.battery.is_at(level, self._us)
        self._record()  # at once: what the robot says of it comes at the same time

    def take_food(self) -> None:
        """The person takes what the gripper holds."""
        self.gripper.hand_over()

    # --- within

    def _push_robot(self, gap: Gap) -> None:
        base, start, free = self.base, self.base.at, 0.0
        parts = math.ceil(-gap.width_m / PUSHED_M)
        for part in range(1, parts + 1):
            at = moved(start, gap.away, part * -gap.width_m / parts)
            if _to_obstacle(at, base.radius_m) < 0.0 or self.person.gap_to(at, base.radius_m).width_m < 0.0:
                break
            base.at, free = at, part * -gap.width_m / parts
        self.dog.push(gap.away, gap.width_m + free)
        self.mechanics.moved(base)

    def _step(self, duration_s: float) -> None:
        self.person.step(duration_s, self.base)
        self.dog.step(duration_s, self.base)
        self.contact = self.mechanics.step(self.base, self.person, self.dog, duration_s)
        self.gripper.step(duration_s, self.base.at)

    def _record(self) -> None:
        base, at = self.base, self.base.at
        if at is not self._recorded_at:  # most often neither has moved
            self._recorded_at = at
            self._signal("x", round(at[0], DIGITS))
            self._signal("y", round(at[1], DIGITS))
            self._signal("distance_to_obstacle", _shown(_to_obstacle(at, base.radius_m)))
            self._signal("at", in_reach(at) or "nothing")
            self._signal("at_charger", at_charger(at))
        self._signal("heading", round(base.heading_rad, DIGITS))
        self._signal("speed", round(base.speed_m_s, DIGITS))
        self._signal("turning", round(base.turning_rad_s, DIGITS))
        self._record_gaps()
        self._record_rest()

    def _record_gaps(self) -> None:
        at, radius_m, person, dog = self.base.at, self.base.radius_m, self.person, self.dog
        places = (at, person.at, dog.at, dog.heading_rad)
        if places != self._recorded_gaps:
            self._recorded_gaps = places
            self._signal("distance_to_person", _shown(person.gap_to(at, radius_m).width_m))
            self._signal("distance_to_dog", _shown(dog.gap_to(at, radius_m).width_m))

    def _record_rest(self) -> None:
        """What seldom changes: looked at one by one only where something has."""
        gripper, person = self.gripper, self.person
        rest = (
            ("contact", self.contact.with_what),
            ("contact_force", round(self.contact.force_n, 1)),
            ("food_held", gripper.holds),
            ("food_dropped", gripper.dropped),
            ("gripper_opening", round(gripper.opening, DIGITS)),
            ("battery", self.battery.shown(self._us)),
            ("person_walking", person.walking),
            ("person_seated", person.seated),
            ("dog_moving", self.dog.velocity != (0.0, 0.0)),
        )
        if rest != self._recorded_rest:
            self._recorded_rest = rest
            for name, value in rest:
                self._signal(name, value)

    def _signal(self, name: str, value: float | bool | str) -> None:
        if self._recorded.get(name) != value:
            self._recorded[name] = value
            self._recorder.signal(self._us / US_PER_S, name, value)


def _shown(width_m: float) -> float:
    """A gap as it is recorded: none where both touch."""
    return round(max(0.0, width_m), DIGITS)


def _to_obstacle(at: Point, radius_m: float) -> float:
    return clearance_m(at) - radius_m


class GripperPort:
    """The gripper as the robot's code sees it: `carebot.ports.Gripper`."""

    def __init__(self, house: House) -> None:
        self._house = house

    def command(self, command: GripperCommand) -> None:
        """Begin to close or to open."""
        self._house.gripper.command(close=command.close, at=self._house.base.at)

    def state(self) -> GripperState:
        """How far it is open now."""
        return GripperState(self._house.gripper.opening)


class BatteryPort:
    """The battery as the robot's code sees it: `carebot.ports.Battery`."""

    def __init__(self, house: House) -> None:
        self._house = house

    def level(self) -> float:
        """How full it is now, 0 to 1."""
        return self._house.battery_level()
