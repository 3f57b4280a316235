"""PyBullet with checked arguments."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from sim.bullet.client import bullet, connect, load
from sim.bullet.merging import merge_fixed_joints
from sim.bullet.motors import Motors
from sim.bullet.seen import shapes_of, shapes_of_description
from sim.engine import Contact, Drive, Robot, SimulationError, check_finite
from sim.geometry import UPRIGHT, Pose, Quaternion, Vector
from sim.shapes import Box, Cylinder, Shape, Sphere, Surface, Visual
from sim.silence import silenced

FAR_M = 10.0
"""Search distance for closest points: larger than the whole scene, so that there is always a pair."""

NOWHERE: Vector = (0.0, 0.0, 0.0)

_ASLEEP = bullet.ACTIVATION_STATE_ENABLE_SLEEPING | bullet.ACTIVATION_STATE_SLEEP
_AWAKE = bullet.ACTIVATION_STATE_DISABLE_SLEEPING | bullet.ACTIVATION_STATE_WAKE_UP


class BulletEngine:
    """One PyBullet client without a window, with a solver that keeps planned speeds; a `sim.engine.Engine`.

    Dantzig's direct LCP solver instead of the default iterative one: the latter read 0.2625 rad/s for a 0.24 rad/s
    motor (tests/sim/test_robot.py measures the speeds), and is slower here.

    Args:
        step_s: the fixed time step (s).
    """

    def __init__(self, step_s: float) -> None:
        self._link_counts: dict[int, int] = {}
        self._drives: list[Motors] = []
        self.client = connect()
        with silenced():
            bullet.setPhysicsEngineParameter(
                fixedTimeStep=step_s,
                numSubSteps=0,  # with sub steps PyBullet 3.2.7 reads joint torques too small by their number
                constraintSolverType=bullet.CONSTRAINT_SOLVER_LCP_DANTZIG,
                physicsClientId=self.client,
            )
        bullet.setGravity(0.0, 0.0, -9.81, physicsClientId=self.client)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Disconnect the client; may be called more than once."""
        if self.client >= 0:
            bullet.disconnect(self.client)
            self.client = -1

    def advance(self, steps: int) -> int:
        """See `Engine`: one step at a time, as PyBullet tells nothing of the steps between."""
        for motors in self._drives:
            motors.advance()
        bullet.stepSimulation(physicsClientId=self.client)
        return 1

    # bodies

    def load(self, description: str, *, may_sleep: bool = False) -> Robot:
        """See `Engine`; a robot that may sleep also falls asleep by itself unless it is kept awake."""
        text = merge_fixed_joints(description)
        body = load(self.client, text, bullet.URDF_ENABLE_SLEEPING if may_sleep else 0)
        count = bullet.getNumJoints(body, physicsClientId=self.client)
        self._link_counts[body] = count
        # PyBullet damps all links by 0.04 unless told otherwise: no joint would have its planned speed.
        for link in range(-1, count):
            bullet.changeDynamics(body, link, linearDamping=0.0, angularDamping=0.0, physicsClientId=self.client)
        infos = [bullet.getJointInfo(body, index, physicsClientId=self.client) for index in range(count)]
        names = [info[1].decode().removesuffix("_joint") for info in infos]
        limits = {name: (info[8], info[9]) for name, info in zip(names, infos, strict=True)}
        return Robot(body, {name: index for index, name in enumerate(names)}, limits)

    def add(self, mass_kg: float, position: Vector, rgba: Sequence[float], shape: Shape) -> int:
        """See `Engine`."""
        check_finite("mass and position of a body", (mass_kg, *position))
        size = _shape(shape)
        # What is seen and what is touched have different names for one thing in PyBullet.
        seen = {"length" if name == "height" else name: value for name, value in size.items()}
        collision = bullet.createCollisionShape(physicsClientId=self.client, **size)
        visual = bullet.createVisualShape(rgbaColor=rgba, physicsClientId=self.client, **seen)
        body: int = bullet.createMultiBody(mass_kg, collision, visual, position, physicsClientId=self.client)
        if body < 0:
            raise SimulationError(f"PyBullet refused a body of shape {shape!r}")
        self._link_counts[body] = 0
        return body

    def remove(self, body: int) -> None:
        """See `Engine`."""
        self.check(body)
        bullet.removeBody(body, physicsClientId=self.client)
        del self._link_counts[body]

    def check(self, body: int, link: int = -1) -> None:
        """See `Engine`."""
        if body not in self._link_counts or not -1 <= link < self._link_counts[body]:
            raise SimulationError(f"no link {link!r} of body {body!r}; bodies and their links: {self._link_counts}")

    def set_collision_group(self, body: int, group: int, by: int) -> None:
        """See `Engine`."""
        self.check(body)
        for link in range(-1, self._link_counts[body]):
            bullet.setCollisionFilterGroupMask(body, link, group, by, physicsClientId=self.client)

    def set_surface(self, body: int, surface: Surface) -> None:
        """See `Engine`."""
        self.check(body)
        bullet.changeDynamics(
            body,
            -1,
            linearDamping=0.0,
            angularDamping=surface.angular_drag,
            lateralFriction=surface.lateral,
            rollingFriction=surface.rolling,
            spinningFriction=surface.spinning,
            physicsClientId=self.client,
        )

    def sleep(self, body: int, asleep: bool) -> None:
        """See `Engine`."""
        self.check(body)
        state = _ASLEEP if asleep else _AWAKE
        bullet.changeDynamics(body, -1, activationState=state, physicsClientId=self.client)

    # where they are

    def pose(self, body: int) -> Pose:
        """See `Engine`."""
        self.check(body)
        pose: Pose = bullet.getBasePositionAndOrientation(body, physicsClientId=self.client)
        return pose

    def place(self, body: int, pose: Pose) -> None:
        """See `Engine`."""
        self.check(body)
        check_finite(f"pose of body {body}", (*pose[0], *pose[1]))
        bullet.resetBasePositionAndOrientation(body, pose[0], pose[1], physicsClientId=self.client)

    def body_speed(self, body: int) -> float:
        """See `Engine`."""
        self.check(body)
        velocity = bullet.getBaseVelocity(body, physicsClientId=self.client)[0]
        return float(sum(part * part for part in velocity) ** 0.5)

    def link_frame(self, body: int, link: int) -> Pose:
        """See `Engine`."""
        state = bullet.getLinkState(body, link, physicsClientId=self.client)
        return state[4], state[5]

    def link_mass_frame(self, body: int, link: int) -> Pose:
        """See `Engine`."""
        state = bullet.getLinkState(body, link, physicsClientId=self.client)
        return state[0], state[1]

    def compose(self, base: Pose, pose: Pose) -> Pose:
        """See `Engine`; in single precision."""
        composed: Pose = bullet.multiplyTransforms(*base, *pose)
        return composed

    def relative(self, base: Pose, pose: Pose) -> Pose:
        """See `Engine`; in single precision."""
        composed: Pose = bullet.multiplyTransforms(*bullet.invertTransform(*base), *pose)
        return composed

    def between(self, start: Quaternion, other: Quaternion, share: float) -> Quaternion:
        """See `Engine`; in single precision."""
        turned: Quaternion = bullet.getQuaternionSlerp(start, other, share)
        return turned

    def visuals(self, described: Mapping[int, str]) -> dict[Visual, Pose]:
        """See `Engine`."""
        visuals: dict[Visual, Pose] = {}
        for body in self._link_counts:
            shapes = shapes_of_description(described[body]) if body in described else shapes_of(self.client, body)
            frames: dict[int, Pose] = {}
            for number, (link, shape, at, rgba) in enumerate(shapes):
                if link not in frames:
                    frames[link] = self.link_frame(body, link) if link >= 0 else self._base_frame(body)
                visuals[Visual(body, number, shape, rgba)] = self.compose(frames[link], at)
        return visuals

    def _base_frame(self, body: int) -> Pose:
        """The frame of a base, computed from its centre of mass."""
        inertial = bullet.getDynamicsInfo(body, -1, physicsClientId=self.client)[3:5]
        return self.compose(self.pose(body), bullet.invertTransform(*inertial))

    # how near they are

    def distance(self, body: int, other: int, other_link: int) -> float:
        """See `Engine`."""
        self.check(body)
        self.check(other, other_link)
        points = bullet.getClosestPoints(body, other, FAR_M, -1, other_link, physicsClientId=self.client)
        return _nearest(points, body, other)

    def distance_to_all(self, body: int, other: int) -> float:
        """See `Engine`."""
        self.check(body)
        self.check(other)
        return _nearest(bullet.getClosestPoints(body, other, FAR_M, physicsClientId=self.client), body, other)

    def deepest(self, body: int, link: int, other: int) -> Contact:
        """See `Engine`."""
        points = bullet.getClosestPoints(body, other, FAR_M, link, -1, physicsClientId=self.client)
        point = min(points, key=lambda contact: float(contact[8]))
        return Contact(-float(point[8]), point[5], point[7])

    def near(self, body: int, other: int, within_m: float, *links: int) -> list[tuple[int, float]]:
        """See `Engine`."""
        points = bullet.getClosestPoints(body, other, within_m, *links, physicsClientId=self.client)
        return [(point[3], point[8]) for point in points]

    # how they move

    def joint_angles(self, body: int, joints: Sequence[int]) -> tuple[float, ...]:
        """See `Engine`."""
        states = bullet.getJointStates(body, joints, physicsClientId=self.client)
        return tuple([state[0] for state in states])

    def joint_speeds(self, body: int, joints: Sequence[int]) -> list[float]:
        """See `Engine`."""
        states = bullet.getJointStates(body, joints, physicsClientId=self.client)
        speeds = [state[1] for state in states]
        if not math.isfinite(sum(speeds)):
            raise SimulationError(f"joint speeds of the robot are {speeds!r}: expected finite numbers")
        return speeds

    def set_joints(self, body: int, joints: Sequence[int], angles: Sequence[float]) -> None:
        """See `Engine`."""
        for joint, angle in zip(joints, angles, strict=True):
            bullet.resetJointState(body, joint, angle, 0.0, physicsClientId=self.client)

    def drive(self, body: int, joints: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """See `Engine`."""
        motors = Motors(self, self.client, body, joints, torques_nm)
        self._drives.append(motors)
        return motors

    def push(self, body: int, link: int, force_n: Vector, place: Vector) -> None:
        """See `Engine`."""
        self._push(body, link, force_n, place, bullet.WORLD_FRAME)

    def push_link(self, body: int, link: int, force_n: Vector, place: Vector) -> None:
        """See `Engine`."""
        self._push(body, link, force_n, place, bullet.LINK_FRAME)

    def _push(self, body: int, link: int, force_n: Vector, place: Vector, frame: int) -> None:
        self.check(body, link)
        check_finite(f"force on link {link} of body {body}", force_n)
        bullet.applyExternalForce(body, link, force_n, place, frame, physicsClientId=self.client)

    def weld(self, body: int, link: int, other: int, frame: Pose, force_n: float) -> int:
        """See `Engine`."""
        self.check(body, link)
        self.check(other)
        place, turn = frame
        weld: int = bullet.createConstraint(
            body,
            link,
            other,
            -1,
            bullet.JOINT_FIXED,
            NOWHERE,
            place,
            NOWHERE,
            turn,
            UPRIGHT,
            physicsClientId=self.client,
        )
        if weld < 0:
            raise SimulationError(f"PyBullet refused to weld body {other} to body {body}, link {link}")
        self.set_weld_force(weld, force_n)
        return weld

    def set_weld_force(self, weld: int, force_n: float) -> None:
        """See `Engine`."""
        bullet.changeConstraint(weld, maxForce=force_n, physicsClientId=self.client)

    def weld_force(self, weld: int) -> Vector:
        """See `Engine`."""
        force = bullet.getConstraintState(weld, physicsClientId=self.client)
        check_finite("force of a weld", force)
        return (force[0], force[1], force[2])

    def unweld(self, weld: int) -> None:
        """See `Engine`."""
        bullet.removeConstraint(weld, physicsClientId=self.client)


def _shape(shape: Shape) -> dict[str, Any]:
    """The keyword arguments of createCollisionShape."""
    match shape:
        case Box(half_m):
            return {"shapeType": bullet.GEOM_BOX, "halfExtents": half_m}
        case Sphere(radius_m):
            return {"shapeType": bullet.GEOM_SPHERE, "radius": radius_m}
        case Cylinder(radius_m, length_m):
            return {"shapeType": bullet.GEOM_CYLINDER, "radius": radius_m, "height": length_m}


def _nearest(points: Sequence[tuple[Any, ...]], body: int, other: int) -> float:
    if not points:
        raise SimulationError(f"bodies {body} and {other} have no closest points")
    return float(min([point[8] for point in points]))
