"""A camera for films of the world: the whole scene, and a close view of the robot's hand.

The camera copies the visual shapes of the world into a ray caster, so that filming cannot change a run. The copy has
additional details of the person: face, sleeve, shoulders, and lines between the fingers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from pytest_hricdv.runtime import Body
from sim import raycasting
from sim.geometry import UPRIGHT, Pose, Vector
from sim.person import HAND_HALF_M, HEAD_RADIUS_M
from sim.raycasting import Raycaster
from sim.shapes import Box, Cylinder, Shape, Sphere, Visual
from sim.world import World

SCENE_PX, HAND_PX, HEIGHT_PX, GAP_PX = 560, 392, 432, 8

FLOOR_M = 4.0
"""Wider shapes are the floor, which is painted as a backdrop: rendering time depends on covered pixels."""

POSE_DIGITS = 4
"""Poses that are equal to this number of digits (m) give the same picture."""

GAP_SHOWN_M = 0.10
"""The distance between the hands is drawn where it is shorter: in a handover, and where one is too near."""

LABEL_PX = 22
BRIGHT, DARK = (255, 255, 255), (24, 27, 33)

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

    def picture(self, raycaster: Raycaster, *, fine: bool) -> Image.Image:
        """The rendered picture; with shadows when `fine`."""
        rgb, nothing = raycaster.picture(self.eye, self.target, self.degrees, self.size, LIGHT, shadows=fine)
        return Image.fromarray(np.where(nothing[:, :, None], _backdrop(self._edge(), self.size[1]), rgb))

    def pixel(self, place: Vector) -> tuple[float, float]:
        """Where a place (m) is seen: column and row."""
        return raycasting.View(self.eye, self.target, self.degrees, self.size).pixel(place)

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
        self._raycaster = Raycaster()
        self._copies: dict[Visual, int] = {}
        self._poses: tuple[Pose, ...] = ()
        self._last: Image.Image | None = None
        self._details = PersonDetails(self._raycaster)

    def close(self) -> None:
        """Nothing is to be released."""

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

    def _follow(self, shapes: dict[Visual, Pose]) -> None:
        for gone in self._copies.keys() - shapes.keys():
            self._raycaster.remove(self._copies.pop(gone))
        for visual, pose in shapes.items():
            if visual not in self._copies:
                self._copies[visual] = self._raycaster.add(visual.shape, visual.rgba)
            self._raycaster.put(self._copies[visual], pose)
        self._details.follow(self._world)

    def _composed(self, *, fine: bool) -> Image.Image:
        target = _sum(self._world.grasp_point(), HAND_TARGET_M)
        near = View(_sum(target, HAND_EYE_M), target, HAND_DEGREES, (HAND_PX, HEIGHT_PX))
        close = near.picture(self._raycaster, fine=fine)
        self._draw_gap(close, near)
        whole = Image.new("RGB", (SCENE_PX + GAP_PX + HAND_PX, HEIGHT_PX))
        whole.paste(SCENE.picture(self._raycaster, fine=fine), (0, 0))
        whole.paste(close, (SCENE_PX + GAP_PX, 0))
        return whole

    def _draw_gap(self, picture: Image.Image, view: View) -> None:
        """Draw the shortest line between the robot's hand and the person's, with its length."""
        depth_m, robot, away = self._world.gripper.nearest_to_human()
        if not 0.0 < -depth_m < GAP_SHOWN_M:
            return
        x, y, z = away
        ends = [view.pixel(robot), view.pixel(_sum(robot, (depth_m * x, depth_m * y, depth_m * z)))]
        draw = ImageDraw.Draw(picture)
        draw.line(ends, fill=DARK, width=7)
        draw.line(ends, fill=BRIGHT, width=3)
        middle = ((ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2 - LABEL_PX)
        font = ImageFont.load_default(LABEL_PX)
        text = f"{-100.0 * depth_m:.1f} cm"
        draw.text(middle, text, fill=BRIGHT, font=font, anchor="mb", stroke_width=3, stroke_fill=DARK)


def visible(world: World) -> dict[Visual, Pose]:
    """The visual shapes of a world but for the floor, and their poses."""
    shapes = world.engine.visuals({world.torso.body: world.torso.description})
    return {visual: pose for visual, pose in shapes.items() if not _is_floor(visual.shape)}


def bodies(world: World) -> list[Body]:
    """The visual shapes of a world as a viewer draws them; with the floor."""
    shapes = world.engine.visuals({world.torso.body: world.torso.description})
    return [_body(visual, pose) for visual, pose in shapes.items()]


def _body(visual: Visual, pose: Pose) -> Body:
    name, (position, rotation) = f"body {visual.body}, shape {visual.number}", _rounded(pose)
    match visual.shape:
        case Box((x, y, z)):
            return Body(name, "box", (2 * x, 2 * y, 2 * z), position, rotation, visual.rgba)
        case Sphere(r):
            return Body(name, "sphere", (2 * r, 2 * r, 2 * r), position, rotation, visual.rgba)
        case Cylinder(r, length_m):
            return Body(name, "cylinder", (2 * r, 2 * r, length_m), position, rotation, visual.rgba)


def _is_floor(shape: Shape) -> bool:
    return isinstance(shape, Box) and 2 * max(shape.half_m) > FLOOR_M


class PersonDetails:
    """Visual details of the person."""

    def __init__(self, raycaster: Raycaster) -> None:
        self._raycaster = raycaster
        x, y, z = HAND_HALF_M
        slit = Box((0.45 * x, 0.0012, z + 0.0008))
        self._on_hand = {raycaster.add(slit, SKIN_LINE_RGBA): (-0.56 * x, 0.5 * y * i, 0.0) for i in (-1, 0, 1)}
        r = HEAD_RADIUS_M
        eye, nose = Sphere(0.16 * r), Sphere(0.2 * r)
        self._on_head = {
            raycaster.add(eye, DARK_RGBA): (0.9 * r, 0.35 * r, 0.2 * r),
            raycaster.add(eye, DARK_RGBA): (0.9 * r, -0.35 * r, 0.2 * r),
            raycaster.add(nose, NOSE_RGBA): (0.97 * r, 0.0, -0.1 * r),
        }
        self._sleeve = raycaster.add(Cylinder(radius_m=0.042, length_m=SLEEVE_M), SLEEVE_RGBA)
        self._shoulders = raycaster.add(Box((0.10, 0.20, 0.17)), SLEEVE_RGBA)

    def follow(self, world: World) -> None:
        """Move all details to the person's pose."""
        hand, head = world.person.hand.pose(), world.person.head.pose()
        for number, at in self._on_hand.items():
            self._raycaster.put(number, world.engine.compose(hand, (at, UPRIGHT)))
        for number, at in self._on_head.items():
            self._raycaster.put(number, world.engine.compose(head, (at, UPRIGHT)))
        wrist = _sum(hand[0], (HAND_HALF_M[0], 0.0, 0.0))
        reach = [b - a for a, b in zip(wrist, _sum(head[0], SHOULDER_M), strict=True)]
        length = sum(part * part for part in reach) ** 0.5
        ahead = [part / length for part in reach]
        middle = tuple(a + 0.5 * SLEEVE_M * b for a, b in zip(wrist, ahead, strict=True))
        self._raycaster.put(self._sleeve, ((middle[0], middle[1], middle[2]), _along(ahead)))
        self._raycaster.put(self._shoulders, (_sum(head[0], (SHOULDER_M[0], 0.0, SHOULDER_M[2])), UPRIGHT))


def _along(direction: Sequence[float]) -> tuple[float, float, float, float]:
    """The rotation of the z axis to a direction (a unit vector, not straight down)."""
    x, y, z = direction
    w = 1.0 + z
    length = (x * x + y * y + w * w) ** 0.5
    return (-y / length, x / length, 0.0, w / length)


def _rounded(pose: Pose) -> Pose:
    (x, y, z), (a, b, c, d) = (tuple(round(number, POSE_DIGITS) for number in part) for part in pose)
    return (x, y, z), (a, b, c, d)


def _sum(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
