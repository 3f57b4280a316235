"""The person's head and hand as bodies that move smoothly and that physics never pushes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from sim.engine import STEP_S, Engine, PhysicsTime, SimulationError, check_finite
from sim.gaze import orientation_to
from sim.geometry import UPRIGHT, Pose, Quaternion, Vector
from sim.layout import HANDOVER_M, PERSON, REST_HAND_M, SEAT_HEAD_M
from sim.shapes import Box, Sphere

HAND_SPEED_M_S = 0.9
HEAD_SPEED_M_S = 0.5
"""Top speeds of unhurried movements: below 1 m/s for a hand; a body bends more slowly."""

TURN_SPEED_RAD_S = 2.0
"""Top speed of a turning head."""

SHORTEST_MOVE_S = 0.3  # chosen: about a person's reaction time; without it a correction of a millimetre is a jerk
PEAK_OVER_MEAN = 1.875
"""Peak over mean speed of a minimum-jerk movement (Flash and Hogan 1985): the derivative of 10 s^3 - 15 s^4 + 6 s^5 at
s = 1/2."""

HEAD_RADIUS_M = 0.10
HAND_HALF_M: Vector = (0.09, 0.0425, 0.015)
"""Half the size of a hand: 18 cm long, 8.5 cm wide, 3 cm thick (a median adult's, rounded)."""

PULL_RAMP_S = 0.4
"""A pull rises to its full force within this time. Chosen: from 0.2 to 0.8 the records are the same (see
`sim.world.REST_TICKS`)."""

SKIN = (0.87, 0.67, 0.53, 1.0)


@dataclass(frozen=True)
class Movement:
    """A minimum-jerk movement between two poses, from one physics step to another."""

    start: Pose
    goal: Pose
    first_step: int
    last_step: int

    def pose(self, engine: Engine, step: int) -> Pose:
        """The pose at a step; at rest before the first and after the last step."""
        if step >= self.last_step:
            return self.goal
        s = max(0, step - self.first_step) / (self.last_step - self.first_step)
        share = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        (ax, ay, az), (bx, by, bz) = self.start[0], self.goal[0]
        place = (ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az))
        return place, engine.between(self.start[1], self.goal[1], share)

    def later(self) -> Movement:
        """The same movement, one step later."""
        return replace(self, first_step=self.first_step + 1, last_step=self.last_step + 1)


class BodyPart:
    """Head or hand: a body at rest or in a movement."""

    def __init__(self, engine: Engine, time: PhysicsTime, body: int, top_speed_m_s: float) -> None:
        self._engine = engine
        self._time = time
        self._movement: Movement | None = None
        self._top_speed_m_s = top_speed_m_s
        self.body = body
        engine.set_collision_group(body, PERSON, 0)

    @property
    def moving(self) -> bool:
        """True while a movement goes on."""
        return self._movement is not None

    def pose(self) -> Pose:
        """Position (m) and orientation."""
        return self._engine.pose(self.body)

    def move(self, place: Vector, turn: Quaternion = UPRIGHT) -> float:
        """Start to move to a pose at human speed; returns how long it takes (s): 0 when already there."""
        check_finite("pose that a person moves to", (*place, *turn))
        start = self.pose()
        distance_m = math.dist(start[0], place)
        angle_rad = 2.0 * math.acos(min(1.0, abs(sum(a * b for a, b in zip(start[1], turn, strict=True)))))
        # Nearer than a tracker could tell: a movement would take SHORTEST_MOVE_S and move nothing.
        if distance_m < 1e-4 and angle_rad < 1e-3:
            return 0.0
        duration_s = max(
            SHORTEST_MOVE_S,
            PEAK_OVER_MEAN * distance_m / self._top_speed_m_s,
            PEAK_OVER_MEAN * angle_rad / TURN_SPEED_RAD_S,
        )
        step = self._time.step
        self._movement = Movement(start, (place, turn), step, self._time.step_in(duration_s))
        return (self._movement.last_step - step + 1) * STEP_S

    def wait(self) -> None:
        """Keep still for one step: a movement goes on, and ends, a step later."""
        if self._movement is not None:
            self._movement = self._movement.later()

    def follow(self) -> None:
        """Move the body to its pose at the present step."""
        if self._movement is not None:
            self._engine.place(self.body, self._movement.pose(self._engine, self._time.step))
            if self._time.step >= self._movement.last_step:
                self._movement = None


class Pull:
    """A force (N) that rises to its full value with a ramp."""

    def __init__(self, time: PhysicsTime) -> None:
        self._time = time
        self._begin_step = 0
        self.full_n = 0.0

    @property
    def changing(self) -> bool:
        """True while it rises, and in the step in which it ends."""
        return (self._time.step - self._begin_step) * STEP_S < PULL_RAMP_S

    def set(self, force_n: float) -> None:
        """Begin to rise to `force_n` now; 0 ends the pull."""
        check_finite("pull", (force_n,))
        if force_n < 0.0:
            raise SimulationError(f"pull of {force_n} N: expected 0 or more")
        self.full_n, self._begin_step = force_n, self._time.step

    def now_n(self) -> float:
        """The force (N) of this step."""
        if self.full_n == 0.0:
            return 0.0
        return self.full_n * min(1.0, (self._time.step - self._begin_step) * STEP_S / PULL_RAMP_S)


class Person:
    """Head, hand, and the hand's forces on the leg and the robot's fingers.

    The pull acts on the leg, away from the robot, while the robot holds it, wherever the modelled hand is (the other
    hand may pull): so every combination of sensor readings can be enacted.
    """

    def __init__(self, engine: Engine, time: PhysicsTime) -> None:
        head = engine.add(0.0, SEAT_HEAD_M, SKIN, Sphere(HEAD_RADIUS_M))
        hand = engine.add(0.0, REST_HAND_M, SKIN, Box(HAND_HALF_M))
        engine.place(head, (SEAT_HEAD_M, orientation_to(SEAT_HEAD_M, HANDOVER_M)))
        self.head = BodyPart(engine, time, head, HEAD_SPEED_M_S)
        self.hand = BodyPart(engine, time, hand, HAND_SPEED_M_S)
        self._time = time
        self._pull = Pull(time)
        self._tug = Pull(time)
        self._grip_s = 0.0
        self._grip_until: int | None = None
        self._shut_until = 0

    def pull(self, force_n: float) -> None:
        """Pull at the leg with this force (N) from now on, with a ramp; 0 ends the pull."""
        self._pull.set(force_n)

    def tug(self, force_n: float) -> None:
        """Pull at the leg with this force (N) besides, with the other hand; 0 ends it."""
        self._tug.set(force_n)

    @property
    def pulls(self) -> bool:
        """True while the person pulls at the leg, also during the ramp."""
        return self._pull.full_n > 0.0 or self._tug.full_n > 0.0

    @property
    def pull_changing(self) -> bool:
        """True while a pull rises to its full force, and in the step in which one ends."""
        return self._pull.changing or self._tug.changing

    def pull_now(self) -> float:
        """The force (N) of this step."""
        return self._pull.now_n() + self._tug.now_n()

    def grip(self, duration_s: float) -> None:
        """Grip the robot's fingers together with the leg, until `duration_s` after the fingers began to push open.

        0 ends it. The person notices the fingers' push and needs this time to let go.
        """
        check_finite("grip", (duration_s,))
        if duration_s < 0.0:
            raise SimulationError(f"grip of {duration_s} s: expected 0 or more")
        self._grip_s, self._grip_until = duration_s, None

    def feels_push(self) -> bool:
        """Called at each step at which the fingers push open; True while the grip withstands it."""
        if self._grip_s == 0.0:
            return False
        if self._grip_until is None:
            self._grip_until = self._time.step_in(self._grip_s)
        if self._time.step >= self._grip_until:
            self._grip_s = 0.0
        return self._grip_s > 0.0

    def hold_shut(self, duration_s: float) -> None:
        """Hold the robot's fingers shut for so long from now, with the other hand, wherever the modelled one is."""
        check_finite("grip", (duration_s,))
        self._shut_until = self._time.step_in(duration_s)

    @property
    def holds_shut(self) -> bool:
        """True while the other hand holds the robot's fingers shut."""
        return self._time.step < self._shut_until

    def follow(self) -> None:
        """Move head and hand to their poses at the present step."""
        if self.head.moving:
            self.head.follow()
        if self.hand.moving:
            self.hand.follow()
