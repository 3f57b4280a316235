"""Sessions of a study are run where their reports are missing, or not of the present code."""

from __future__ import annotations

import argparse
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


def test_code_that_changes_while_a_session_runs_is_an_error_and_its_report_is_not_kept(
    tmp_path: Path, ran: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    versions = iter("ABBB")
    monkeypatch.setattr(grid, "depends", lambda _: {"controller/a.py": next(versions)})
    with pytest.raises(session.SessionError, match="rl at seed 3: code was changed while it ran"):
        found(tmp_path, CELLS[:1])
    assert found(tmp_path, CELLS[:1], again=True) == [False]


def test_a_report_that_is_not_complete_after_a_run_is_an_error(tmp_path: Path, ran: list[str]) -> None:
    def complete(report: Report) -> bool:
        return report.shard != ""

    with pytest.raises(session.SessionError, match="did not come to its end"):
        list(grid.reports(CELLS[:1], tmp_path, again=False, complete=complete))
    write(replace(sample.typed(sample.data(("rl",), 1)), shard="1/2"), tmp_path / "rl-3")
    assert [report is None for _, report in grid.reports(CELLS[:1], tmp_path, again=True, complete=complete)] == [False]


@pytest.mark.parametrize(
    ("text", "seeds"), [("3", (3,)), ("0-2", (0, 1, 2)), ("4,0-1,1-2", (4, 0, 1, 2)), ("12-12", (12,))]
)
def test_seeds_are_numbers_and_ranges(text: str, seeds: tuple[int, ...]) -> None:
    parser = argparse.ArgumentParser()
    grid.add_options(parser, seeds="0-9")
    assert parser.parse_args([f"--seeds={text}"]).seeds == seeds


@pytest.mark.parametrize("option", ["--seeds=", "--seeds=2-1", "--seeds=-1", "--seeds=a", "--suites=rl,learned"])
def test_what_is_no_seed_and_no_suite_is_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    parser = argparse.ArgumentParser()
    grid.add_options(parser, seeds="0-9")
    with pytest.raises(SystemExit):
        parser.parse_args([option])
    assert "expected" in capsys.readouterr().err
