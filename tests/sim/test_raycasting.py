"""The ray caster sees what MuJoCo's own rays hit, shape by shape and shadow by shadow; the same picture each time."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sim.geometry import Quaternion, Vector
from sim.raycasting import LIT, MIDDLE, SHADED, Raycaster, View
from sim.shapes import Box, Cylinder, Shape, Sphere

EYE: Vector = (1.3, -2.2, 1.4)
TARGET: Vector = (0.0, 0.0, 0.0)
LIGHT: Vector = (0.5, -1.0, 2.2)
DEGREES, SIZE = 42.0, (140, 108)
KINDS = (mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CYLINDER)


def shapes(count: int, seed: int) -> list[tuple[Shape, Vector, Quaternion]]:
    """Boxes, spheres and cylinders in turn, anywhere around the target."""
    rng, found = np.random.default_rng(seed), []
    for number in range(count):
        x, y, z = rng.uniform(0.03, 0.2, 3).tolist()
        shape = (Box((x, y, z)), Sphere(x), Cylinder(x, 2.0 * y))[number % 3]
        a, b, c = rng.uniform(-0.8, 0.8, 3).tolist()
        turn = rng.normal(size=4)
        qx, qy, qz, qw = (turn / np.linalg.norm(turn)).tolist()
        found.append((shape, (a, b, c), (qx, qy, qz, qw)))
    return found


def picture(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    raycaster = Raycaster()
    for number, (shape, place, turn) in enumerate(shapes(count, seed), 1):
        raycaster.put(raycaster.add(shape, (number / 255.0, 0.5, 1.0, 1.0)), (place, turn))
    return raycaster.picture(EYE, TARGET, DEGREES, SIZE, LIGHT, shadows=True)


def reference(count: int, seed: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The same shapes in MuJoCo."""
    spec = mujoco.MjSpec()
    for number, (shape, place, (x, y, z, w)) in enumerate(shapes(count, seed)):
        match shape:
            case Box(size):
                pass
            case Sphere(radius):
                size = (radius, 0.0, 0.0)
            case Cylinder(radius, length):
                size = (radius, length / 2.0, 0.0)
        spec.worldbody.add_geom(type=KINDS[number % 3], size=size, pos=place, quat=(w, x, y, z))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("seed", [1, 2])
def test_each_pixel_is_as_bright_as_where_a_ray_of_mujoco_hits(seed: int) -> None:
    count = 40
    rgb, nothing = picture(count, seed)
    model, data = reference(count, seed)
    view, light = View(EYE, TARGET, DEGREES, SIZE), np.array(LIGHT) / np.linalg.norm(LIGHT)
    hit, normal = np.zeros(1, np.int32), np.zeros(3)
    checked = wrong = 0
    for pixel in np.random.default_rng(seed).choice(SIZE[0] * SIZE[1], 4000, replace=False):
        row, column = divmod(int(pixel), SIZE[0])
        ray = (view.axes[2] + view.xs[column] * view.axes[0] + view.ys[row] * view.axes[1]).astype(float)
        way = mujoco.mj_ray(model, data, np.array(EYE), ray, None, 1, -1, hit, normal)
        assert nothing[row, column] == (way < 0.0)
        facing = float(normal @ light)
        if way < 0.0 or abs(facing) < 0.02:
            continue
        seen = np.array(EYE) + ray * way + normal * 1e-5
        shaded = facing > 0.0 and mujoco.mj_ray(model, data, seen, light, None, 1, -1, hit, None) >= 0.0
        shade = MIDDLE + (SHADED if shaded else LIT) * facing
        checked += 1
        wrong += abs(float(rgb[row, column, 2]) - 255.0 * shade) > 3.0
    assert checked > 800
    assert wrong <= checked / 500  # at the edges of shapes and shadows


def test_the_same_scene_gives_the_same_picture() -> None:
    first, again = picture(20, 3), picture(20, 3)
    assert first[0].tobytes() == again[0].tobytes()
    assert first[1].tobytes() == again[1].tobytes()


def test_where_nothing_is_nothing_is_seen() -> None:
    rgb, nothing = Raycaster().picture(EYE, TARGET, DEGREES, SIZE, LIGHT, shadows=True)
    assert rgb.shape == (SIZE[1], SIZE[0], 3)
    assert nothing.all()
