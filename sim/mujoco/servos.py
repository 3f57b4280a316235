"""Position servos of MuJoCo."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
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
        self._command, self._most = np.empty(len(joints)), np.empty(len(joints))  # of `tell`, in each step
        scene.when_compiled.append(self._find)
        scene.now()
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
        return tuple(self._positions[self._at].tolist())

    def speed(self) -> float:
        """See `Drive`."""
        speeds = self._velocities[self._speeds_at].tolist()
        _check(speeds)
        return float(max(map(abs, speeds)))

    def speeds(self) -> Sequence[float]:
        """See `Drive`."""
        speeds = self._scene.log[self._speeds_at]
        fastest: list[float] = np.maximum.reduce(np.abs(speeds)).tolist()
        if not math.isfinite(sum(fastest)):
            for at_step in speeds.T.tolist():
                _check(at_step)
        return fastest

    def tell(self) -> None:
        """Before each step: tells the servos where to be after it."""
        if self.settled:
            return
        if self._left > 0:
            self._goal = next(self._plan)
            self._left -= 1
        here, command, most = self._positions[self._at], self._command, self._most
        np.subtract(here, self._lead, out=command)
        np.maximum(self._goal, command, out=command)
        np.add(here, self._lead, out=most)
        np.minimum(command, most, out=command)
        self._commands[self._actuators_at] = command
        if self._left == 0:
            self.settled = bool((command == self._goal).all())

    def _hold(self, pose: Sequence[float]) -> None:
        self._follow(iter([np.array(pose)]), 1, np.zeros(len(pose)))

    def _follow(self, plan: Iterator[Any], steps: int, lead_rad: Any) -> None:
        """From now on, go to the next pose of a plan with each of so many steps, and stay at the last."""
        self._plan, self._left, self.settled = plan, steps, False
        self._lead = np.maximum(HOLD_RAD, lead_rad)

    def _find(self, model: Any, data: Any) -> None:
        """Look up its joints and actuators in a model that was just compiled, and its state."""
        self._positions, self._velocities, self._commands = data.qpos, data.qvel, data.ctrl
        self._at, self._speeds_at = self._scene.joints(self._body, self._joints)
        self._actuators_at = indices(np.array([actuator.id for actuator in self._actuators]))

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


def _check(speeds: Sequence[float]) -> None:
    if not math.isfinite(sum(speeds)):
        raise SimulationError(f"joint speeds of the robot are {speeds!r}: expected finite numbers")
