"""The page on the closing loop: what sessions reached by when, and what loops without a strategy reached."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.report.files import write
from studies import session
from studies.closure import __main__ as closure
from studies.closure.growth import Growth, Step, of_loop, of_suite
from studies.closure.tables import curves, horizon_s, reached
from tests.report import sample, sample_sections

STATES = "controller/states.py"
LINES: tuple[Point, ...] = tuple(("statement", STATES, str(line)) for line in range(1, 5))
BIN: Point = ("bin", "handover", "001", "1")


def _closing(**changes: Any) -> dict[str, Any]:
    """A loop of 3 runs of 10 s: the first hits two lines, the third one more and a bin; one line stays open."""
    hits = [(LINES[0], 1), (LINES[1], 1), (LINES[2], 3), (BIN, 3)]
    changed = {
        "runs": 3,
        "sim_s": 30.0,
        "hit": [{"point": [*point], "test": "x", "strategy": "model", "run": run} for point, run in hits],
        "growth": [{"run": run, "sim_s": 10.0 * run, "strategy": "model", "new": {"statement": 1}} for run in (1, 3)],
        "open": [{"point": [*LINES[3]], "tries": 7, "lacking": "line 3 has to continue to it"}],
    }
    return sample_sections.CLOSING | changed | changes


def _loop(series: str = "closure", seed: int = 0, **changes: Any) -> Growth:
    return of_loop(series, seed, sample.typed(sample.data(("closure",), 1) | {"closing": _closing(**changes)}))


def _suite(seed: int = 0, *steps: Step, sim_s: float = 40.0) -> Growth:
    return Growth("rl", seed, steps, 4, sim_s)


WANTED = {*LINES, BIN}


def test_a_suite_has_every_point_once_and_its_order_depends_on_its_seed_only() -> None:
    report = sample.report(("rl",), 6)
    growth = of_suite("rl", 0, report)
    points = [point for step in growth.steps for point in step.points]
    assert len(points) == len(set(points))
    statements = sum(point[0] == "statement" for point in points)
    union = 0
    for test in report.tests:
        assert test.code is not None
        union |= int(test.code.bits[0], 16)
    assert statements == union.bit_count()
    assert {point[0] for point in points} == {"statement", "branch", "plan", "bin", "verdict"}
    assert growth.sim_s == pytest.approx(sum(test.sim_s for test in report.tests))
    assert growth == of_suite("rl", 0, report)
    assert [step.sim_s for step in growth.steps] != [step.sim_s for step in of_suite("rl", 1, report).steps]


def test_suites_are_compared_over_the_simulated_time_that_all_have() -> None:
    sessions = [_loop(), _suite(0, Step(1, 5.0, LINES[:1]), Step(4, 40.0, (*LINES[1:3], ("plan", "a", "not wanted"))))]
    assert horizon_s(sessions) == 30.0
    by_series = {"closure": sessions[:1], "rl": sessions[1:]}
    by_time = reached(by_series, WANTED, sim_s=30.0).splitlines()
    assert by_time[0] == "| suite | bins of 1 | statements of 4 | all of 5 |"
    assert by_time[-1].startswith("| rl | 0.0 (one seed) | 1.0 (one seed)")
    assert "| 3.0 (one seed) |" in reached(by_series, WANTED, runs=4).splitlines()[-1]
    assert "| 1.0 (one seed) |" in reached(by_series, WANTED, runs=3).splitlines()[-1]
    ends = {name: points[-1] for name, points in curves(sessions).items()}
    assert ends == {"closure": (30.0, 80.0), "rl": (30.0, 20.0)}


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """What sessions were run."""
    commands: list[list[str]] = []

    def run(folder: Path, arguments: list[str]) -> None:
        commands.append(arguments)
        suite = arguments[0].partition("=")[2]
        closing = {"closing": _closing()} if suite == "closure" else {}
        write(sample.typed(sample.data((suite,), 2) | closing), folder)

    monkeypatch.setattr(session, "run", run)
    return commands


@pytest.mark.slow
def test_the_page_and_its_picture_are_of_what_there_is(
    tmp_path: Path, ran: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    cells = closure.sessions(("closure", "rl"), ("online",), (3,), 48)
    closure.run(cells[:2], tmp_path / "reports", tmp_path, again=False)
    closure.run(cells, tmp_path / "reports", tmp_path, again=True)
    assert "of 2 sessions; missing: without online at seed 3" in capsys.readouterr().out
    closure.run(cells, tmp_path / "reports", tmp_path, again=False)
    assert [" ".join(each) for each in ran] == [
        "--hri-suite=closure --hri-seed=3 --hri-close-runs=48 --hri-close-seconds=86400 --hri-close-search=0 -n 2",
        "--hri-suite=rl --hri-seed=3 --hri-tests=96 -n 2",
        "--hri-suite=closure --hri-seed=3 --hri-close-runs=48 --hri-close-seconds=86400 "
        "--hri-close-search=0 --hri-close-without=online -n 2",
    ]
    page = (tmp_path / "studies" / "closure.md").read_text(encoding="utf-8")
    assert "| without online | 0 of 1 |" in page
    assert (tmp_path / "pictures" / "closure.svg").is_file()


def test_without_a_whole_loop_there_is_no_page(tmp_path: Path, ran: list[list[str]]) -> None:
    cells = closure.sessions(("rl",), (), (3,), 48)
    with pytest.raises(session.SessionError, match="no session of closure is complete"):
        closure.run(cells[1:], tmp_path / "reports", tmp_path, again=False)
