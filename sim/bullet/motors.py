"""Position motors of PyBullet."""

from __future__ import annotations

from collections.abc import Sequence

from sim.bullet.client import bullet
from sim.drive import Joints, Move
from sim.engine import STEP_S, Engine, check_finite

POSITION_GAIN = 0.3
VELOCITY_GAIN = 1.0
"""Gains with which joints have the planned speed, with one command per joint and move: 0.24000 rad/s for a plan of 0.24
(tests/sim/test_robot.py)."""

HOLD_SPEED_RAD_S = 0.02
"""Top speed of a joint that holds its position: corrections are slow, and below a tenth of the limit of R4."""


class Motors(Joints):
    """A `sim.engine.Drive` of position motors with torque limits: each motor is sent to the goal once.

    Streaming positions instead would make the arm faster than planned (0.385 rad/s for a plan of 0.24). Along a ramp
    only the motor's speed limit changes, so that no joint is ever faster than planned.
    """

    def __init__(
        self, engine: Engine, client: int, body: int, joints: Sequence[int], torques_nm: Sequence[float]
    ) -> None:
        super().__init__(engine, body, joints)
        self._client = client
        self._torques_nm = tuple(torques_nm)
        self._move: Move | None = None  # an unfinished move with ramps
        self._steps = 0
        self._share = 0.0
        self._cruise_end_s = 0.0  # end of the time at top speed

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        move = Move(self.angles(), tuple(goal), duration_s, ramp_s)
        if ramp_s > 0.0:
            self._move, self._steps, self._share = move, 0, 0.0
            self._cruise_end_s = duration_s - ramp_s - STEP_S
        else:
            self._move = None
            self._command(goal, [max(speed, HOLD_SPEED_RAD_S) for speed in move.top_speeds_rad_s])

    def stop(self) -> None:
        """See `Drive`."""
        self._move = None
        self._command(self.angles(), [HOLD_SPEED_RAD_S] * len(self._joints))

    def reset(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        check_finite("pose", pose)
        self._move = None
        self._set(pose)
        self._command(pose, [HOLD_SPEED_RAD_S] * len(self._joints))

    def advance(self) -> None:
        """Before each step: sets the speed limits for it if they change."""
        move = self._move
        if move is None:
            return
        # In the middle of the step: its mean speed is that of the plan, while the speed at its begin would lag behind.
        time_s = (self._steps + 0.5) * STEP_S
        self._steps += 1
        if self._share == 1.0 and time_s < self._cruise_end_s:  # most steps: nothing changes
            return
        over = time_s >= move.duration_s
        share = move.speed_share(time_s)
        if share != self._share:
            # When slowing down, position control may correct the rest at the holding speed.
            least = 0.0 if share > self._share else HOLD_SPEED_RAD_S
            self._share = share
            self._command(move.goal, [max(share * speed, least) for speed in move.top_speeds_rad_s])
        if over:
            self._move = None

    def _command(self, goal: Sequence[float], top_speeds_rad_s: Sequence[float]) -> None:
        joints = zip(self._joints, goal, self._torques_nm, top_speeds_rad_s, strict=True)
        for joint, angle, torque_nm, top_speed_rad_s in joints:
            bullet.setJointMotorControl2(
                self._body,
                joint,
                bullet.POSITION_CONTROL,
                angle,
                force=torque_nm,
                positionGain=POSITION_GAIN,
                velocityGain=VELOCITY_GAIN,
                maxVelocity=top_speed_rad_s,
                physicsClientId=self._client,
            )
