"""What the laser sees that the map does not have."""

from __future__ import annotations

from math import hypot, inf, pi

from carebot.flatmap import HULL_M, PLACES, FlatMap
from carebot.messages import Pose, Scan
from carebot.watching import Seen, is_in_the_way, unknown

RAYS = 720


def seen_from(pose: Pose, ranges: dict[int, float]) -> list[tuple[float, float]]:
    """Where something is seen, of rays by their number."""
    scan = Scan(tuple(ranges.get(number, inf) for number in range(RAYS)))
    return [(round(seen.x, 2), round(seen.y, 2)) for seen in unknown(scan, pose, FlatMap(), within_m=1.2)]


def test_what_is_in_the_map_is_not_among_it() -> None:
    # The charger is 0.65 m from the wall at x = 2.0.
    x, y = PLACES["charger"]
    assert seen_from(Pose(x, y, 0.0), {RAYS // 2: 0.65}) == []
    assert seen_from(Pose(x, y, 0.0), {RAYS // 2: 0.3}) == [(1.65, 0.01)]


def test_rays_are_counted_from_behind_counter_clockwise() -> None:
    assert seen_from(Pose(0.0, 0.0, 0.0), {RAYS // 2: 1.0, RAYS * 3 // 4: 0.5, 0: 0.8}) == [
        (-0.8, -0.0),
        (1.0, 0.0),
        (0.0, 0.5),
    ]
    assert seen_from(Pose(0.0, 1.0, pi / 2), {RAYS // 2: 1.0}) == [(0.0, 2.0)]


def test_only_what_is_ahead_and_near_is_in_the_way() -> None:
    scan = Scan(tuple(1.0 for _ in range(RAYS)))
    around = unknown(scan, Pose(0.0, 1.2, 0.0), FlatMap(), within_m=1.2)
    blocking = [seen for seen in around if is_in_the_way(seen, stop_m=0.8)]
    assert blocking
    assert all(seen.ahead_m > 0.9 and hypot(seen.ahead_m, seen.left_m) < HULL_M + 0.8 for seen in blocking)
    assert not [seen for seen in around if is_in_the_way(seen, stop_m=0.3)]


def test_who_stands_beside_is_in_the_way_only_if_the_robot_comes_nearer_to_them() -> None:
    beside, ahead = Seen(0.05, -0.33, 0.05, -0.33), Seen(0.3, -0.33, 0.3, -0.33)
    assert is_in_the_way(beside, 0.3)
    assert not is_in_the_way(beside, 0.3, [beside])
    assert is_in_the_way(ahead, 0.3, [ahead])
    elsewhere = Seen(0.0, 0.32, 0.0, 0.32)
    assert is_in_the_way(ahead, 0.3, [ahead, elsewhere])
