"""The line that says how far a campaign is: as wide as the terminal, and no wider."""

from __future__ import annotations

import io
from typing import Any

import pytest

from pytest_hricdv.extra.campaign import progress
from pytest_hricdv.extra.campaign.store import Counts
from tests.plugin.screen import Screen


class Stored:
    """As much of a store as progress reads."""

    def __init__(self) -> None:
        self.runs = 0

    def counts(self) -> Counts:
        failed = self.runs // 10
        return Counts({"passed": self.runs - failed, "failed": failed}, 40.0 * self.runs, 1.0, 0, 0)


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def line(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The only line on a terminal, after so many runs."""

    def run(*runs: int, columns: int) -> str:
        monkeypatch.setenv("COLUMNS", str(columns))
        monkeypatch.setattr(progress, "EVERY_S", 0.0)
        store: Any = Stored()
        stream = Terminal()
        shown = progress.CampaignProgress(store, 1_000_000, stream)
        for done in runs:
            store.runs = done
            shown.show()
        screen = Screen(rows=8, columns=columns)
        screen.feed(stream.getvalue())
        (text,) = filter(None, screen.lines)
        return text

    return run


def test_it_says_how_many_runs_ended_how_fast_and_the_time_left(line: Any) -> None:
    parts = line(5, 250_000, columns=120).split(", ")
    assert parts[:3] == ["250,000 of 1,000,000 runs", "25,000 failed", "0 lost"]
    assert parts[3].endswith(" simulated s a second")
    assert parts[4].endswith(" left")


@pytest.mark.parametrize(
    ("columns", "shown"),
    [
        (80, "250,000 of 1,000,000 runs, 25,000 failed, 0 lost, a few seconds left"),
        (60, "250,000 of 1,000,000 runs, 25,000 failed, 0 lost"),
        (40, "250,000 of 1,000,000 runs"),
    ],
)
def test_on_a_narrow_terminal_it_says_less_and_leaves_no_rest(line: Any, columns: int, shown: str) -> None:
    assert line(5, 100_000, 250_000, columns=columns) == shown
