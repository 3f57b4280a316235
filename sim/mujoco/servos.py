"""Position servos of MuJoCo."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.drive import Joints, Move
from sim.engine import STEP_HZ, STEP_S, Engine, SimulationError, check_finite
from sim.mujoco.library import mujoco
from sim.mujoco.scene import Scene, indices

LAG_S = 0.025
"""Servos follow a plan so much later, and reach its end exponentially: no joint is faster than planned by more than
0.1 %. Telling them the planned speed, too, would make them overshoot it."""

STIFFNESS = 150.0
"""Of a servo (1/rad): it uses its maximum torque at an error of 1/150 rad."""

ROTOR_S2 = 0.005
"""Inertia of a motor with its gears, as its joint has it (kg m2 for each Nm of its torque). Without it, welds see an
arm that is much lighter than its servos make it, and shake."""

LEAD = 1.5
"""A joint that is held back is told to be ahead of where it is by so much of the lag at its top speed, and not where
the plan has gone meanwhile: when it is let go, it does not hurry."""

HOLD_RAD = 0.01
"""The same, of a joint that holds its position."""


@dataclass(frozen=True)
class Places:
    """Where joints and their servos are in a compiled model: indices of numpy."""

    model: Any
    angles: Any
    speeds: Any
    actuators: Any


class Servos(Joints):
    """A `sim.engine.Drive` of position servos with torque limits, which are told the plan at each step."""

    def __init__(self, engine: Engine, scene: Scene, body: int, joints: Sequence[int], torques_nm: Sequence[float]):
        super().__init__(engine, body, joints)
        self._scene = scene
        self._actuators = [
            self._actuator(scene.bodies[body].joints[joint].name, torque_nm)
            for joint, torque_nm in zip(joints, torques_nm, strict=True)
        ]
        self.settled = False
        """Whether the servos are told the goal, and nothing else is to come."""
        self._places: Places | None = None
        self._hold(self.angles())

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        move = Move(self.angles(), tuple(goal), duration_s, ramp_s)
        self._follow(planned(move), steps_of(move), LEAD * LAG_S * np.array(move.top_speeds_rad_s))

    def stop(self) -> None:
        """See `Drive`."""
        self._hold(self.angles())

    def reset(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        check_finite("pose", pose)
        self._set(pose)
        self._hold(pose)

    def angles(self) -> tuple[float, ...]:
        """See `Drive`."""
        places, data = self._now()
        return tuple(data.qpos[places.angles].tolist())

    def speed(self) -> float:
        """See `Drive`."""
        places, data = self._now()
        return self._fastest(data.qvel[places.speeds][np.newaxis])[0]

    def speeds(self) -> Sequence[float]:
        """See `Drive`."""
        places, _ = self._now()
        return self._fastest(self._scene.log[:, places.speeds])

    def tell(self) -> None:
        """Before each step: tells the servos where to be after it."""
        if self.settled:
            return
        places, data = self._now()
        if self._left > 0:
            self._goal = next(self._plan)
            self._left -= 1
        here = data.qpos[places.angles]
        command = np.minimum(np.maximum(self._goal, here - self._lead), here + self._lead)
        data.ctrl[places.actuators] = command
        if self._left == 0:
            self.settled = bool((command == self._goal).all())

    def _hold(self, pose: Sequence[float]) -> None:
        self._follow(iter([np.array(pose)]), 1, np.zeros(len(pose)))

    def _follow(self, plan: Iterator[Any], steps: int, lead_rad: Any) -> None:
        """From now on, go to the next pose of a plan with each of so many steps, and stay at the last."""
        self._plan, self._left, self.settled = plan, steps, False
        self._lead = np.maximum(HOLD_RAD, lead_rad)

    def _fastest(self, speeds: Any) -> list[float]:
        """Of the joints in each row (rad/s). Raises SimulationError when any is not finite."""
        fastest: list[float] = np.abs(speeds).max(axis=1).tolist()
        if not math.isfinite(sum(fastest)):
            wrong = next(row for row, speed in zip(speeds.tolist(), fastest, strict=True) if not math.isfinite(speed))
            raise SimulationError(f"joint speeds of the robot are {wrong!r}: expected finite numbers")
        return fastest

    def _now(self) -> tuple[Places, Any]:
        """Where its joints are in the present model, and the state."""
        model, data = self._scene.having(self._body)
        if self._places is None or self._places.model is not model:
            angles, speeds = self._scene.joints(self._body, self._joints)
            actuators = indices(np.array([actuator.id for actuator in self._actuators]))
            self._places = Places(model, angles, speeds, actuators)
        return self._places, data

    def _actuator(self, joint: str, torque_nm: float) -> Any:
        gain = STIFFNESS * torque_nm
        spec = self._scene.change()
        spec.joint(joint).armature = ROTOR_S2 * torque_nm
        actuator = spec.add_actuator(name=f"servo of {joint}", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
        actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        actuator.gainprm[0] = gain
        actuator.biasprm[1], actuator.biasprm[2] = -gain, -gain * LAG_S
        actuator.forcelimited, actuator.forcerange = True, (-torque_nm, torque_nm)
        return actuator


def planned(move: Move) -> Iterator[Any]:
    """Where joints are to be (rad) after each step of a move, computed for a second at a time."""
    start = np.array(move.start)
    way = np.array(move.goal) - start
    for first in itertools.count(1, STEP_HZ):
        shares = [move.distance_share(step * STEP_S) for step in range(first, first + STEP_HZ)]
        yield from start + np.array(shares)[:, np.newaxis] * way


def steps_of(move: Move) -> int:
    """After so many steps a move is over."""
    steps = int(move.duration_s / STEP_S)
    return steps if steps * STEP_S >= move.duration_s else steps + 1
