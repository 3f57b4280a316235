"""What a film declares, and when pictures are taken: a pure function of what happened in the run."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.film.schedule import FRAMES, Moment, key_moments, schedule

PERIOD_US = 50_000
MOMENTS = {"request": "request", "grasp": "leg_held", "offer": "leg_ready", "decision": "reading"}
TWO_TURNS = [
    (3.0, "request"),
    (15.0, "leg_held"),
    (21.0, "leg_ready"),
    (30.0, "reading"),
    (50.0, "request"),
    (62.0, "leg_held"),
    (68.0, "leg_ready"),
]


def shown(moments: list[Moment]) -> list[tuple[str, float | None]]:
    """The key frames as pairs."""
    return [(moment.shows, moment.time_s) for moment in moments]


def test_key_frames_are_of_the_turn_of_the_violation_in_the_order_of_time() -> None:
    assert shown(key_moments(MOMENTS, TWO_TURNS, 14.0, 100.0)) == [
        ("request", 3.0),
        ("violation", 14.0),
        ("grasp", 15.0),
        ("offer", 21.0),
        ("decision", 30.0),
        ("end", 100.0),
    ]


def test_pictures_of_key_frames_are_taken_right_after_them_and_around_a_violation_at_every_period() -> None:
    plan = schedule(key_moments(MOMENTS, TWO_TURNS, 14.0, 100.0), [14.0], 100.0, PERIOD_US)
    assert plan.keys["request"] == 3_050_000
    assert plan.keys["violation"] == 14_050_000
    assert plan.keys["end"] == 100_000_000
    around = [time for time in plan.times_us if 13_600_000 <= time <= 15_400_000]
    assert around == list(range(13_600_000, 15_400_001, PERIOD_US))
    assert plan.is_slow(14_000_000)
    assert not plan.is_slow(20_000_000)


@given(
    end_s=st.floats(0.5, 2000.0),
    violations_s=st.lists(st.floats(0.0, 1.0), max_size=9),
    period_us=st.integers(10_000, 300_000),
)
def test_pictures_are_few_and_lie_on_the_grid_and_within_the_run(
    end_s: float, violations_s: list[float], period_us: int
) -> None:
    times_s = sorted(share * end_s for share in violations_s)
    plan = schedule(key_moments({}, [], None, end_s), times_s, end_s, period_us)
    assert list(plan.times_us) == sorted(set(plan.times_us))
    assert all(time_us % period_us == 0 and time_us <= end_s * 1e6 + period_us for time_us in plan.times_us)
    slow_each = 2_000_000 // period_us + 3
    assert len(plan.times_us) <= 2 * FRAMES + 3 * slow_each
