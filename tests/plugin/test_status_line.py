"""The status line: its text, and that it leaves nothing on the terminal."""

from __future__ import annotations

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.report.formatting import width
from pytest_hricdv.session.progress import Status, StatusLine
from tests.plugin.screen import Screen


@pytest.mark.parametrize(
    ("status", "shown"),
    [
        (Status(0, 134, 0, None, ()), "hri: 0 of 134"),
        (Status(37, 134, 0, 41.2, ("rl-a",)), "hri: 37 of 134, about 40 s left: rl-a"),
        (Status(37, 134, 2, 41.2, ("rl-a", "rl-b")), "hri: 37 of 134, 2 failed, about 40 s left: rl-a, rl-b"),
        (Status(3, 4, 0, 1.0, ("rl-" + "a" * 50, "rl-b")), "hri: 3 of 4, a few seconds left"),
        (
            Status(3, 4, 0, 1.0, ("rl-" + "a" * 30, "rl-" + "b" * 30)),
            f"hri: 3 of 4, a few seconds left: rl-{'a' * 30} and 1 more",
        ),
    ],
)
def test_it_says_how_many_tests_ended_the_time_left_and_what_runs(status: Status, shown: str) -> None:
    assert status.text(79) == shown


@given(
    st.builds(
        Status,
        st.integers(0, 9999),
        st.integers(0, 9999),
        st.integers(0, 99),
        st.floats(0, 1e6),
        st.tuples(st.text(max_size=30), st.text(max_size=30)),
    ),
    st.integers(1, 200),
)
def test_it_fits_whatever_the_names(status: Status, columns: int) -> None:
    text = status.text(columns)
    assert width(text) <= columns
    assert "\x1b" not in text
    assert "\n" not in text


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("write"), st.sampled_from([".", "F", "\n", "FAILED x\n", "gw0 crashed\n"])),
            st.tuples(st.just("draw"), st.sampled_from(["hri: 1", "hri: 22 of 3"])),
        ),
        max_size=60,
    ),
    st.integers(3, 8),
)
def test_what_is_written_looks_as_if_the_line_was_never_there(steps: list[tuple[str, str]], rows: int) -> None:
    shown, plain = Screen(rows), Screen()
    reading, writing = os.pipe()
    line = StatusLine(writing, "utf-8")
    for step, text in steps:
        if step == "draw":
            line.draw(text)
            shown.feed(os.read(reading, 4096).decode())
            assert shown.lines[-1] == text
            continue
        line.erase()
        shown.feed(os.read(reading, 4096).decode() + text)
        plain.feed(text)
    line.erase()
    shown.feed(os.read(reading, 4096).decode())
    line.close()
    os.close(reading)
    assert shown.lines == plain.lines
