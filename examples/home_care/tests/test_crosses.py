"""The bins that a run hits, from its messages."""

from __future__ import annotations

from crosses import CROSS, Served, bins, served

from pytest_hricdv.runtime import RecordedMessage

Said = tuple[float, str, str]


def messages(*said: Said) -> list[RecordedMessage]:
    """Messages with their time (s), topic, and order."""
    return [
        RecordedMessage(time_s, "test", topic, {"kind" if topic == "order" else "order": order, "reason": "none"})
        for time_s, topic, order in said
    ]


def test_orders_end_in_the_order_in_which_they_were_accepted() -> None:
    run = messages(
        (5.0, "order", "feed"),
        (5.0, "accepted", "feed"),
        (9.0, "order", "clean"),
        (9.0, "accepted", "clean"),
        (12.0, "order", "chase"),
        (12.0, "refused", "chase"),
        (60.0, "completed", "feed"),
        (200.0, "refused", "clean"),
        (210.0, "order", "ended"),
        (210.0, "accepted", "ended"),
    )
    assert served(run) == (
        Served("feed", 5.0, "completed", 60.0),
        Served("clean", 9.0, "given up", 200.0),
        Served("chase", 12.0, "refused", 12.0),
    )
    assert bins(run, dog_met_s=[70.0]) == {
        "orders": [("feed", "clean", "meanwhile", "away"), ("clean", "unknown", "meanwhile", "met")],
        "ends": [("feed", "completed"), ("clean", "given up"), ("unknown", "refused")],
    }


def test_what_is_still_open_at_the_end_hits_nothing() -> None:
    run = messages((5.0, "order", "sink"), (5.0, "accepted", "sink"))
    assert bins(run, []) == {"orders": [], "ends": []}


def test_an_order_that_is_refused_as_there_are_too_many_opens_no_pair() -> None:
    run = messages((5.0, "order", "sink"), (5.0, "refused", "sink"))
    assert bins(run, []) == {"orders": [], "ends": [("sink", "refused")]}


def test_all_bins_are_declared() -> None:
    run = messages((5.0, "order", "sink"), (5.0, "accepted", "sink"), (50.0, "completed", "sink"))
    for name, hits in bins(run, [10.0]).items():
        axes = list(CROSS[name].coordinates.values())
        assert all(value in axis for hit in hits for value, axis in zip(hit, axes, strict=True))
