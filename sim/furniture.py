"""What stands still: floor, table, re-supply bin."""

from __future__ import annotations

from sim.engine import Engine, Vector, bullet
from sim.places import BIN_HALF_M, BIN_HEIGHT_M, BIN_M, BIN_WALL_M, TABLE_HALF_M, TABLE_M

ROBOT, LEG, FURNITURE, PERSON = 1, 2, 4, 8
"""Collision groups. Legs meet furniture and each other. The robot's own contacts are left out: grasping is a joint
between palm and leg (its reaction is exact, a friction grasp slips), and the planner keeps the arm off the table. The
person gives way to nobody; what closes around the person's hand is the fingers, and they are stopped by it."""

LAMINATE = (0.80, 0.82, 0.80, 1.0)
GREY = (0.45, 0.47, 0.50, 1.0)


def furnish(engine: Engine) -> tuple[int, ...]:
    """Set up floor, table and bin; returns their body ids, the floor's first."""
    floor = engine.add(0.0, (0.8, 0.0, -0.05), GREY, shapeType=bullet.GEOM_BOX, halfExtents=(2.5, 2.5, 0.05))
    table = engine.add(0.0, TABLE_M, LAMINATE, shapeType=bullet.GEOM_BOX, halfExtents=TABLE_HALF_M)
    bodies = (floor, table, *_bin(engine))
    for body in bodies:
        bullet.setCollisionFilterGroupMask(body, -1, FURNITURE, LEG, physicsClientId=engine.client)
    return bodies


def _bin(engine: Engine) -> tuple[int, ...]:
    x, y, z = BIN_M
    side, high, wall = BIN_HALF_M, BIN_HEIGHT_M / 2, BIN_WALL_M
    parts: tuple[tuple[Vector, Vector], ...] = (
        ((x, y, z - wall), (side, side, wall)),
        ((x - side - wall, y, z + high), (wall, side, high)),
        ((x + side + wall, y, z + high), (wall, side, high)),
        ((x, y - side - wall, z + high), (side, wall, high)),
        ((x, y + side + wall, z + high), (side, wall, high)),
    )
    return tuple(engine.add(0.0, middle, GREY, shapeType=bullet.GEOM_BOX, halfExtents=half) for middle, half in parts)
