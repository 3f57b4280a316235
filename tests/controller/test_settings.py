"""Settings say what they expect."""

from __future__ import annotations

import math
from dataclasses import fields

import pytest

from controller.settings import Settings


@pytest.mark.parametrize("name", [field.name for field in fields(Settings)])
@pytest.mark.parametrize("value", [0, -1, math.nan, math.inf])
def test_a_number_that_is_not_above_0_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name} is .*: expected a number above 0"):
        Settings(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["turns", "receive_polls", "close_attempts"])
def test_a_count_is_a_whole_number(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is 2.5: expected a whole number"):
        Settings(**{name: 2.5})  # type: ignore[arg-type]


def test_the_arm_moves_within_restricted_speed_as_it_is_delivered() -> None:
    assert Settings().max_speed_rad_s <= 0.25
