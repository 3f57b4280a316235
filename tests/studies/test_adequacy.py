"""The page on seeded faults is made of the sessions that are there, and says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.mutation.records import MUTATION
from pytest_hricdv.report.files import write
from pytest_hricdv.results.model import Report
from studies import session
from studies.adequacy import __main__ as adequacy
from studies.adequacy.tables import Done, never_killed, together
from studies.grid import cells
from tests.report import sample, sample_sections


def _report(suite: str, seed: int, killed: str = "00000000") -> Report:
    """A report whose mutants are done; `killed` is the id of the one that its suite kills."""
    report = sample.typed(
        sample.data((suite,), 2) | {"mutation": sample_sections.MUTATION | {"seed": seed, "end_reason": "done"}}
    )
    result = MUTATION.of(report)
    assert result is not None
    mutants = [
        replace(each, status="killed" if each.id == killed else "survived" if each.status == "killed" else each.status)
        for each in result.mutants
    ]
    return replace(report, mutation=replace(result, mutants=tuple(mutants), tests_per_mutant=10))


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """What sessions were run."""
    commands: list[list[str]] = []

    def run(folder: Path, arguments: list[str]) -> None:
        commands.append(arguments)
        suite, seed = (argument.partition("=")[2] for argument in arguments[:2])
        write(_report(suite, int(seed)), folder)

    monkeypatch.setattr(session, "run", run)
    return commands


CELLS = cells(("rl", "by-hand"), (3,), ("--hri-mutate",))


def test_the_page_is_of_what_there_is_and_the_command_says_what_is_not(
    tmp_path: Path, ran: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    adequacy.run(CELLS[:1], tmp_path / "reports", tmp_path, again=False)
    adequacy.run(CELLS, tmp_path / "reports", tmp_path, again=True)
    assert "of 1 sessions, without by-hand at seed 3" in capsys.readouterr().out
    assert ran == [["--hri-suite=rl", "--hri-seed=3", "--hri-mutate", "-n", "2"]]
    page = (tmp_path / "studies" / "adequacy.md").read_text(encoding="utf-8")
    assert "of 1 sessions" in page
    assert "| rl | 1 | 4 |" in page
    assert "by-hand" not in page


def test_what_any_suite_kills_and_what_only_one_kills_is_told_apart() -> None:
    done = [Done("rl", 0, _report("rl", 0)), Done("by-hand", 0, _report("by-hand", 0, killed="00000001"))]
    assert together(done).splitlines()[-1] == "| 0 | 40.0 % | 2 | rl 1, by-hand 1 |"
    alive = never_killed([each.mutation for each in done])
    assert [(each.line, each.status) for each in alive] == [
        (14, "unchanged"),
        (15, "no coverage"),
        (16, "not run"),
    ]
