"""Cross products: several by name, with verdicts; what the model makes impossible is told from what was not hit yet."""

from __future__ import annotations

from typing import Any

import pytest

from tests.plugin.project import change, report

SUITE = "--hri-suite=by-hand"
#: Who greets asks for 100 or 10 percent, in either place; who does not for 0, 10 or nothing.
PLANNED = """"greeting": CrossProduct(
            {"greets": ("yes", "no"), "level": levels, "R2": ("Passed", "Failed", "NC")}, planned=planned
        ),
        "light": CrossProduct"""
FUNCTION = """

def planned(lines):
    levels = [line.split()[-1] for line in lines if line.startswith("set_lamp")]
    return [("yes" if "greet" in lines else "no", levels[0] if levels else "none")]


def run(run):
"""


@pytest.fixture
def crossed(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps with a second cross product, of which the model knows two coordinates."""
    change(lamps.path, "conftest.py", '"light": CrossProduct', PLANNED)
    change(lamps.path, "conftest.py", "\n\ndef run(run):\n", FUNCTION)
    change(lamps.path, "conftest.py", 'cross={"light": [', 'cross={"greeting": planned(commands), "light": [')
    return lamps


def product(folder: pytest.Pytester) -> dict[str, Any]:
    written = report(folder.path)
    found: dict[str, Any] = written["suites"][0]["cross"]["products"]["greeting"]
    return found


@pytest.mark.slow
def test_what_the_model_never_does_is_impossible_and_the_rest_is_not_hit_yet(crossed: pytest.Pytester) -> None:
    crossed.runpytest_inprocess(SUITE)
    written = report(crossed.path)
    declared = written["cross_products"]["greeting"]
    assert declared["proof"] == {"status": "proven", "reason": "", "runs": 10}
    # 24 bins: nobody greets for 0 or for nothing, nobody comes without a greeting for 100: these with three verdicts.
    ruled_out = {tuple(each["bin"][:2]) for each in declared["impossible"]}
    assert ruled_out == {("yes", "0"), ("yes", "none"), ("no", "100")}
    assert {each["by"] for each in declared["impossible"]} == {"model"}
    figures = product(crossed)
    assert (figures["bins"], figures["impossible"], figures["illegal"]) == (24, 9, 0)
    assert figures["hit"] + len(figures["missing"]) == 15
    hit = {tuple(each["bin"]): each["tests"] for each in figures["hits"]}
    assert hit[("yes", "100", "Failed")] == 1  # in the hall, where R2 fails
    assert hit[("yes", "100", "Passed")] == 1  # in the cellar, where there is a limit
    assert written["suites"][0]["cross"]["bins"] == 24 + 8
    assert written["cross_products"]["light"]["proof"] == {}


def test_open_bins_and_plans_have_beliefs_that_aim_at_them(crossed: pytest.Pytester) -> None:
    crossed.runpytest_inprocess(SUITE, "-k", "hall-polite")
    gaps = report(crossed.path)["closure"]["gaps"]
    open_ = {gap["items"][0]: gap for gap in gaps if gap["kind"] in ("bins", "plans")}
    assert open_["v5"]["suggestion"] == "the beliefs hall curt dark reach it"
    assert open_["v2"]["beliefs"] == ["cellar"]
    bin_ = open_["no x 0 x Passed"]
    assert bin_["beliefs"] == ["hall", "curt", "dark"]
    assert bin_["suggestion"] == "the beliefs hall curt dark aim at no x 0; the rest is up to the run"


@pytest.mark.slow
def test_the_beliefs_that_are_suggested_close_the_gap(crossed: pytest.Pytester) -> None:
    change(crossed.path, "by_hand.toml", '"?[ae]l*", "polite", "bright"', '"hall", "curt", "bright"')
    change(crossed.path, "by_hand.toml", '"hall", "curt", "d*"', '"hall", "polite", "bright"')
    crossed.runpytest_inprocess(SUITE)
    gap = next(gap for gap in report(crossed.path)["closure"]["gaps"] if gap["items"] == ["v5"])
    beliefs = ", ".join(f'"{belief}"' for belief in gap["beliefs"])
    change(crossed.path, "by_hand.toml", '"hall", "polite", "bright"', beliefs)
    crossed.runpytest_inprocess(SUITE)
    assert "v5" in report(crossed.path)["suites"][0]["plans"]["visitor"]["covered"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"yes" if', '"often" if', "planned returned ('often', '10'), but 'greets' has no value 'often'"),
        (
            'levels[0] if levels else "none")]',
            '"0", "Passed", "more")]',
            "expected a value of each of the same",
        ),
    ],
)
def test_a_plan_for_no_bin_is_told_and_fails_the_run(crossed: pytest.Pytester, old: str, new: str, told: str) -> None:
    change(crossed.path, "conftest.py", 'cross={"greeting": planned(commands), ', "cross={")
    change(crossed.path, "conftest.py", old, new)
    result = crossed.runpytest_inprocess(SUITE)
    assert result.ret == 1
    (failed,) = report(crossed.path)["gates"]["failed"]
    assert failed.startswith("cross product 'greeting': planned returned (")
    assert told in failed


def test_bins_of_a_product_that_nobody_declared_are_told(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", 'cross={"light": [', 'cross={"lights": [')
    result = lamps.runpytest_inprocess(SUITE)
    assert result.ret == 1
    result.stdout.fnmatch_lines(["cross product: run reported bins of 'lights', but declared are: light"])
