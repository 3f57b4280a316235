"""The flat seen from above, for films, and as boxes and cylinders for viewers in 3-D.

In pictures y goes to the right and x goes down, so that the flat lies: the living room is left, the kitchen right.

Needs Pillow, as all films do; nothing else of the house imports it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from PIL import Image, ImageDraw

from house.flat import CHARGER, INSIDE, SINK, SOLIDS, Solid
from house.house import House
from house.shapes import Box, Point, box_around
from house.walkers import DOG_SIZE_M, PERSON_RADIUS_M
from pytest_hricdv.testbench import Body

PX_PER_M = 56
"""Of a picture; it is drawn twice as large, for smooth edges."""

FINE = 2
MARGIN_M = 0.3
FRAME = INSIDE.grown(MARGIN_M)

FLOOR, KITCHEN = (243, 239, 230), (226, 233, 238)
KIND_RGB = {"wall": (92, 96, 104), "furniture": (190, 160, 122)}
NAME_RGB = (70, 60, 48)
ROBOT_RGB, ROBOT_HOT_RGB, FOOD_RGB = (52, 110, 180), (200, 40, 40), (242, 190, 40)
PERSON_RGB, HEAD_RGB, DOG_RGB, CHARGER_RGB = (46, 130, 84), (222, 184, 150), (120, 84, 52), (70, 150, 70)
TRACK_RGB = (150, 180, 214)

ROBOT_HEIGHT_M, PERSON_HEIGHT_M, DOG_HEIGHT_M = 1.1, 1.7, 0.30
TRACK_POINTS = 4000
"""So much of the robot's way is drawn, from its end."""

_LABELS = {"fridge": "fridge", "sofa": "sofa", "TV stand": "TV", "table": "table"}


class Camera:
    """Looks down on a house; a `pytest_hricdv.testbench.Camera`.

    Args:
        house: it looks only, and changes nothing.
    """

    def __init__(self, house: House) -> None:
        self._house = house
        self._room = _room()
        self._track: list[Point] = []
        self._seen: tuple[object, ...] = ()
        self._last: Image.Image | None = None

    def close(self) -> None:
        """Nothing is to be released."""

    def picture(self, *, fine: bool = False) -> Image.Image:
        """The flat now; the same object as last time if nothing has moved."""
        house = self._house
        seen = (
            *(round(part, 3) for at in (house.base.at, house.person.at, house.dog.at) for part in at),
            round(house.base.heading_rad, 2),
            round(house.dog.heading_rad, 2),
            house.gripper.holds,
            round(house.gripper.opening, 2),
            house.contact.with_what,
        )
        if self._last is not None and seen == self._seen:
            return self._last
        self._track = [*self._track[-TRACK_POINTS:], house.base.at]
        self._seen, self._last = seen, self._drawn()
        return self._last

    def _drawn(self) -> Image.Image:
        house, whole = self._house, self._room.copy()
        draw = ImageDraw.Draw(whole)
        if len(self._track) > 1:
            draw.line([_px(at) for at in self._track], fill=TRACK_RGB, width=2 * FINE)
        _turned_box(draw, house.dog.at, house.dog.heading_rad, DOG_SIZE_M, DOG_RGB)
        _disc(draw, house.person.at, PERSON_RADIUS_M, PERSON_RGB)
        _disc(draw, house.person.at, 0.1, HEAD_RGB)
        base = house.base
        _disc(draw, base.at, base.radius_m, ROBOT_HOT_RGB if house.contact.with_what != "nothing" else ROBOT_RGB)
        ahead = (math.cos(base.heading_rad), math.sin(base.heading_rad))
        for side in (-1.0, 1.0):  # the fingers
            apart_m = side * (0.02 + 0.08 * house.gripper.opening)
            start = (base.at[0] + 0.2 * ahead[0] - apart_m * ahead[1], base.at[1] + 0.2 * ahead[1] + apart_m * ahead[0])
            draw.line([_px(start), _px((start[0] + 0.14 * ahead[0], start[1] + 0.14 * ahead[1]))], "black", 2 * FINE)
        if house.gripper.holds:
            _disc(draw, (base.at[0] + 0.3 * ahead[0], base.at[1] + 0.3 * ahead[1]), 0.06, FOOD_RGB)
        return whole.resize((whole.width // FINE, whole.height // FINE), Image.Resampling.LANCZOS)


def bodies(house: House) -> list[Body]:
    """Walls, furniture, robot, person and dog as a viewer in 3-D draws them."""
    base, person, dog = house.base, house.person, house.dog
    return [
        *map(_solid_body, SOLIDS),
        Body(
            "robot",
            "cylinder",
            (2.0 * base.radius_m, 2.0 * base.radius_m, ROBOT_HEIGHT_M),
            (*base.at, ROBOT_HEIGHT_M / 2.0),
            _about_z(base.heading_rad),
            _rgba(ROBOT_RGB),
        ),
        Body(
            "person",
            "cylinder",
            (2.0 * PERSON_RADIUS_M, 2.0 * PERSON_RADIUS_M, PERSON_HEIGHT_M),
            (*person.at, PERSON_HEIGHT_M / 2.0),
            rgba=_rgba(PERSON_RGB),
        ),
        Body(
            "dog",
            "box",
            (*DOG_SIZE_M, DOG_HEIGHT_M),
            (*dog.at, DOG_HEIGHT_M / 2.0),
            _about_z(dog.heading_rad),
            _rgba(DOG_RGB),
        ),
    ]


def _solid_body(solid: Solid) -> Body:
    box = solid.box
    middle = ((box.x1 + box.x2) / 2.0, (box.y1 + box.y2) / 2.0, solid.height_m / 2.0)
    size = (box.x2 - box.x1, box.y2 - box.y1, solid.height_m)
    return Body(solid.name, "box", size, middle, rgba=_rgba(KIND_RGB[solid.kind]))


def _room() -> Image.Image:
    """What never moves."""
    whole = Image.new("RGB", (_length_px(FRAME.y2 - FRAME.y1), _length_px(FRAME.x2 - FRAME.x1)), FLOOR)
    draw = ImageDraw.Draw(whole)
    _box(draw, Box(INSIDE.x1, -0.9, INSIDE.x2, INSIDE.y2), KITCHEN)
    _disc(draw, CHARGER, 0.3, CHARGER_RGB, outline_only=True)
    for solid in SOLIDS:
        _box(draw, solid.box, KIND_RGB[solid.kind])
    _box(draw, SINK.grown(-0.06), (214, 220, 226))
    for solid in SOLIDS:
        if solid.name in _LABELS:
            middle = ((solid.box.x1 + solid.box.x2) / 2.0, (solid.box.y1 + solid.box.y2) / 2.0)
            draw.text(_px(middle), _LABELS[solid.name], NAME_RGB, anchor="mm", font_size=11 * FINE)
    draw.text(_px(((SINK.x1 + SINK.x2) / 2.0, 3.7)), "sink", NAME_RGB, anchor="mm", font_size=11 * FINE)
    draw.text(_px((CHARGER[0] - 0.45, CHARGER[1])), "charger", CHARGER_RGB, anchor="mm", font_size=11 * FINE)
    return whole


def _rgba(rgb: Sequence[int]) -> tuple[float, ...]:
    return (*(part / 255.0 for part in rgb), 1.0)


def _about_z(angle_rad: float) -> tuple[float, float, float, float]:
    return (0.0, 0.0, math.sin(angle_rad / 2.0), math.cos(angle_rad / 2.0))


def _length_px(length_m: float) -> int:
    return round(length_m * PX_PER_M) * FINE


def _px(at: Point) -> tuple[float, float]:
    return (at[1] - FRAME.y1) * PX_PER_M * FINE, (at[0] - FRAME.x1) * PX_PER_M * FINE


def _box(draw: ImageDraw.ImageDraw, box: Box, rgb: tuple[int, int, int]) -> None:
    draw.polygon([_px(corner) for corner in box.corners], fill=rgb)


def _turned_box(
    draw: ImageDraw.ImageDraw, middle: Point, heading_rad: float, size: Point, rgb: tuple[int, int, int]
) -> None:
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    corners = box_around((0.0, 0.0), size).corners
    draw.polygon([_px((middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y)) for x, y in corners], fill=rgb)
    head = (middle[0] + cos * size[0] / 2.0, middle[1] + sin * size[0] / 2.0)
    _disc(draw, head, 0.06, rgb)


def _disc(
    draw: ImageDraw.ImageDraw,
    middle: Point,
    radius_m: float,
    rgb: tuple[int, int, int],
    *,
    outline_only: bool = False,
) -> None:
    (x, y), radius = _px(middle), radius_m * PX_PER_M * FINE
    corners = (x - radius, y - radius, x + radius, y + radius)
    draw.ellipse(corners, fill=None if outline_only else rgb, outline=rgb, width=2 * FINE)
