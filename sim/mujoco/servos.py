"""Position servos of MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.drive import Joints, Move
from sim.engine import STEP_S, Engine, check_finite
from sim.mujoco.library import mujoco
from sim.mujoco.scene import Scene

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


class Servos(Joints):
    """A `sim.engine.Drive` of position servos with torque limits, which are told the plan at each step."""

    def __init__(self, engine: Engine, scene: Scene, body: int, joints: Sequence[int], torques_nm: Sequence[float]):
        super().__init__(engine, body, joints)
        self._scene = scene
        self._actuators = [
            self._actuator(scene.bodies[body].joints[joint].name, torque_nm)
            for joint, torque_nm in zip(joints, torques_nm, strict=True)
        ]
        self._move: Move | None = None
        self._steps = 0
        self._settled = False  # the servos are told the goal, and nothing else is to come
        self._hold(self.angles())

    def move(self, goal: Sequence[float], duration_s: float, ramp_s: float = 0.0) -> None:
        """See `Drive`."""
        self._move, self._steps, self._settled = Move(self.angles(), tuple(goal), duration_s, ramp_s), 0, False
        self._start = np.array(self._move.start)
        self._way = np.array(self._move.goal) - self._start
        self._lead = np.maximum(HOLD_RAD, LEAD * LAG_S * np.array(self._move.top_speeds_rad_s))

    def stop(self) -> None:
        """See `Drive`."""
        self._hold(self.angles())

    def reset(self, pose: Sequence[float]) -> None:
        """See `Drive`."""
        check_finite("pose", pose)
        self._set(pose)
        self._hold(pose)

    def advance(self, steps: int) -> None:
        """See `Drive`: tells the servos where to be after the next step."""
        if self._settled:
            return
        _, data = self._scene.now()
        move = self._move
        if move is not None:
            self._steps += steps
            self._goal = self._start + move.distance_share(self._steps * STEP_S) * self._way
            if self._steps * STEP_S >= move.duration_s:
                self._move = None
        here = data.qpos[self._scene.joints(self._body, self._joints)[0]]
        command = np.minimum(np.maximum(self._goal, here - self._lead), here + self._lead)
        data.ctrl[[actuator.id for actuator in self._actuators]] = command
        self._settled = self._move is None and bool((command == self._goal).all())

    def _hold(self, pose: Sequence[float]) -> None:
        self._move, self._goal, self._settled = None, np.array(pose), False
        self._lead = np.full(len(self._joints), HOLD_RAD)

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
