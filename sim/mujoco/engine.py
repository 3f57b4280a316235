"""MuJoCo with checked arguments."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from sim import rotation
from sim.engine import Contact, Drive, Robot, SimulationError, check_finite
from sim.geometry import UPRIGHT, Pose, Quaternion, Vector
from sim.mujoco.body import turn, vector
from sim.mujoco.library import mujoco
from sim.mujoco.scene import Scene
from sim.mujoco.seen import shapes_of_description
from sim.mujoco.servos import Servos
from sim.mujoco.welds import Weld
from sim.shapes import Shape, Surface, Visual

FAR_M = 10.0
"""Search distance for closest points: larger than the whole scene, so that there is always a pair."""

CONDIM = 6
"""Contacts of a body with a surface resist sliding, spinning and rolling."""


class MujocoEngine:
    """One scene of MuJoCo; a `sim.engine.Engine`.

    Args:
        step_s: the fixed time step (s).
    """

    def __init__(self, step_s: float) -> None:
        self._scene = Scene(step_s)
        self._servos: list[Servos] = []
        self._welds: dict[int, Weld] = {}
        self._count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """See `Engine`."""
        self._scene.close()

    def advance(self, steps: int) -> int:
        """See `Engine`: up to the step in which a weld is overloaded, one by one while a body slides."""
        moving = [servos.tell for servos in self._servos if not servos.settled]
        if not self._welds:
            return self._scene.advance(steps, moving)
        holding = [weld for weld in self._welds.values() if weld.holds]
        if len(holding) < len(self._welds):
            steps = 1
            for weld in self._welds.values():
                weld.before_step()
        made = self._scene.advance(steps, moving, [weld.limit_n for weld in holding])
        for number, weld in enumerate(holding):
            weld.after_step(number)
        return made

    # bodies

    def load(self, description: str, *, may_sleep: bool = False) -> Robot:
        """See `Engine`; nothing needs to sleep here."""
        body = self._scene.load(description)
        joints = self._scene.bodies[body].joints
        names = [joint.name.partition(" ")[2].removesuffix("_joint") for joint in joints]
        limits = {name: tuple(joint.range.tolist()) for name, joint in zip(names, joints, strict=True)}
        return Robot(body, {name: index for index, name in enumerate(names)}, limits)

    def add(self, mass_kg: float, position: Vector, rgba: Sequence[float], shape: Shape) -> int:
        """See `Engine`."""
        check_finite("mass and position of a body", (mass_kg, *position))
        return self._scene.add(mass_kg, position, rgba, shape)

    def remove(self, body: int) -> None:
        """See `Engine`."""
        self.check(body)
        self._scene.remove(body)

    def check(self, body: int, link: int = -1) -> None:
        """See `Engine`."""
        bodies = self._scene.bodies
        if body not in bodies or not -1 <= link < len(bodies[body].links):
            links = {number: len(entry.links) for number, entry in bodies.items()}
            raise SimulationError(f"no link {link!r} of body {body!r}; bodies and their links: {links}")

    def set_collision_group(self, body: int, group: int, by: int) -> None:
        """See `Engine`."""
        self.check(body)
        self._scene.change()
        for geom in self._geoms(body):
            geom.contype, geom.conaffinity = group, by

    def set_surface(self, body: int, surface: Surface) -> None:
        """See `Engine`."""
        self.check(body)
        self._scene.change()
        for geom in self._geoms(body):
            geom.condim, geom.priority = CONDIM, 1  # this surface counts, whatever the other one is
            geom.friction = (surface.lateral, surface.spinning, surface.rolling)

    def sleep(self, body: int, asleep: bool) -> None:
        """See `Engine`: nothing needs to sleep here."""
        self.check(body)

    def _geoms(self, body: int) -> Iterator[Any]:
        for geoms in self._scene.bodies[body].geoms.values():
            yield from geoms

    # where they are

    def pose(self, body: int) -> Pose:
        """See `Engine`."""
        self.check(body)
        return self._scene.pose(body)

    def place(self, body: int, pose: Pose) -> None:
        """See `Engine`."""
        self.check(body)
        check_finite(f"pose of body {body}", (*pose[0], *pose[1]))
        self._scene.place(body, pose)

    def body_speed(self, body: int) -> float:
        """See `Engine`."""
        self.check(body)
        return self._scene.speed(body)

    def link_frame(self, body: int, link: int) -> Pose:
        """See `Engine`."""
        _, data = self._scene.placed(body)
        number = self._scene.bodies[body].numbers.links[link]
        return vector(data.xpos[number]), turn(data.xquat[number])

    def link_mass_frame(self, body: int, link: int) -> Pose:
        """See `Engine`; its axes are those of the link."""
        _, data = self._scene.placed(body)
        number = self._scene.bodies[body].numbers.links[link]
        return vector(data.xipos[number]), turn(data.xquat[number])

    def compose(self, base: Pose, pose: Pose) -> Pose:
        """See `Engine`."""
        return rotation.compose(base, pose)

    def relative(self, base: Pose, pose: Pose) -> Pose:
        """See `Engine`."""
        return rotation.relative(base, pose)

    def between(self, start: Quaternion, other: Quaternion, share: float) -> Quaternion:
        """See `Engine`."""
        return rotation.between(start, other, share)

    def visuals(self, described: Mapping[int, str]) -> dict[Visual, Pose]:
        """See `Engine`."""
        visuals: dict[Visual, Pose] = {}
        for number, body in self._scene.bodies.items():
            if body.seen is not None:
                visuals[Visual(number, 0, *body.seen)] = self._scene.pose(number)
                continue
            frames: dict[int, Pose] = {}
            text = described.get(number, body.description)
            for place, (link, shape, at, rgba) in enumerate(shapes_of_description(text)):
                if link not in frames:
                    frames[link] = self.link_frame(number, link)
                visuals[Visual(number, place, shape, rgba)] = rotation.compose(frames[link], at)
        return visuals

    # how near they are

    def distance(self, body: int, other: int, other_link: int) -> float:
        """See `Engine`."""
        self.check(body)
        self.check(other, other_link)
        return self._smallest(body, [-1], other, [other_link])

    def distance_to_all(self, body: int, other: int) -> float:
        """See `Engine`."""
        self.check(body)
        self.check(other)
        bodies = self._scene.bodies
        return self._smallest(body, bodies[body].geoms, other, bodies[other].geoms)

    def deepest(self, body: int, link: int, other: int) -> Contact:
        """See `Engine`."""
        self.check(body, link)
        self.check(other)
        model, data = self._scene.placed(body, other)
        ends, deepest = np.empty(6), Contact(-math.inf, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        for geom in self._scene.bodies[body].numbers.geoms[link]:
            for target in self._scene.bodies[other].numbers.geoms[-1]:
                depth_m = -mujoco.mj_geomDistance(model, data, geom, target, FAR_M, ends)
                if depth_m > deepest.depth_m:
                    away = (ends[3:] - ends[:3]) / (depth_m or 1.0)
                    deepest = Contact(depth_m, vector(ends[:3]), vector(away))
        return deepest

    def near(self, body: int, other: int, within_m: float, *links: int) -> list[tuple[int, float]]:
        """See `Engine`."""
        self.check(body)
        self.check(other)
        model, data = self._scene.placed(body, other)
        own, others = self._scene.bodies[body].numbers.geoms, self._scene.bodies[other].numbers.geoms
        if links:
            own, others = {links[0]: own[links[0]]}, {links[1]: others[links[1]]}
        targets = [geom for geoms in others.values() for geom in geoms]
        near = []
        for link, geoms in own.items():
            for geom in geoms:
                for target in targets:
                    distance_m = mujoco.mj_geomDistance(model, data, geom, target, within_m, None)
                    if distance_m < within_m:
                        near.append((link, distance_m))
        return near

    def _smallest(self, body: int, links: Iterable[int], other: int, other_links: Iterable[int]) -> float:
        model, data = self._scene.placed(body, other)
        own, others = self._scene.bodies[body].numbers.geoms, self._scene.bodies[other].numbers.geoms
        targets = [geom for link in other_links for geom in others[link]]
        smallest_m = FAR_M
        for link in links:
            for geom in own[link]:
                for target in targets:
                    smallest_m = mujoco.mj_geomDistance(model, data, geom, target, smallest_m, None)
        if not smallest_m < FAR_M:
            raise SimulationError(f"bodies {body} and {other} have no closest points")
        return float(smallest_m)

    # how they move

    def joint_angles(self, body: int, joints: Sequence[int]) -> tuple[float, ...]:
        """See `Engine`."""
        _, data = self._scene.having(body)
        return tuple(data.qpos[self._scene.joints(body, joints)[0]].tolist())

    def joint_speeds(self, body: int, joints: Sequence[int]) -> list[float]:
        """See `Engine`."""
        _, data = self._scene.having(body)
        speeds: list[float] = data.qvel[self._scene.joints(body, joints)[1]].tolist()
        if not math.isfinite(sum(speeds)):
            raise SimulationError(f"joint speeds of the robot are {speeds!r}: expected finite numbers")
        return speeds

    def set_joints(self, body: int, joints: Sequence[int], angles: Sequence[float]) -> None:
        """See `Engine`."""
        at, speeds_at = self._scene.joints(body, joints)
        _, data = self._scene.having(body)
        data.qpos[at], data.qvel[speeds_at] = angles, 0.0
        self._scene.moved()

    def drive(self, body: int, joints: Sequence[int], torques_nm: Sequence[float]) -> Drive:
        """See `Engine`."""
        servos = Servos(self, self._scene, body, joints, torques_nm)
        self._servos.append(servos)
        return servos

    def push(self, body: int, link: int, force_n: Vector, place: Vector) -> None:
        """See `Engine`."""
        self.check(body, link)
        check_finite(f"force on link {link} of body {body}", force_n)
        self._scene.push(body, link, force_n, place)

    def push_link(self, body: int, link: int, force_n: Vector, place: Vector) -> None:
        """See `Engine`."""
        at, axes = self.link_mass_frame(body, link)
        self.push(body, link, rotation.turned(axes, force_n), rotation.compose((at, axes), (place, UPRIGHT))[0])

    def weld(self, body: int, link: int, other: int, frame: Pose, force_n: float) -> int:
        """See `Engine`."""
        self.check(body, link)
        self.check(other)
        number, self._count = self._count, self._count + 1
        self._welds[number] = Weld(self._scene, (body, link), other, frame, force_n)
        return number

    def set_weld_force(self, weld: int, force_n: float) -> None:
        """See `Engine`."""
        self._welds[weld].limit_n = force_n

    def weld_force(self, weld: int) -> Vector:
        """See `Engine`."""
        force = self._welds[weld].force_n
        check_finite("force of a weld", force)
        return force

    def unweld(self, weld: int) -> None:
        """See `Engine`."""
        self._welds.pop(weld).remove()
