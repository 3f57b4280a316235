"""Sessions of a study are run where their reports are missing, or not of the present code."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from pytest_hricdv.report.files import write
from pytest_hricdv.results.model import Report
from studies import grid, session
from tests.report import sample

CELLS = grid.cells(("rl", "by-hand"), (3,), ("--hri-no-cov",))


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What sessions were run, of code that is `code`."""
    commands: list[str] = []

    def run(folder: Path, arguments: list[str]) -> None:
        commands.append(" ".join(arguments))
        write(sample.typed(sample.data(("rl",), 1)), folder)

    monkeypatch.setattr(session, "run", run)
    monkeypatch.setattr(grid, "depends", lambda _: {"controller/a.py": "1"})
    return commands


def found(folder: Path, cells: list[grid.Cell], *, again: bool = False) -> list[bool]:
    return [report is not None for _, report in grid.reports(cells, folder, again=again)]


def test_sessions_that_are_there_are_not_run_again(tmp_path: Path, ran: list[str]) -> None:
    assert found(tmp_path, CELLS[:1]) == [True]
    assert found(tmp_path, CELLS) == [True, True]
    assert ran == [
        "--hri-suite=rl --hri-seed=3 --hri-no-cov -n 2",
        "--hri-suite=by-hand --hri-seed=3 --hri-no-cov -n 2",
    ]
    assert found(tmp_path, CELLS, again=True) == [True, True]


@pytest.mark.parametrize("change", ["code", "options", "no report"])
def test_a_report_of_something_else_is_not_taken(
    tmp_path: Path, ran: list[str], monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    cells = CELLS[:1]
    found(tmp_path, cells)
    if change == "code":
        monkeypatch.setattr(grid, "depends", lambda _: {"controller/a.py": "2"})
    elif change == "options":
        cells = grid.cells(("rl",), (3,))
    else:
        (tmp_path / "rl-3" / "report.json").unlink()
    assert found(tmp_path, cells, again=True) == [False]
    assert found(tmp_path, cells) == [True]
    assert len(ran) == 2


def test_a_report_that_is_not_complete_after_a_run_is_an_error(tmp_path: Path, ran: list[str]) -> None:
    def complete(report: Report) -> bool:
        return report.shard != ""

    with pytest.raises(session.SessionError, match="did not come to its end"):
        list(grid.reports(CELLS[:1], tmp_path, again=False, complete=complete))
    write(replace(sample.typed(sample.data(("rl",), 1)), shard="1/2"), tmp_path / "rl-3")
    assert [report is None for _, report in grid.reports(CELLS[:1], tmp_path, again=True, complete=complete)] == [False]
