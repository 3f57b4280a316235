"""What a closing loop tells while it runs: one line of a terminal, or a line for each tenth of a log."""

from __future__ import annotations

import io
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.extra.closing.progress import ClosingProgress, progress_texts
from pytest_hricdv.extra.closing.strategy import Archive
from pytest_hricdv.report.formatting import fit_list
from pytest_hricdv.session.collection import Collection
from tests.plugin.screen import Screen


class Archived:
    """As much of an archive as progress reads: so many runs, and many kinds of open points."""

    def __init__(self, runs: int, kinds: int) -> None:
        self.entries = [SimpleNamespace(strategy="vary")] * runs
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
        plugin = config.pluginmanager.get_plugin("terminalreporter")
        assert plugin is not None
        reporter = type(plugin)(config, file)
        reporter.isatty = is_terminal
        reporter._tw.fullwidth = columns
        manager = SimpleNamespace(get_plugin=lambda name: reporter)
        collection = Collection.__new__(Collection)
        collection.config = SimpleNamespace(  # type: ignore[assignment]
            pluginmanager=manager, get_verbosity=lambda: 0, get_terminal_writer=lambda: reporter._tw
        )
        collection._is_rewriting = False
        progress = ClosingProgress(collection, 100, 2)
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


OPEN = {"statement": 12, "branch": 3, "verdict": 7, "condition": 21, "plan": 4, "shared bin": 58}


@pytest.mark.parametrize(
    ("columns", "shown"),
    [
        (200, ", 60 s simulated, open: 12 statements, 3 branches, 7 verdicts, 21 conditions, 4 plans, 58 shared bins"),
        (110, ", open: 12 statements, 3 branches, 7 verdicts, 21 conditions, 4 plans, 58 shared bins"),
        (80, ", open: 12 statements, 3 branches, 7 verdicts, 83 more"),
        (60, ", open: 12 statements, 93 more"),
        (50, ", open: 105"),
        (30, ""),
    ],
)
def test_on_a_narrow_terminal_it_says_less_and_cuts_nothing(columns: int, shown: str) -> None:
    texts = progress_texts(5, 100, 60.0, OPEN)
    assert fit_list(texts, columns - 1) == f"hricdv: 5 of 100 runs{shown}"
