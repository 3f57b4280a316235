"""Bodies in MuJoCo: a description that changes, and the compiled model and its state.

A compiled model is fixed. So bodies are added to and removed from its description (`MjSpec`), and it is compiled anew,
with the state of what stays, when it is next needed: 0.7 ms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from sim.engine import SimulationError
from sim.geometry import Pose, Vector
from sim.mujoco.body import Body, geom_of, link_of, turn, vector
from sim.mujoco.library import load, mujoco, warnings
from sim.shapes import Shape

MEMORY_BYTES = 1 << 21
"""For constraints and contacts of one step; the default of 15 MB takes its time at each compilation."""


ROWS = 6
"""Of constraint forces a weld: three forces, three torques."""

ANY_KG = 1.0
"""Of a body that physics never moves. MuJoCo misplaces the centre of one without mass."""


class Scene:
    """A model and its state.

    Args:
        step_s: the fixed time step (s).
    """

    def __init__(self, step_s: float) -> None:
        self.spec = mujoco.MjSpec()
        self.spec.memory = MEMORY_BYTES
        self.spec.compiler.fusestatic = True
        self.spec.option.timestep = step_s
        self.spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # of what went wrong without a word
        self.spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.bodies: dict[int, Body] = {}
        self._pushed = False
        self._changed = True
        self._moved = True
        self._moved_bodies: set[int] = set()  # beside that: no link of another body is elsewhere for it
        self._count = 0
        self._addresses: dict[tuple[int, Sequence[int]], tuple[Any, Any]] = {}
        self._fresh: set[int] = set()  # bodies that are not compiled yet
        self._compiled: tuple[Any, Any] | None = None
        self.when_compiled: list[Callable[[Any, Any], None]] = []
        """Are called with each new model and its state."""
        self.log: Any = np.empty((0, 0))
        """The velocity after each step of the last advance: degrees of freedom (m/s and rad/s) x steps."""

    def close(self) -> None:
        """Release model and state."""
        self._compiled = None
        self.bodies.clear()

    def change(self) -> Any:
        """The description, to be changed: the model is compiled before it is next used."""
        self._changed = True
        return self.spec

    def now(self) -> tuple[Any, Any]:
        """Model and state. What is computed of the state (places of links) may be that before the last step."""
        if self._changed or self._compiled is None:
            self._compile()
        assert self._compiled is not None
        return self._compiled

    def having(self, *bodies: int) -> tuple[Any, Any]:
        """Model and state, maybe those before the last changes, if they have these bodies already."""
        if self._compiled is None or not self._fresh.isdisjoint(bodies):
            return self.now()
        return self._compiled

    def placed(self, *bodies: int) -> tuple[Any, Any]:
        """The same, with the places of links and shapes."""
        model, data = self.having(*bodies)
        if self._moved or not self._moved_bodies.isdisjoint(bodies):
            mujoco.mj_kinematics(model, data)
            self._moved = False
            self._moved_bodies.clear()
        return model, data

    def moved(self) -> None:
        """To be called when joints have moved."""
        self._moved = True

    def _compile(self) -> None:
        try:
            if self._compiled is None:
                model = self.spec.compile()
                self._compiled = model, mujoco.MjData(model)
            else:
                self._compiled = self.spec.recompile(*self._compiled)
        except ValueError as error:
            raise SimulationError(f"MuJoCo refused the scene: {str(error).splitlines()[0]}") from error
        self._fresh.clear()
        self._changed, self._moved = False, True
        self._addresses.clear()
        for body in self.bodies.values():
            body.find(self._compiled[0])
        for follow in self.when_compiled:
            follow(*self._compiled)

    def advance(self, steps: int, before_step: Sequence[Callable[[], None]], limits_n: Sequence[float] = ()) -> int:
        """Advance by time steps; forces that were applied last during all of them, and are gone then.

        Args:
            steps: how many, if nothing comes between.
            before_step: is called before each step.
            limits_n: the force (N) of each active weld, in their order, after which no other step is made.

        Returns:
            how many were made.
        """
        # Not by MuJoCo's `rollout`: it takes all controls beforehand, while those of a joint that is held back depend
        # on its angle, and tells nothing of constraint forces.
        model, data = self.now()
        velocity, log = data.qvel, np.empty((model.nv, steps))
        made = 0
        while made < steps:
            for prepare in before_step:
                prepare()
            if not warnings:
                mujoco.mj_step(model, data)
            if warnings:
                break
            log[:, made] = velocity
            made += 1
            if limits_n and _overloaded(data, limits_n):
                break
        if made == 0:  # else those that went well are counted, and the next call says it, at its time
            first = warnings[0]
            warnings.clear()
            raise SimulationError(f"MuJoCo: {first}")
        self.log = log[:, :made]
        if self._pushed:
            data.xfrc_applied[:] = 0.0
            self._pushed = False
        self._moved = True
        return made

    def push(self, number: int, link: int, force_n: Vector, place: Vector) -> None:
        """Push for one step: force (N) on a link of a body at a place (m), in world axes."""
        self.now()  # or the force would be lost when the model is compiled
        _, data = self.placed(number)
        at = self.bodies[number].numbers.links[link]
        (x, y, z), (fx, fy, fz) = (place - data.xipos[at]).tolist(), force_n
        torque_nm = (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)  # numpy's takes longer than a step
        data.xfrc_applied[at] += (*force_n, *torque_nm)
        self._pushed = True

    # bodies

    def add(self, mass_kg: float, place: Vector, rgba: Sequence[float], shape: Shape) -> int:
        """Add a body of one shape. Returns its number."""
        base = self.change().worldbody.add_body(name=f"{self._count}", pos=place, mocap=mass_kg == 0.0)
        if mass_kg > 0.0:
            base.add_freejoint()
        kind, size = geom_of(shape)
        geom = base.add_geom(type=kind, size=size, mass=mass_kg or ANY_KG, rgba=rgba)
        return self._new(Body(base, mass_kg > 0.0, geoms={-1: (geom,)}, seen=(shape, tuple(rgba))))

    def load(self, description: str) -> int:
        """Add a robot whose base stays where it is placed, without gravity: its motors bear it. Returns its number."""
        robot = load(description)
        joints = list(robot.joints)
        if not joints:
            raise SimulationError(f"MuJoCo refused the robot description {description[:80]!r}...: it has no joints")
        links = [joint.parent for joint in joints]
        names: dict[int, list[str]] = {link: [] for link in range(-1, len(links))}
        for number, geom in enumerate(robot.geoms):
            geom.name = f"shape {number}"
            geom.contype = geom.conaffinity = 0
            names[link_of(geom.parent, links)].append(geom.name)
        for body in robot.bodies:
            body.gravcomp = 1.0
        for joint in joints:
            joint.actfrclimited = False  # motors have limits of their own
        base = self.change().worldbody.add_body(name=f"{self._count}", mocap=True)
        prefix = f"{self._count} "
        self.spec.attach(robot, prefix=prefix, frame=base.add_frame())
        geoms = {link: [self.spec.geom(prefix + name) for name in own_names] for link, own_names in names.items()}
        own = [self.spec.joint(prefix + joint.name.removeprefix(prefix)) for joint in joints]
        links = [joint.parent for joint in own]
        return self._new(Body(base, links=links, joints=own, geoms=geoms, description=description))

    def remove(self, number: int) -> None:
        """Remove a body."""
        self.change().delete(self.bodies.pop(number).base)

    def _new(self, body: Body) -> int:
        number, self._count = self._count, self._count + 1
        self.bodies[number] = body
        self._fresh.add(number)
        return number

    # where they are

    def pose(self, number: int) -> Pose:
        """Position (m) and orientation of a body's base."""
        body, (_, data) = self.bodies[number], self.having(number)
        if body.free:
            x, y, z, qw, qx, qy, qz = data.qpos[body.numbers.pose].tolist()
            return (x, y, z), (qx, qy, qz, qw)
        mocap = body.numbers.mocap
        return vector(data.mocap_pos[mocap]), turn(data.mocap_quat[mocap])

    def place(self, number: int, pose: Pose) -> None:
        """Set the pose of a body's base."""
        body, (place, (x, y, z, w)) = self.bodies[number], pose
        if number in self._fresh:
            body.base.pos, body.base.quat = place, (w, x, y, z)
            return
        _, data = self.having(number)
        if body.free:
            data.qpos[body.numbers.pose] = (*place, w, x, y, z)
        else:
            mocap = body.numbers.mocap
            data.mocap_pos[mocap], data.mocap_quat[mocap] = place, (w, x, y, z)
        self._moved_bodies.add(number)

    def velocity(self, number: int) -> Any:
        """The velocity of a body that physics moves (m/s in world axes, rad/s in its own), to be changed."""
        _, data = self.having(number)
        return data.qvel[self.bodies[number].numbers.velocity]

    def joints(self, number: int, joints: Sequence[int]) -> tuple[Any, Any]:
        """Where angles and speeds of joints are in the state."""
        model, _ = self.having(number)
        key = number, tuple(joints)
        if key not in self._addresses:
            own = [self.bodies[number].joints[joint].id for joint in joints]
            self._addresses[key] = indices(model.jnt_qposadr[own]), indices(model.jnt_dofadr[own])
        return self._addresses[key]

    def speed(self, number: int) -> float:
        """Speed (m/s) of a body's base."""
        return math.hypot(*self.velocity(number)[:3].tolist()) if self.bodies[number].free else 0.0


def _overloaded(data: Any, limits_n: Sequence[float]) -> bool:
    """Whether the force of any active weld is beyond its limit."""
    forces, first = data.efc_force, 0
    for limit_n in limits_n:
        if math.hypot(*forces[first : first + 3].tolist()) > limit_n:
            return True
        first += ROWS
    return False


def weld_force(data: Any, number: int) -> Vector:
    """The force (N) of an active weld in the last step, by its number among them: MuJoCo puts equalities first."""
    return vector(data.efc_force[ROWS * number : ROWS * number + 3])


def indices(numbers: Any) -> Any:
    """Numbers of elements as an index of numpy: a slice where it can be, which is faster."""
    first, count = int(numbers[0]), len(numbers)
    return slice(first, first + count) if numbers.tolist() == [*range(first, first + count)] else numbers
