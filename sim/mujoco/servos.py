"""Position servos of MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim.drive import Joints, Move
from sim.engine import STEP_S, Engine, check_finite
from sim.mujoco.library import mujoco
from sim.mujoco.scene import Scene

LAG_S = 0.025
"""Servos follow a plan so much later, and reach its end exponentially: no joint is ever faster than planned. Telling
them the planned speed, too, would make them overshoot it."""

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
        self._lead = [max(HOLD_RAD, LEAD * LAG_S * speed) for speed in self._move.top_speeds_rad_s]

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
        move = self._move
        if move is not None:
            self._steps += steps
            share = move.distance_share(self._steps * STEP_S)
            self._goal = [start + share * (goal - start) for start, goal in zip(move.start, move.goal, strict=True)]
            if self._steps * STEP_S >= move.duration_s:
                self._move = None
        told = [
            min(max(goal, here - lead), here + lead)
            for goal, here, lead in zip(self._goal, self.angles(), self._lead, strict=True)
        ]
        _, data = self._scene.now()
        data.ctrl[[each.id for each in self._actuators]] = told
        self._settled = self._move is None and told == self._goal

    def _hold(self, pose: Sequence[float]) -> None:
        self._move, self._goal, self._settled = None, list(pose), False
        self._lead = [HOLD_RAD] * len(self._joints)

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
