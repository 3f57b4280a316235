"""What a closing loop tells while it runs: one line of a terminal, or a line for each tenth of a log."""

from __future__ import annotations

import io
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.progress import ClosingProgress
from pytest_hricdv.session.collection import Collection
from tests.plugin.screen import Screen


class Archived:
    """As much of an archive as progress reads: so many runs, and many kinds of open points."""

    def __init__(self, runs: int, kinds: int) -> None:
        self.entries = [SimpleNamespace(way="vary")] * runs
        self.open = [SimpleNamespace(kind=f"kind number {number}") for number in range(kinds)]
        self.sim_s = 12.0 * runs


@pytest.fixture
def shown(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Runs a loop's progress; returns what is written."""

    def run(*runs: tuple[int, int], columns: int, is_terminal: bool) -> str:
        monkeypatch.setenv("COLUMNS", str(columns))
        monkeypatch.setattr("pytest_hricdv.extra.closing.progress.by_kind", lambda points: {p.kind: 3 for p in points})
        config = request.config
        file = io.StringIO()
        reporter = type(config.pluginmanager.get_plugin("terminalreporter"))(config, file)
        reporter.isatty = is_terminal
        reporter._tw.fullwidth = columns
        manager = SimpleNamespace(get_plugin=lambda name: reporter)
        collection = Collection.__new__(Collection)
        collection.config = SimpleNamespace(pluginmanager=manager, get_verbosity=lambda: 0)  # type: ignore[assignment]
        collection._is_rewriting = False
        progress = ClosingProgress(collection, 100)
        archive: Any = Archive
        for done, kinds in runs:
            archive = Archived(done, kinds)
            progress.show(archive)
        progress.end(archive, "closed", (), 5, goes_on=True)
        return file.getvalue()

    return run


@pytest.mark.parametrize("columns", [40, 60, 80])
def test_a_line_of_the_terminal_leaves_no_rest(shown: Any, columns: int) -> None:
    screen = Screen(rows=24, columns=columns)
    screen.feed(shown((5, 9), (30, 4), (60, 1), columns=columns, is_terminal=True))
    text = " ".join(line.strip() for line in screen.lines if line)  # lines end between words
    assert text.startswith("hricdv: closing ended (closed) after 60 runs, 720 s simulated; open: ")
    assert "of 100 runs" not in text


def test_without_a_terminal_there_is_a_line_for_each_tenth(shown: Any) -> None:
    lines = shown(*((done, 2) for done in range(0, 101, 5)), columns=80, is_terminal=False).splitlines()
    assert [line.split()[1] for line in lines[:-1]] == [str(number) for number in range(10, 101, 10)]
