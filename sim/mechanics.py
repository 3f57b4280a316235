"""The two fidelities of the world, behind one small interface: what joints and legs are, and what a step does.

`dynamic`: motors, masses, gravity, contacts. `kinematic`: joints are where the plan says, legs where the hand is that
holds them; nothing has mass. It runs the planner and the controller's logic, and finds what they do wrong; it says
nothing about forces, slips, grips that hold the fingers, or speeds other than the planned ones.

A second physics engine would come in here: as another `Mechanics` (and an engine of its own for poses and distances).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from sim.drive import Drive, MotorDrive
from sim.engine import Engine, SimulationError, Vector, bullet
from sim.kinematic import Kinematic
from sim.leg import Leg, RigidLeg


class Mechanics(Protocol):
    """Makes the parts of a world that move, and moves them; `stride`: the most steps that it takes at once."""

    stride: int

    def drive(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """What moves some joints of a body."""

    def leg(self, engine: Engine, place: Vector) -> Leg:
        """A leg that waits at a place (m)."""

    def step(self, engine: Engine, steps: int) -> None:
        """Let STEP_S pass, `steps` times."""


class Dynamic:
    """PyBullet's rigid bodies, motors and joints, step by step."""

    stride = 1

    def __init__(self) -> None:
        self._drives: list[Drive] = []

    def drive(self, engine: Engine, body: int, indices: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """See `Mechanics`."""
        drive = MotorDrive(engine, body, indices, torques_nm)
        self._drives.append(drive)
        return drive

    def leg(self, engine: Engine, place: Vector) -> Leg:
        """See `Mechanics`."""
        return RigidLeg(engine, place)

    def step(self, engine: Engine, steps: int) -> None:
        """See `Mechanics`."""
        for drive in self._drives:
            drive.advance(steps)
        bullet.stepSimulation(physicsClientId=engine.client)


FIDELITIES: Mapping[str, Callable[[], Mechanics]] = {"dynamic": Dynamic, "kinematic": Kinematic}


def mechanics_of(fidelity: str) -> Mechanics:
    """The mechanics of a fidelity. Raises SimulationError for an unknown one."""
    if fidelity not in FIDELITIES:
        raise SimulationError(f"fidelity {fidelity!r}: expected one of {', '.join(FIDELITIES)}")
    return FIDELITIES[fidelity]()
