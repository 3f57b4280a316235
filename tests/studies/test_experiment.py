"""The page of the experiment says what its figures say, and its pictures are the same bytes for the same figures."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from studies import page, plots, session
from studies.experiment import __main__ as experiment
from studies.experiment import charts
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


def test_what_does_not_hold_is_said() -> None:
    unchecked = rendered(report(rl=[entry("rl", 70.0, R2="NC")], pseudorandom=[entry("pseudorandom", 90.0)]))
    assert held(unchecked) == ["**no**"] * 4


def test_reasons_are_given_only_for_what_is_there() -> None:
    all_moving = rendered(report())
    assert "**R3 and R4, NC.**" not in all_moving
    assert "Failures of what is not known to fail" not in all_moving
    assert "so this\n  seed" not in all_moving
    resting = [entry("pseudorandom", 60.0, R4="NC", abstract=["bored"], outcomes=[])]
    text = rendered(report(pseudorandom=resting))
    assert "**R3 and R4, NC.** 1 tests of pseudorandom never move" in text
    assert "1 of 1 tests never ask for a leg" in text


@pytest.mark.parametrize(("grip_s", "said"), [(9.0, "grips the fingers with the leg for 9.0 s"), (0.0, "`rl-0`\n")])
def test_a_slow_release_is_put_down_to_a_grip_only_where_there_is_one(grip_s: float, said: str) -> None:
    text = rendered(report(rl=[entry("rl", grip_s=grip_s, R1="Failed", outcome="failed")]))
    assert "- R1 in `rl-0`" in text
    assert said in text


def test_learning_that_did_not_converge_is_said() -> None:
    assert "it did not converge" in rendered(report(learned={"converged_at": None}))
    assert "from iteration 2 on" in rendered(report())


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


def test_axes_have_names_units_and_legends() -> None:
    found = methods(report())
    for made in (charts.coverage(found), charts.growth(found), charts.learning(found["rl"]), charts.time(found, 2)):
        for axes in made.axes:
            assert axes.get_xlabel()
        assert made.axes[0].get_ylabel() or made.axes[0].get_yticklabels()
    legend = charts.coverage(found).axes[0].get_legend()
    assert legend is not None
    assert len(legend.get_texts()) == 4
    assert len({colour for colour, _, _ in plots.STYLES}) == len(plots.STYLES) >= len(METHODS)


def test_a_missing_report_and_a_report_of_other_suites_are_refused(tmp_path: Path) -> None:
    with pytest.raises(session.SessionError, match="leave out --again"):
        session.read(tmp_path)
    with pytest.raises(session.SessionError, match="without bdi-random, by-hand, pseudorandom"):
        experiment.checked({"suites": [{"name": "rl"}]})


def test_a_test_that_did_not_end_is_listed_and_counts_for_nothing_else() -> None:
    broken = entry("rl", code=None, outcome="error", id="rl-1")
    text = rendered(report(rl=[entry("rl"), broken]))
    assert "- an error in `rl-1`" in text
    assert "85.0 (85.0 to 85.0) %" in text


def test_a_report_without_measured_code_is_refused_with_the_reason() -> None:
    given = report()
    given["suites"][0]["code"] = {"statements": None, "branches": None}
    given["code_under_test"] = {"reason": "switched off"}
    with pytest.raises(session.SessionError, match=r"suite by-hand: .* not measured: switched off"):
        experiment.checked(given)


def test_a_table_has_rows_as_wide_as_its_head() -> None:
    assert page.table(["", "a"], [["x", 1]]) == "|  | a |\n| --- | --- |\n| x | 1 |"
    with pytest.raises(ValueError, match="2 columns"):
        page.table(["", "a"], [["x"]])


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.84, "0.8 s"), (51.2, "51 s"), (204, "3.4 min"), (3600, "1.0 h"), (13800, "3.8 h")]
)
def test_durations_are_shown_in_a_fitting_unit(seconds: float, said: str) -> None:
    assert page.duration(seconds) == said
