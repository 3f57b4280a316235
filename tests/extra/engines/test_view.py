"""What the page says of two engines that check each other."""

from __future__ import annotations

from typing import Any

from pytest_hricdv.report import html
from tests.report import sample
from tests.report.parsed import Page


def _beside(test: dict[str, Any], verdict: str) -> dict[str, Any]:
    """A run on the second engine that differs in R3 where its verdict is another one."""
    requirements = {
        name: {"verdict": result["verdict"], "margin": result["margin"], "triggers": result["triggers"]}
        for name, result in test["requirements"].items()
    }
    differs = requirements["R3"]["verdict"] != verdict
    requirements["R3"]["verdict"] = verdict
    text = f"R3: {test['requirements']['R3']['verdict']} on pybullet, {verdict} on mujoco"
    return {
        "engine": "mujoco",
        "outcomes": test["outcomes"],
        "record_sha256": "0" * 64,
        "requirements": requirements,
        "errors": [],
        "differences": [{"what": "R3", "text": text, "tolerated": False}] if differs else [],
    }


def test_the_tests_that_depend_on_the_engine_come_first_and_the_summary_leads_to_them() -> None:
    report = sample.data(tests=3)
    for number, test in enumerate(report["tests"]):
        was = test["requirements"]["R3"]["verdict"]
        test["engine"] = "pybullet"
        test["cross_check"] = _beside(test, "NC" if number == 1 else was)
    page = Page(html.page(sample.typed(report))[0])
    words = " ".join(page.words.split())
    count = 3 * len(report["tests"][0]["requirements"])
    meaning = f"1 of 3 tests depends on the engine: pybullet and mujoco agree in {count - 1} of {count} verdicts"
    assert words.count(meaning) == 2  # in the summary, and in the view
    assert "Engines" in words
    assert (
        words.index(meaning)
        < words.index("Tests that depend on the engine 1 of 3")
        < words.index("Requirements on both")
    )
    assert "R3: " + report["tests"][1]["requirements"]["R3"]["verdict"] + " on pybullet, NC on mujoco" in words


def test_a_session_on_one_engine_has_no_view_of_engines() -> None:
    assert "on the engine" not in Page(html.page(sample.report(tests=2))[0]).words
