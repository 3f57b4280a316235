"""A camera for films of the world: the whole scene, and a close view of the robot's hand.

The camera copies the visual shapes of the world into a separate engine and renders there, so that filming cannot change
a run. The copy has additional details of the person: face, sleeve, shoulders, and lines between the fingers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from sim.engine import STEP_S, UPRIGHT, Engine, Pose, Vector, bullet
from sim.gripper import GRASP_POINT_M
from sim.person import HAND_HALF_M, HEAD_RADIUS_M
from sim.world import World

SCENE_PX, HAND_PX, HEIGHT_PX, GAP_PX = 560, 392, 432, 8

FLOOR_M = 4.0
"""Wider shapes are the floor, which is painted as a backdrop: rendering time depends on covered pixels."""

POSE_DIGITS = 4
"""Poses that are equal to this number of digits (m) give the same picture."""

LIGHT: Vector = (0.5, -1.0, 2.2)
WALL, FAR_FLOOR, NEAR_FLOOR = (226, 231, 236), (142, 150, 160), (100, 108, 120)
WALL_M = 3.4
"""Apparent distance of the wall from the camera, along the floor."""

DARK_RGBA = (0.12, 0.12, 0.14, 1.0)
SKIN_LINE_RGBA = (0.62, 0.42, 0.32, 1.0)
NOSE_RGBA = (0.80, 0.55, 0.43, 1.0)
SLEEVE_RGBA = (0.16, 0.42, 0.30, 1.0)

SHOULDER_M: Vector = (0.10, 0.19, -0.30)
"""The person's right shoulder, from the head: the person sits opposite the robot."""

SLEEVE_M = 0.30
"""Visible length of the person's arm."""


@dataclass(frozen=True)
class View:
    """A camera view: position and target (m), vertical field of view (degrees), size of the picture (px)."""

    eye: Vector
    target: Vector
    degrees: float
    size: tuple[int, int]

    def picture(self, engine: Engine, *, fine: bool) -> Image.Image:
        """The rendered picture; with shadows when `fine`."""
        width, height = self.size
        _, _, pixels, _, bodies = bullet.getCameraImage(
            width,
            height,
            bullet.computeViewMatrix(self.eye, self.target, (0.0, 0.0, 1.0)),
            bullet.computeProjectionMatrixFOV(self.degrees, width / height, 0.05, 6.0),
            lightDirection=LIGHT,
            shadow=int(fine),
            renderer=bullet.ER_TINY_RENDERER,
            physicsClientId=engine.client,
        )
        rgb = np.reshape(np.asarray(pixels, dtype=np.uint8), (height, width, 4))[:, :, :3]
        nothing = np.reshape(np.asarray(bodies), (height, width, 1)) < 0
        return Image.fromarray(np.where(nothing, _backdrop(self._edge(), height), rgb))

    def _edge(self) -> int:
        """The row at which floor and wall meet."""
        down = math.asin((self.eye[2] - self.target[2]) / math.dist(self.eye, self.target))
        below = math.tan(math.atan2(self.eye[2], WALL_M) - down)
        return round(self.size[1] * (0.5 + 0.5 * below / math.tan(math.radians(self.degrees / 2))))


@cache
def _backdrop(edge: int, height: int) -> NDArray[np.uint8]:
    """The background as one column of pixels: a wall, and the floor below row `edge`."""
    rows = np.arange(height)[:, None, None]
    near = np.clip((rows - edge) / height, 0.0, 1.0)
    floor = (1.0 - near) * np.array(FAR_FLOOR) + near * np.array(NEAR_FLOOR)
    return np.where(rows < edge, np.array(WALL), floor).astype(np.uint8)


SCENE = View((1.15, -1.75, 1.55), (0.62, 0.06, 0.80), 42.0, (SCENE_PX, HEIGHT_PX))
HAND_EYE_M: Vector = (0.36, -0.52, 0.24)
HAND_TARGET_M: Vector = (0.07, 0.0, -0.03)
HAND_DEGREES = 42.0
"""The view of the robot's hand: eye from target, target from the middle of the grasp, towards the person's side."""


class Camera:
    """Renders pictures of a world; a `pytest_hricdv.testbench.Camera`."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._engine = Engine(STEP_S)
        self._copies: dict[ShapeKey, int] = {}
        self._poses: tuple[Pose, ...] = ()
        self._last: Image.Image | None = None
        self._details = PersonDetails(self._engine)

    def close(self) -> None:
        """Release the camera."""
        self._engine.close()

    def picture(self, *, fine: bool = False) -> Image.Image:
        """The present scene; the same object as last time if nothing has moved since. `fine` pictures have shadows."""
        shapes = visible(self._world)
        poses = tuple(_rounded(pose) for pose in shapes.values())
        if self._last is not None and poses == self._poses and not fine:
            return self._last
        self._follow(shapes)
        picture = self._composed(fine=fine)
        if not fine:
            self._last, self._poses = picture, poses
        return picture

    def _follow(self, shapes: dict[ShapeKey, Pose]) -> None:
        for gone in self._copies.keys() - shapes.keys():
            bullet.removeBody(self._copies.pop(gone), physicsClientId=self._engine.client)
        for shape, pose in shapes.items():
            if shape not in self._copies:
                self._copies[shape] = shape.visual.copy(self._engine)
            _put(self._engine, self._copies[shape], pose)
        self._details.follow(self._world.person.hand.pose(), self._world.person.head.pose())

    def _composed(self, *, fine: bool) -> Image.Image:
        palm = self._world.torso.palm_pose()
        grasp = bullet.multiplyTransforms(*palm, GRASP_POINT_M, UPRIGHT)[0]
        target = _sum(grasp, HAND_TARGET_M)
        near = View(_sum(target, HAND_EYE_M), target, HAND_DEGREES, (HAND_PX, HEIGHT_PX))
        whole = Image.new("RGB", (SCENE_PX + GAP_PX + HAND_PX, HEIGHT_PX))
        whole.paste(SCENE.picture(self._engine, fine=fine), (0, 0))
        whole.paste(near.picture(self._engine, fine=fine), (SCENE_PX + GAP_PX, 0))
        return whole


@dataclass(frozen=True)
class VisualShape:
    """One visual shape of a link and its pose on the link."""

    link: int
    kind: int
    size: tuple[float, ...]
    at: Pose
    rgba: tuple[float, ...]

    def copy(self, engine: Engine) -> int:
        """Add a body with the same visual shape."""
        if self.kind == bullet.GEOM_BOX:
            return _add_visual(engine, self.rgba, shapeType=self.kind, halfExtents=[extent / 2 for extent in self.size])
        if self.kind == bullet.GEOM_SPHERE:
            return _add_visual(engine, self.rgba, shapeType=self.kind, radius=self.size[0])
        return _add_visual(engine, self.rgba, shapeType=self.kind, length=self.size[0], radius=self.size[1])


@dataclass(frozen=True)
class ShapeKey:
    """Identifies a visual shape of a body."""

    body: int
    number: int
    visual: VisualShape


def visible(world: World) -> dict[ShapeKey, Pose]:
    """The visual shapes of a world and their poses. All are boxes, spheres or cylinders."""
    client = world.engine.client
    shapes: dict[ShapeKey, Pose] = {}
    for number in range(bullet.getNumBodies(physicsClientId=client)):
        body = bullet.getBodyUniqueId(number, physicsClientId=client)
        frames: dict[int, Pose] = {}
        for order, visual in enumerate(_shapes_of(world, body)):
            if max(visual.size) > FLOOR_M:
                continue
            if visual.link not in frames:
                frames[visual.link] = _frame(client, body, visual.link)
            shapes[ShapeKey(body, order, visual)] = bullet.multiplyTransforms(*frames[visual.link], *visual.at)
    return shapes


def _shapes_of(world: World, body: int) -> tuple[VisualShape, ...]:
    if body == world.torso.body:  # in the world it has no visual shapes
        return _shapes_of_description(world.torso.description)
    return _visual_shapes(world.engine, body)


@cache
def _shapes_of_description(description: str) -> tuple[VisualShape, ...]:
    with Engine(STEP_S) as engine:
        return _visual_shapes(engine, engine.load(description, may_sleep=False, merge_links=True)[0])


def _visual_shapes(engine: Engine, body: int) -> tuple[VisualShape, ...]:
    """The visual shapes of a body's links."""
    shapes = bullet.getVisualShapeData(body, physicsClientId=engine.client)
    return tuple(
        VisualShape(link, kind, tuple(size), (place, turn), tuple(rgba))
        for _, link, kind, size, _, place, turn, rgba, *_ in shapes
    )


def _frame(client: int, body: int, link: int) -> Pose:
    """The frame of a link; that of a base is computed from its centre of mass."""
    if link >= 0:
        state = bullet.getLinkState(body, link, physicsClientId=client)
        return state[4], state[5]
    mass = bullet.getBasePositionAndOrientation(body, physicsClientId=client)
    inertial = bullet.getDynamicsInfo(body, -1, physicsClientId=client)[3:5]
    frame: Pose = bullet.multiplyTransforms(*mass, *bullet.invertTransform(*inertial))
    return frame


class PersonDetails:
    """Visual details of the person."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        x, y, z = HAND_HALF_M
        slit = {"shapeType": bullet.GEOM_BOX, "halfExtents": (0.45 * x, 0.0012, z + 0.0008)}
        self._on_hand = {_add_visual(engine, SKIN_LINE_RGBA, **slit): (-0.56 * x, 0.5 * y * i, 0.0) for i in (-1, 0, 1)}
        r = HEAD_RADIUS_M
        eye = {"shapeType": bullet.GEOM_SPHERE, "radius": 0.16 * r}
        nose = {"shapeType": bullet.GEOM_SPHERE, "radius": 0.2 * r}
        self._on_head = {
            _add_visual(engine, DARK_RGBA, **eye): (0.9 * r, 0.35 * r, 0.2 * r),
            _add_visual(engine, DARK_RGBA, **eye): (0.9 * r, -0.35 * r, 0.2 * r),
            _add_visual(engine, NOSE_RGBA, **nose): (0.97 * r, 0.0, -0.1 * r),
        }
        self._sleeve = _add_visual(engine, SLEEVE_RGBA, shapeType=bullet.GEOM_CYLINDER, length=SLEEVE_M, radius=0.042)
        self._shoulders = _add_visual(engine, SLEEVE_RGBA, shapeType=bullet.GEOM_BOX, halfExtents=(0.10, 0.20, 0.17))

    def follow(self, hand: Pose, head: Pose) -> None:
        """Move all details to the person's pose."""
        for body, at in self._on_hand.items():
            _put(self._engine, body, bullet.multiplyTransforms(*hand, at, UPRIGHT))
        for body, at in self._on_head.items():
            _put(self._engine, body, bullet.multiplyTransforms(*head, at, UPRIGHT))
        wrist = _sum(hand[0], (HAND_HALF_M[0], 0.0, 0.0))
        reach = [b - a for a, b in zip(wrist, _sum(head[0], SHOULDER_M), strict=True)]
        length = sum(part * part for part in reach) ** 0.5
        ahead = [part / length for part in reach]
        middle = tuple(a + 0.5 * SLEEVE_M * b for a, b in zip(wrist, ahead, strict=True))
        _put(self._engine, self._sleeve, ((middle[0], middle[1], middle[2]), _along(ahead)))
        _put(self._engine, self._shoulders, (_sum(head[0], (SHOULDER_M[0], 0.0, SHOULDER_M[2])), UPRIGHT))


def _along(direction: Sequence[float]) -> tuple[float, float, float, float]:
    """The rotation of the z axis to a direction (a unit vector, not straight down)."""
    x, y, z = direction
    w = 1.0 + z
    length = (x * x + y * y + w * w) ** 0.5
    return (-y / length, x / length, 0.0, w / length)


def _add_visual(engine: Engine, rgba: Sequence[float], **shape: Any) -> int:
    visual = bullet.createVisualShape(rgbaColor=rgba, physicsClientId=engine.client, **shape)
    body: int = bullet.createMultiBody(0.0, -1, visual, physicsClientId=engine.client)
    return body


def _put(engine: Engine, body: int, pose: Pose) -> None:
    bullet.resetBasePositionAndOrientation(body, pose[0], pose[1], physicsClientId=engine.client)


def _rounded(pose: Pose) -> Pose:
    (x, y, z), (a, b, c, d) = (tuple(round(part, POSE_DIGITS) for part in each) for each in pose)
    return (x, y, z), (a, b, c, d)


def _sum(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
