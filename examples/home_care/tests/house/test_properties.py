"""What holds in the flat whatever is done in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from carebot.messages import Velocity
from house.battery import Battery
from house.flat import BOXES, INSIDE, PLACES, SEAT, STANDS
from house.house import House
from house.laser import GREATEST_M, NOISE_M, RAYS, Disc, Laser, TurnedBox, distances
from house.planar import Pose, driven
from house.routes import Around, route
from house.shapes import Box, Point, box_around, distance_to_segment, gap_to_box, gap_to_turned_box
from house.walkers import DOG_SIZE_M, PERSON_RADIUS_M
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_hricdv.runtime import Kernel, Recorder

OVERLAP_M = 1e-5
"""Less is rounding."""

inside = st.tuples(st.floats(INSIDE.x1 + 0.5, INSIDE.x2 - 0.5), st.floats(INSIDE.y1 + 0.5, INSIDE.y2 - 0.5))
angles = st.floats(-math.pi, math.pi)
velocities = st.tuples(st.floats(-1.5, 1.5), st.floats(-2.5, 2.5), st.floats(0.01, 3.0))


def is_free(at: Point, radius_m: float) -> bool:
    return all(gap_to_box(at, radius_m, box).width_m > 0.0 for box in BOXES)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(velocities, min_size=1, max_size=8),
    inside.filter(lambda at: is_free(at, 0.3)),
    st.sampled_from(sorted(PLACES)),
    st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), max_size=4),
    st.floats(0.2, 2.0),
)
def test_nothing_passes_through_anything(
    drives: Sequence[tuple[float, float, float]],
    start: Point,
    place: str,
    jumps: Sequence[Point],
    speed_m_s: float,
) -> None:
    kernel, recorder = Kernel(), Recorder()
    house = House(kernel, recorder, 1)
    kernel.world = house
    if math.dist(start, house.dog.at) > 0.5:
        house.base.at = start

    def robot() -> None:
        for forward, turn, duration_s in drives:
            house.drive(Velocity(forward, turn))
            kernel.sleep(duration_s)

    def person() -> None:
        house.person.go(PLACES[place], speed_m_s)

    def dog() -> None:
        house.dog.follow(lambda: house.base.at, 0.3, 1.5)
        for dx, dy in jumps:
            kernel.sleep(0.3)
            house.dog_jumps(dx, dy)

    def look() -> None:
        before, jumps_m = house.base.at, 0.5
        while True:
            kernel.sleep(0.05)
            base, at = house.base, house.base.at
            assert all(gap_to_box(at, base.radius_m, box).width_m > -OVERLAP_M for box in BOXES)
            assert house.dog.gap_to(at, base.radius_m).width_m > -OVERLAP_M
            assert house.person.gap_to(at, base.radius_m).width_m > -OVERLAP_M
            assert INSIDE.contains(at)
            assert INSIDE.contains(house.dog.at)
            assert math.dist(before, at) <= 1.0 * 0.05 + 1e-9 + (jumps_m if jumps else 0.0)
            before = at

    for name, body in (("robot", robot), ("person", person), ("dog", dog), ("look", look)):
        kernel.spawn(name, body)
    kernel.run(4.0)


def slow_distance(at: Point, angle: float, disc: Disc, box: TurnedBox) -> float:
    """Of one ray, by sides of boxes as segments, and a quadratic equation."""
    d = (math.cos(angle), math.sin(angle))
    cos, sin = math.cos(box.heading_rad), math.sin(box.heading_rad)
    own = box_around((0.0, 0.0), box.size).corners
    turned = [(box.middle[0] + cos * x - sin * y, box.middle[1] + sin * x + cos * y) for x, y in own]
    hits = [math.inf]
    for corners in (*(solid.corners for solid in BOXES), turned):
        for (x1, y1), (x2, y2) in pairwise((*corners, corners[0])):
            cross = d[0] * (y2 - y1) - d[1] * (x2 - x1)
            if abs(cross) < 1e-12:
                continue
            along = ((x1 - at[0]) * (y2 - y1) - (y1 - at[1]) * (x2 - x1)) / cross
            part = ((x1 - at[0]) * d[1] - (y1 - at[1]) * d[0]) / cross
            if along >= 0.0 and 0.0 <= part <= 1.0:
                hits.append(along)
    to = (disc.middle[0] - at[0], disc.middle[1] - at[1])
    half, rest = to[0] * d[0] + to[1] * d[1], to[0] ** 2 + to[1] ** 2 - disc.radius_m**2
    if half > 0.0 and half * half >= rest:
        hits.append(half - math.sqrt(half * half - rest))
    return min(hits)


@settings(max_examples=40, deadline=None)
@given(inside.filter(lambda at: is_free(at, 0.05)), angles, inside, inside, angles)
def test_rays_meet_what_a_slower_reference_says(
    at: Point, heading: float, person: Point, dog: Point, dog_heading: float
) -> None:
    disc, box = Disc(person, PERSON_RADIUS_M), TurnedBox(dog, dog_heading, DOG_SIZE_M)
    if math.dist(at, person) < 0.3 or math.dist(at, dog) < 0.2:
        return
    far_m = GREATEST_M + 6 * NOISE_M  # what is farther may be left out
    fast = np.minimum(distances(at, heading, (disc,), (box,)), far_m)
    # A ray that grazes a corner may meet it or not: what counts is that a neighbour a hair's breadth away agrees.
    for ray in range(0, RAYS, 13):
        angle = heading - math.pi + 2.0 * math.pi * ray / RAYS
        slow = [min(far_m, slow_distance(at, angle + by, disc, box)) for by in (0.0, -1e-5, 1e-5)]
        assert any(math.isclose(fast[ray], exact, abs_tol=2e-3) for exact in slow)


def test_noise_is_as_declared_and_what_is_out_of_range_is_infinite() -> None:
    laser = Laser(5)
    exact = distances((0.0, 0.0), 0.0, (), ())
    many = np.array([laser.ranges((0.0, 0.0), 0.0, (), ()) for _ in range(200)])
    near = (exact > 0.5) & (exact < 5.0)
    assert np.std(many[:, near] - exact[near]) == pytest.approx(NOISE_M, rel=0.02)
    assert np.isinf(many[:, exact > 5.8]).all()
    assert (exact > 5.8).any()


@settings(max_examples=60, deadline=None)
@given(
    inside.filter(lambda at: is_free(at, PERSON_RADIUS_M)),
    st.sampled_from((*PLACES.values(), STANDS)),
    inside.filter(lambda at: is_free(at, 0.27)),
    st.booleans(),
)
def test_ways_keep_their_distance(start: Point, end: Point, robot: Point, is_there: bool) -> None:
    around = (Around(robot, 0.6),) if is_there else ()
    way = route(start, end, PERSON_RADIUS_M, *around)
    if not is_there:
        assert way
    for first, second in pairwise((start, *way)):
        for box in BOXES:
            # Boxes are grown at their sides, so corners may be passed as near as this.
            assert not box.grown(PERSON_RADIUS_M / math.sqrt(2.0) - 1e-6).crosses(first, second)
        if is_there:
            keeps_m = min(0.6, math.dist(start, robot))
            assert distance_to_segment(robot, first, second) > keeps_m - 1e-5
    assert not way or way[-1] == end


def test_two_may_close_together_what_each_alone_leaves_open() -> None:
    start, end, clearance_m = (-1.0, 0.5), (-1.0, -2.5), 0.32
    # The opening between the dividing walls is 3.3 m wide: each leaves one half of it.
    left, right = Around((-1.9, -0.9), 0.9), Around((-0.1, -0.9), 0.9)
    assert route(start, end, clearance_m, left)
    assert route(start, end, clearance_m, right)
    assert route(start, end, clearance_m, left, right) == ()
    assert route(start, end, clearance_m, left._replace(keeps_m=0.6), right._replace(keeps_m=0.6))


def test_there_are_ways_between_all_places() -> None:
    for start in PLACES.values():
        for end in PLACES.values():
            assert start == end or route(start, end, PERSON_RADIUS_M)
    assert route((0.0, 0.0), SEAT, PERSON_RADIUS_M) == ()  # on the sofa: who sits down goes there by the last step


@settings(max_examples=100, deadline=None)
@given(st.tuples(inside, angles), st.floats(-1.0, 1.0), st.floats(-2.0, 2.0), st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_an_arc_is_the_same_in_parts(
    start: tuple[Point, float], forward: float, turn: float, first_s: float, then_s: float
) -> None:
    whole = driven(Pose(*start), forward, turn, first_s + then_s)
    parts = driven(driven(Pose(*start), forward, turn, first_s), forward, turn, then_s)
    assert math.dist(whole.at, parts.at) < 1e-9
    assert math.cos(whole.heading_rad - parts.heading_rad) == pytest.approx(1.0)


@settings(max_examples=100, deadline=None)
@given(inside, inside, angles, st.floats(0.1, 1.0), st.floats(0.1, 1.0))
def test_a_gap_is_that_to_the_nearest_point(
    middle: Point, box_middle: Point, heading: float, width: float, depth: float
) -> None:
    gap = gap_to_turned_box(middle, 0.0, box_middle, heading, (width, depth))
    cos, sin = math.cos(heading), math.sin(heading)
    parts = np.linspace(-0.5, 0.5, 101)
    sides = [(u * width, v * depth) for u in parts for v in (-0.5, 0.5)]
    sides += [(u * width, v * depth) for u in (-0.5, 0.5) for v in parts]
    far_m = min(
        math.dist(middle, (box_middle[0] + cos * x - sin * y, box_middle[1] + sin * x + cos * y)) for x, y in sides
    )
    assert abs(gap.width_m) == pytest.approx(far_m, abs=0.011)
    assert math.hypot(*gap.away) == pytest.approx(1.0)
    out = (middle[0] - gap.width_m * gap.away[0], middle[1] - gap.width_m * gap.away[1])
    assert gap_to_turned_box(out, 0.0, box_middle, heading, (width, depth)).width_m == pytest.approx(0.0, abs=1e-6)


@settings(max_examples=100, deadline=None)
@given(st.floats(0.0, 1.0), st.booleans())
def test_time_jumps_to_where_a_battery_shows_another_level(level: float, charging: bool) -> None:
    battery = Battery(level)
    battery.plug(0, charging=charging)
    shown, due_us = battery.shown(0), battery.changes_us(0)
    assert battery.shown(max(0, int(min(due_us, 1e9)) - 5)) == shown  # to a few us, for rounding
    if due_us != math.inf:
        assert battery.shown(int(due_us)) != shown
    assert battery.changes_us(int(min(due_us, 1e9)) // 2) == due_us  # whoever looks, and when


def test_a_segment_crosses_a_box_only_through_its_inside() -> None:
    box = Box(0.0, 0.0, 1.0, 1.0)
    assert box.crosses((-1.0, 0.5), (2.0, 0.5))
    assert not box.crosses((-1.0, 0.0), (2.0, 0.0))  # along a side
    assert not box.crosses((-1.0, 1.0), (1.0, 3.0))
    assert not box.crosses((-1.0, 0.5), (0.0, 0.5))  # up to it
