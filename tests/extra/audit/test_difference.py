"""The first event at which two runs differ."""

from __future__ import annotations

from typing import Any

import msgspec

from pytest_hricdv.extra.audit.auditor import NOTHING, first_difference
from pytest_hricdv.results.model import TestResult, Timeline
from tests.report import sample

MESSAGES = ('1.5\tguide\tswitched\t{"level":3.0}', "2\tguide\tanswer\t{}")


def run(messages: tuple[str, ...] = MESSAGES, **changes: Any) -> TestResult:
    model = msgspec.convert(sample.data(tests=1)["tests"][0], TestResult)
    timeline = Timeline(
        end_s=9.0,
        messages=messages,
        signals=changes.pop("signals", {"height": "0 0.5 3 0.7"}),
        triggers={},
        checksums=changes.pop("checksums", {}),
        texts=changes.pop("texts", {}),
    )
    return msgspec.structs.replace(model, timeline=timeline, **changes)


def test_equal_runs_have_none() -> None:
    assert first_difference(run(), run()) == ("", "")


def test_it_is_the_first_in_time_of_messages_signals_and_texts() -> None:
    other = run((MESSAGES[0], '2\tguide\tanswer\t{"to":1}'), signals={"height": "0 0.5 3 0.8"})
    assert first_difference(run(), other) == ("2 s: guide answer {}", '2 s: guide answer {"to":1}')
    assert first_difference(run(), run(signals={"height": "0 0.4 3 0.7"})) == ("0 s: height = 0.5", "0 s: height = 0.4")


def test_an_event_that_is_missing_shows_the_next_one() -> None:
    assert first_difference(run(), run(MESSAGES[:1])) == ("2 s: guide answer {}", "3 s: height = 0.7")
    assert first_difference(run(), run((*MESSAGES, "9\tguide\tgone\t{}")))[0] == "9 s: end of the run"


def test_what_a_timeline_rounds_is_named() -> None:
    here, there = first_difference(run(checksums={"height": "1"}), run(checksums={"height": "2"}))
    assert here == there == "height differs in digits or instants that a timeline has not"


def test_a_run_that_came_to_no_end_says_why() -> None:
    broken = msgspec.structs.replace(run(), timeline=None, failure="x\nE   KeyError: 'lamp'\n")
    assert first_difference(run(), broken) == ("a run of 9 s", "no run: KeyError: 'lamp'")
    assert first_difference(run(), None)[1] == "no result"
    assert NOTHING
