"""A camera for films of the world: the whole scene, and beside it the robot's hand from near.

Pictures are taken in a world of the camera's own, into which the visible shapes of the filmed one are copied: nothing
that is done for a picture can disturb a run. The copy has more than the original, for the eye only: the person's face,
sleeve and shoulders, and lines between the fingers.
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

from sim.engine import UPRIGHT, Engine, Pose, Vector, bullet
from sim.gripper import GRASP_POINT_M
from sim.person import HAND_HALF_M, HEAD_RADIUS_M
from sim.physics_time import STEP_S
from sim.world import World

SCENE_PX, HAND_PX, HEIGHT_PX, GAP_PX = 560, 392, 432, 8

FLOOR_M = 4.0
"""What is wider than this is the floor. It is painted as a backdrop: the renderer's time goes with covered pixels."""

SAME_DIGITS = 4
"""Bodies whose poses are equal to so many digits (m) look the same."""

LIGHT: Vector = (0.5, -1.0, 2.2)
WALL, FAR_FLOOR, NEAR_FLOOR = (226, 231, 236), (142, 150, 160), (100, 108, 120)
WALL_M = 3.4
"""How far behind everything the wall seems to be: floor distance from the eye."""

DARK_RGBA = (0.12, 0.12, 0.14, 1.0)
SKIN_LINE_RGBA = (0.62, 0.42, 0.32, 1.0)
NOSE_RGBA = (0.80, 0.55, 0.43, 1.0)
SLEEVE_RGBA = (0.16, 0.42, 0.30, 1.0)

SHOULDER_M: Vector = (0.10, 0.19, -0.30)
"""The person's right shoulder, from the head: the person sits opposite the robot."""

SLEEVE_M = 0.30
"""Length of what is seen of the person's arm."""


@dataclass(frozen=True)
class Lens:
    """A view: where the camera is and where it looks (m), how wide (degrees, from top to bottom), and its size (px)."""

    eye: Vector
    target: Vector
    degrees: float
    size: tuple[int, int]

    def picture(self, engine: Engine, *, fine: bool) -> Image.Image:
        """What is seen; with shadows when `fine`."""
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
    """What is behind everything, a column of pixels: a wall, and below a row the floor."""
    rows = np.arange(height)[:, None, None]
    near = np.clip((rows - edge) / height, 0.0, 1.0)
    floor = (1.0 - near) * np.array(FAR_FLOOR) + near * np.array(NEAR_FLOOR)
    return np.where(rows < edge, np.array(WALL), floor).astype(np.uint8)


SCENE = Lens((1.15, -1.75, 1.55), (0.62, 0.06, 0.80), 42.0, (SCENE_PX, HEIGHT_PX))
HAND_EYE_M: Vector = (0.36, -0.52, 0.24)
HAND_TARGET_M: Vector = (0.07, 0.0, -0.03)
HAND_DEGREES = 42.0
"""The view of the robot's hand: eye from target, target from the middle of the grasp, towards the person's side."""


class Camera:
    """Takes pictures of a world; a `pytest_hricdv.testbench.Camera`."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._engine = Engine(STEP_S)
        self._copies: dict[Shape, int] = {}
        self._poses: tuple[Pose, ...] = ()
        self._last: Image.Image | None = None
        self._extras = Extras(self._engine)

    def close(self) -> None:
        """Take the camera away."""
        self._engine.close()

    def picture(self, *, fine: bool = False) -> Image.Image:
        """The scene now; the very object of the last call when nothing has moved since. `fine` ones have shadows."""
        shapes = visible(self._world)
        poses = tuple(_rounded(pose) for pose in shapes.values())
        if self._last is not None and poses == self._poses and not fine:
            return self._last
        self._follow(shapes)
        picture = self._composed(fine=fine)
        if not fine:
            self._last, self._poses = picture, poses
        return picture

    def _follow(self, shapes: dict[Shape, Pose]) -> None:
        for gone in self._copies.keys() - shapes.keys():
            bullet.removeBody(self._copies.pop(gone), physicsClientId=self._engine.client)
        for shape, pose in shapes.items():
            if shape not in self._copies:
                self._copies[shape] = shape.look.copy(self._engine)
            _put(self._engine, self._copies[shape], pose)
        self._extras.follow(self._world.person.hand.pose(), self._world.person.head.pose())

    def _composed(self, *, fine: bool) -> Image.Image:
        palm = self._world.torso.palm_pose()
        grasp = bullet.multiplyTransforms(*palm, GRASP_POINT_M, UPRIGHT)[0]
        target = _sum(grasp, HAND_TARGET_M)
        near = Lens(_sum(target, HAND_EYE_M), target, HAND_DEGREES, (HAND_PX, HEIGHT_PX))
        whole = Image.new("RGB", (SCENE_PX + GAP_PX + HAND_PX, HEIGHT_PX))
        whole.paste(SCENE.picture(self._engine, fine=fine), (0, 0))
        whole.paste(near.picture(self._engine, fine=fine), (SCENE_PX + GAP_PX, 0))
        return whole


@dataclass(frozen=True)
class Look:
    """One visible shape of a link: what it is, and where on the link."""

    link: int
    kind: int
    size: tuple[float, ...]
    at: Pose
    rgba: tuple[float, ...]

    def copy(self, engine: Engine) -> int:
        """A body that only looks like it."""
        if self.kind == bullet.GEOM_BOX:
            return _show(engine, self.rgba, shapeType=self.kind, halfExtents=[extent / 2 for extent in self.size])
        if self.kind == bullet.GEOM_SPHERE:
            return _show(engine, self.rgba, shapeType=self.kind, radius=self.size[0])
        return _show(engine, self.rgba, shapeType=self.kind, length=self.size[0], radius=self.size[1])


@dataclass(frozen=True)
class Shape:
    """A body's visible shape; the body may have more of the same look."""

    body: int
    number: int
    look: Look


def visible(world: World) -> dict[Shape, Pose]:
    """The visible shapes of a world and where they are; only read from it. All are boxes, spheres, cylinders."""
    client = world.engine.client
    shapes: dict[Shape, Pose] = {}
    for number in range(bullet.getNumBodies(physicsClientId=client)):
        body = bullet.getBodyUniqueId(number, physicsClientId=client)
        frames: dict[int, Pose] = {}
        for order, look in enumerate(_looks_of(world, body)):
            if max(look.size) > FLOOR_M:
                continue
            if look.link not in frames:
                frames[look.link] = _frame(client, body, look.link)
            shapes[Shape(body, order, look)] = bullet.multiplyTransforms(*frames[look.link], *look.at)
    return shapes


def _looks_of(world: World, body: int) -> tuple[Look, ...]:
    if body == world.torso.body:  # its world has it without looks
        return _looks_of_description(world.torso.description)
    return _looks(world.engine, body)


@cache
def _looks_of_description(description: str) -> tuple[Look, ...]:
    with Engine(STEP_S) as engine:
        return _looks(engine, engine.load(description, sleeps=False, merges=True)[0])


def _looks(engine: Engine, body: int) -> tuple[Look, ...]:
    """What a body's links look like, as its engine knows it."""
    shapes = bullet.getVisualShapeData(body, physicsClientId=engine.client)
    return tuple(
        Look(link, kind, tuple(size), (place, turn), tuple(rgba))
        for _, link, kind, size, _, place, turn, rgba, *_ in shapes
    )


def _frame(client: int, body: int, link: int) -> Pose:
    """The frame that shapes are relative to: a base's is known only by its centre of mass."""
    if link >= 0:
        state = bullet.getLinkState(body, link, physicsClientId=client)
        return state[4], state[5]
    mass = bullet.getBasePositionAndOrientation(body, physicsClientId=client)
    inertial = bullet.getDynamicsInfo(body, -1, physicsClientId=client)[3:5]
    frame: Pose = bullet.multiplyTransforms(*mass, *bullet.invertTransform(*inertial))
    return frame


class Extras:
    """What is seen of the person beside head and hand."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        x, y, z = HAND_HALF_M
        slit = {"shapeType": bullet.GEOM_BOX, "halfExtents": (0.45 * x, 0.0012, z + 0.0008)}
        self._on_hand = {_show(engine, SKIN_LINE_RGBA, **slit): (-0.56 * x, 0.5 * y * i, 0.0) for i in (-1, 0, 1)}
        r = HEAD_RADIUS_M
        eye = {"shapeType": bullet.GEOM_SPHERE, "radius": 0.16 * r}
        nose = {"shapeType": bullet.GEOM_SPHERE, "radius": 0.2 * r}
        self._on_head = {
            _show(engine, DARK_RGBA, **eye): (0.9 * r, 0.35 * r, 0.2 * r),
            _show(engine, DARK_RGBA, **eye): (0.9 * r, -0.35 * r, 0.2 * r),
            _show(engine, NOSE_RGBA, **nose): (0.97 * r, 0.0, -0.1 * r),
        }
        self._sleeve = _show(engine, SLEEVE_RGBA, shapeType=bullet.GEOM_CYLINDER, length=SLEEVE_M, radius=0.042)
        self._shoulders = _show(engine, SLEEVE_RGBA, shapeType=bullet.GEOM_BOX, halfExtents=(0.10, 0.20, 0.17))

    def follow(self, hand: Pose, head: Pose) -> None:
        """Bring everything to where the person is."""
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
    """The turn that brings the z axis into a direction (a unit vector, not straight down)."""
    x, y, z = direction
    w = 1.0 + z
    length = (x * x + y * y + w * w) ** 0.5
    return (-y / length, x / length, 0.0, w / length)


def _show(engine: Engine, rgba: Sequence[float], **shape: Any) -> int:
    visual = bullet.createVisualShape(rgbaColor=rgba, physicsClientId=engine.client, **shape)
    body: int = bullet.createMultiBody(0.0, -1, visual, physicsClientId=engine.client)
    return body


def _put(engine: Engine, body: int, pose: Pose) -> None:
    bullet.resetBasePositionAndOrientation(body, pose[0], pose[1], physicsClientId=engine.client)


def _rounded(pose: Pose) -> Pose:
    (x, y, z), (a, b, c, d) = (tuple(round(part, SAME_DIGITS) for part in each) for each in pose)
    return (x, y, z), (a, b, c, d)


def _sum(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
