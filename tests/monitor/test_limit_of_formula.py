"""What a formula reads, and the numbers in it that a signal is compared with."""

from __future__ import annotations

import pytest

from pytest_hricdv.monitor import Vocabulary, parse_formula
from pytest_hricdv.monitor.analysis import Limit, limits, names_shown

VOCABULARY = Vocabulary(
    signals={"distance": float, "speed": float, "closing": bool, "room": str},
    messages={"reading": {"gaze": bool, "force": float}, "stop": {}},
)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("always(closing -> distance >= 0.05)", ("closing", "distance")),
        ("always(on(stop) -> eventually[0:2](speed < 0.1))", ("stop", "speed")),
        ("always(rise(reading.gaze) -> always(not closing) until on(stop))", ("reading.gaze", "closing", "stop")),
        ('always(room == "kitchen" -> last(reading.force) < 3)', ("room", "reading.force")),
        ("always(time_since(on(stop)) < 3 -> count(closing) < 2)", ("stop", "closing")),
        ("always(once[0:3](closing) -> distance + speed < 1)", ("closing", "distance", "speed")),
    ],
)
def test_names_are_read_wherever_they_stand(text: str, names: tuple[str, ...]) -> None:
    assert names_shown(parse_formula(text, VOCABULARY)) == names


@pytest.mark.parametrize(
    ("text", "drawn"),
    [
        ("always(closing -> distance >= 0.05 [hysteresis 0.005])", [Limit("distance", ">=", 0.05)]),
        ("always(closing -> 0.05 < distance)", [Limit("distance", ">", 0.05)]),
        ("always(closing -> speed <= 2 & speed >= -2)", [Limit("speed", "<=", 2), Limit("speed", ">=", -2)]),
        ("always(closing -> speed < 2 * (3 + 1))", [Limit("speed", "<", 8)]),
        ("always(closing -> reading.force < 10 - 4)", [Limit("reading.force", "<", 6)]),
        ("always(speed > 1 -> speed > 1)", [Limit("speed", ">", 1)]),
        ("always(closing -> distance < speed)", []),
        ("always(closing -> distance + 1 < 3)", []),
        ("always(closing -> count(closing) < 2)", []),
        ("always(closing -> speed < 1 / 0)", []),
    ],
)
def test_a_number_that_is_compared_with_a_single_name_is_a_limit(text: str, drawn: list[Limit]) -> None:
    assert list(limits(parse_formula(text, VOCABULARY))) == drawn
