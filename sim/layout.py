"""Layout of the workshop: places (m), floor, table and re-supply bin.

x points from the robot to the person, y to the robot's left, z up from the floor.
"""

from __future__ import annotations

from sim.engine import Engine
from sim.geometry import Vector
from sim.shapes import Box

PICKUP_M: Vector = (0.30, -0.30, 0.555)
"""Middle of a leg that waits to be fetched. Case study, original world frame."""

HANDOVER_M: Vector = (0.48, 0.17, 0.705)
"""Middle of a leg that is held out to the person. Case study, original world frame."""

STORE_M: Vector = (-0.40, -0.90, 0.125)
"""Middle of a leg that has not been brought to the pickup place yet: on the floor behind the robot."""

LEG_LENGTH_M = 0.25
LEG_RADIUS_M = 0.025
LEG_MASS_KG = 0.5

TABLE_TOP_M = PICKUP_M[2] - LEG_LENGTH_M / 2
"""Height of the shared table: a waiting leg stands on it."""

TABLE_M: Vector = (0.60, -0.16, TABLE_TOP_M - 0.02)
TABLE_HALF_M: Vector = (0.40, 0.44, 0.02)

BIN_M: Vector = (0.19, 0.48, 0.15)
"""Middle of the re-supply bin's bottom, below the robot's hand when it is turned away from the person."""

BIN_HALF_M = 0.16
BIN_HEIGHT_M = 0.30
BIN_WALL_M = 0.01

SEAT_HEAD_M: Vector = (1.25, 0.17, 1.15)
"""The person's head, seated opposite the robot."""

REST_HAND_M: Vector = (0.92, 0.34, 0.47)
"""The person's hand at rest, on the person's side of the table."""

REST_LOW_M: Vector = (0.475, -0.50, 0.46)
REST_HIGH_M: Vector = (0.78, 0.10, 0.70)
"""Corners of the box over the shared table in which a waiting person's hand may rest. It ends where the robot's closing
hand begins: about 3 % of uniformly drawn places are within 0.05 m of it (tests/sim/test_resting.py measures this)."""

AWAY_HEAD_M: Vector = (2.40, 0.90, 1.60)
AWAY_HAND_M: Vector = (2.30, 0.70, 0.90)
"""Where a person is after walking off."""

ROBOT, LEG, FURNITURE, PERSON = 1, 2, 4, 8
"""Collision groups. Legs collide with furniture and each other. The robot has no contacts: a grasp is a joint between
palm and leg (its reaction is exact, while a friction grasp slips), and the planner keeps the arm off the table. Nothing
pushes the person; fingers that close on the person's hand are stopped by it (`sim.fingers.HandContact`)."""

LAMINATE = (0.80, 0.82, 0.80, 1.0)
GREY = (0.45, 0.47, 0.50, 1.0)


def assembly_place(number: int) -> Vector:
    """Where the person puts down received leg number 0, 1, 2, ...: on the person's side of the table."""
    return (0.92, -0.50 + 0.10 * (number % 6), PICKUP_M[2] + 0.001)


def in_bin(place: Vector) -> bool:
    """True for a place between the walls of the re-supply bin."""
    inside = abs(place[0] - BIN_M[0]) < BIN_HALF_M and abs(place[1] - BIN_M[1]) < BIN_HALF_M
    return inside and BIN_M[2] < place[2] < BIN_M[2] + BIN_HEIGHT_M


def height_below(place: Vector) -> float:
    """Height (m) of the surface below a place: the bin's bottom, the table, or the floor."""
    if in_bin((place[0], place[1], BIN_M[2] + BIN_HEIGHT_M / 2)):
        return BIN_M[2]
    over_table = all(abs(place[axis] - TABLE_M[axis]) < TABLE_HALF_M[axis] for axis in (0, 1))
    return TABLE_TOP_M if over_table else 0.0


def furnish(engine: Engine) -> tuple[int, ...]:
    """Add floor, table and bin; returns their body ids, the floor first."""
    floor = engine.add(0.0, (0.8, 0.0, -0.05), GREY, Box((2.5, 2.5, 0.05)))
    table = engine.add(0.0, TABLE_M, LAMINATE, Box(TABLE_HALF_M))
    bodies = (floor, table, *_bin(engine))
    for body in bodies:
        engine.set_collision_group(body, FURNITURE, LEG)
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
    return tuple(engine.add(0.0, middle, GREY, Box(half)) for middle, half in parts)
