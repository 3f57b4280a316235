"""What the requirements accept and refuse, on messages made up."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pytest
from carebot.messages import SAID, Order
from carebot.orders import FULL, LATE, UNKNOWN
from house import house
from observer import SIGNALS
from people.dog import DogCalled

from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, load_requirements

Message = tuple[float, str, str]
"""When (s), its topic, and which order."""


@cache
def requirement(name: str) -> Requirement:
    kinds = {"str": str, "bool": bool}
    messages = {
        kind.__name__.lower(): {field: kinds[str(held)] for field, held in kind.__annotations__.items()}
        for kind in (Order, *SAID, DogCalled)
    }
    vocabulary = Vocabulary(signals={**house.SIGNALS, **SIGNALS}, messages=messages, units=house.UNITS)
    held = load_requirements(Path(__file__).with_name("requirements.toml"), vocabulary)
    return next(asked for asked in held if asked.id == name)


def verdict(name: str, messages: Sequence[Message], ends_s: float, reason: str = LATE) -> str:
    monitors = MonitorSet([requirement(name)])
    for time_s, topic, order in sorted(messages):
        fields = {"order": order} | ({"reason": reason} if topic == "refused" else {})
        monitors.message(time_s, topic, fields)
    (judged,) = monitors.finish(ends_s)
    return judged.verdict


def orders(count: int, every_s: float, lasts_s: float, end: str = "completed") -> list[Message]:
    starts = [10.0 + number * every_s for number in range(count)]
    return [*((at, "accepted", "sink") for at in starts), *((at + lasts_s, end, "sink") for at in starts)]


def test_n3_holds_though_there_always_is_an_open_order() -> None:
    assert verdict("N3", orders(10, every_s=200.0, lasts_s=300.0), 2300.0) == "Passed"


@pytest.mark.parametrize("end", ["completed", "refused"])
def test_n3_fails_where_an_order_is_late_however_it_ends(end: str) -> None:
    assert verdict("N3", orders(1, 0.0, 890.0, end), 1000.0) == "Passed"
    assert verdict("N3", orders(1, 0.0, 910.0, end), 1000.0) == "Failed"


def test_n3_fails_where_one_of_many_is_forgotten() -> None:
    assert verdict("N3", [(5.0, "accepted", "feed"), *orders(6, 200.0, 100.0)], 2000.0) == "Failed"


def test_n3_does_not_count_the_end_of_orders_nor_those_that_are_refused_at_once() -> None:
    ended = [(5.0, "accepted", "ended")]
    assert verdict("N3", [*ended, *orders(2, 100.0, 50.0)], 1200.0) == "Passed"
    for reason in (UNKNOWN, FULL):
        assert verdict("N3", [*orders(1, 0.0, 950.0), (20.0, "refused", "chase")], 1200.0, reason) == "Failed"
