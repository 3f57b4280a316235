"""The line below the dots: its text, and that it leaves nothing behind."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.report.line import width
from pytest_hricdv.report.live import Below, Standing, left, line, still
from tests.report.screen import Screen


@pytest.mark.parametrize(
    ("standing", "shown"),
    [
        (Standing(0, 134, 0, None, ()), "hri: 0 of 134"),
        (Standing(37, 134, 0, 41.2, ("rl-a",)), "hri: 37 of 134, about 40 s left: rl-a"),
        (Standing(37, 134, 2, 41.2, ("rl-a", "rl-b")), "hri: 37 of 134, 2 failed, about 40 s left: rl-a, rl-b"),
        (Standing(3, 4, 0, 1.0, ("rl-" + "a" * 50, "rl-b")), f"hri: 3 of 4, a few seconds left: rl-{'a' * 40}..."),
        (Standing(3, 4, 0, 1.0, ("rl-" + "a" * 30, "rl-" + "b" * 30)), None),
    ],
)
def test_it_says_how_far_how_long_and_what(standing: Standing, shown: str | None) -> None:
    assert line(standing, 79) == (shown or f"hri: 3 of 4, a few seconds left: rl-{'a' * 30} and 1 more")


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [
        (0.0, "a few seconds left"),
        (12.4, "about 10 s left"),
        (89.0, "about 90 s left"),
        (91.0, "about 2 min left"),
        (3599.0, "about 60 min left"),
        (7805.0, "about 2 h 10 min left"),
    ],
)
def test_time_left_is_as_exact_as_a_guess(seconds: float, shown: str) -> None:
    assert left(seconds) == shown


@pytest.mark.parametrize(
    ("left_s", "waiting_s", "passed_s", "now_s"),
    [(40.0, 30.0, 4.0, 36.0), (40.0, 30.0, 15.0, 30.0), (5.0, 0.0, 60.0, 0.0)],
    ids=["counts down", "what waits takes its time", "later than guessed"],
)
def test_time_left_goes_down_while_nothing_happens(
    left_s: float, waiting_s: float, passed_s: float, now_s: float
) -> None:
    assert still(left_s, waiting_s, passed_s) == now_s


@given(
    st.builds(
        Standing,
        st.integers(0, 9999),
        st.integers(0, 9999),
        st.integers(0, 99),
        st.floats(0, 1e6),
        st.tuples(st.text(max_size=30), st.text(max_size=30)),
    ),
    st.integers(1, 200),
)
def test_it_fits_whatever_the_names(standing: Standing, columns: int) -> None:
    text = line(standing, columns)
    assert width(text) <= columns
    assert "\x1b" not in text
    assert "\n" not in text


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("write"), st.sampled_from([".", "F", "\n", "FAILED x\n", "gw0 crashed\n"])),
            st.tuples(st.just("show"), st.sampled_from(["hri: 1", "hri: 22 of 3"])),
        ),
        max_size=60,
    ),
    st.integers(3, 8),
)
def test_what_others_write_looks_as_if_the_line_was_never_there(steps: list[tuple[str, str]], rows: int) -> None:
    file, plain = io.StringIO(), Screen()
    below = Below(file, file, lambda: len(written.rpartition("\n")[2]))
    written = ""
    for step, text in steps:
        if step == "show":
            below.show(text)
            shown = Screen(rows)
            shown.feed(file.getvalue())
            assert shown.lines[-1] == text
            continue
        below.write(text)
        written += text
    below.clear()
    plain.feed(written)
    shown = Screen(rows)
    shown.feed(file.getvalue())
    assert shown.lines == plain.lines
