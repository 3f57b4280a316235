"""The page of the experiment says what its figures say, and its pictures are the same bytes for the same figures."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from studies import page, session
from studies.experiment import __main__ as experiment
from studies.experiment.comparison import methods
from studies.original.published import METHODS
from tests.hri.bench import leg

VERDICTS = {"R1": "Passed", "R2": "Passed", "R3": "Passed", "R4": "Passed"}


def entry(suite: str, percent: float = 85.0, grip_s: float = 0.0, **more: Any) -> dict[str, Any]:
    """A test of a report."""
    verdicts = VERDICTS | {name: more.pop(name) for name in list(more) if name in VERDICTS}
    return {
        "id": f"{suite}-0",
        "suite": suite,
        "abstract": leg(),
        "concrete": {"actions": [{"command": "set_param pressure = 1", "parameters": {"grip_s": grip_s}}]},
        "requirements": {name: {"verdict": verdict} for name, verdict in verdicts.items()},
        "outcomes": ["released"],
        "code": {"percent": percent},
        "outcome": "passed",
        "wall_s": 2.0,
        **more,
    }


def suite(name: str, tests: list[dict[str, Any]], **learned: Any) -> dict[str, Any]:
    """A suite of a report."""

    def count(requirement: str, verdict: str) -> int:
        return sum(test["requirements"][requirement]["verdict"] == verdict for test in tests)

    plans = {"human": {"covered": ["a"], "total": 48}, "robot_code": {"covered": ["p1"], "total": 12}}
    closure = {"covered": 9, "total": 12, "reachable": 10, "percent_reachable": 90.0}
    generation = {"wall_s": 1.5, "bdi_runs": 20, "iterations": 3, "converged_at": 2, "q_delta": [9.0, 1.0, 0.0]}
    return {
        "name": name,
        "seed": 0,
        "tests": len(tests),
        "generation": {**generation, "distinct_texts": 1, **learned},
        "requirements": {
            each: dict(
                zip(("passed", "failed", "nc"), (count(each, v) for v in ("Passed", "Failed", "NC")), strict=True)
            )
            for each in VERDICTS
        },
        "code": {"statements": closure, "branches": closure},
        "plans": {} if name == "pseudorandom" else plans,
        "cross": {"products": {"decision": {"bins": 8, "hit": 3, "impossible": 2, "illegal": 1}}},
        "curve": [{"tests": 1, "statements": 9, "branches": 5, "plans": 2}],
    }


def report(**tests: Any) -> dict[str, Any]:
    """A report of the four suites; `by_hand=...` and so on set a suite's tests."""
    learned = tests.pop("learned", {})
    found = {name: tests.get(name.replace("-", "_"), [entry(name)]) for name in METHODS}
    found["pseudorandom"] = tests.get("pseudorandom", [entry("pseudorandom", 60.0)])
    return {
        "reported": sum(map(len, found.values())),
        "wall_s": 100.0,
        "workers": 2,
        "version": "0.1.0",
        "code_under_test": {"sha256": "c0de"},
        "known_violations": {"R3": "no crush prevention"},
        "requirements": {name: {"title": f"title of {name}"} for name in VERDICTS},
        "suites": [suite(name, found[name], **(learned if name == "rl" else {})) for name in METHODS],
        "tests": [test for name in METHODS for test in found[name]],
    }


def rendered(given: dict[str, Any]) -> str:
    """The page."""
    return page.render("experiment/experiment.md.jinja", experiment.context(given, methods(given)))


def held(text: str) -> list[str]:
    """The answers of the table of what is to hold."""
    section = text.partition("## Is the learned suite")[2].partition("##")[0]
    return re.findall(r"\| (yes|\*\*no\*\*) \|", section)


def test_published_and_own_figures_stand_side_by_side() -> None:
    text = rendered(report(by_hand=[entry("by-hand", R1="Failed"), entry("by-hand", R1="NC"), entry("by-hand")]))
    assert "| R1 | 90 / 1 / 47 | 1 / 1 / 1 | 7 / 0 / 93 | 1 / 0 / 0 |" in text
    assert "R3: title of R3. Known to fail: no crush prevention." in text
    assert "Plugin 0.1.0; the code under test has the SHA-256 `c0de`." in text
    assert held(text) == ["yes"] * 4
    assert "| bins of the cross product `decision` | 3 of 5 | 3 of 5 |" in text


@pytest.mark.slow
def test_pictures_are_the_same_bytes_and_bear_no_date(tmp_path: Path) -> None:
    for name in ("a", "b"):
        experiment.write(report(), tmp_path / name)
    made = sorted((tmp_path / "a" / "pictures").iterdir())
    assert [path.name for path in made] == [f"experiment-{n}.svg" for n in ("coverage", "growth", "learning", "time")]
    for path in made:
        text = path.read_text(encoding="utf-8")
        assert text == (tmp_path / "b" / "pictures" / path.name).read_text(encoding="utf-8")
        assert "<dc:date>" not in text
    assert (tmp_path / "a" / "studies" / "experiment.md").read_text(encoding="utf-8") == rendered(report())


def test_a_missing_report_and_a_report_of_other_suites_are_refused(tmp_path: Path) -> None:
    with pytest.raises(session.SessionError, match="leave out --again"):
        session.read(tmp_path)
    with pytest.raises(session.SessionError, match="without bdi-random, by-hand, pseudorandom"):
        experiment.checked({"suites": [{"name": "rl"}]})
