"""Verification plans: goals by requirements and coverage, checked before the tests and judged after them."""

from __future__ import annotations

from typing import Any

import pytest

from tests import json_schema
from tests.plugin.project import command, report

SUITE = ("--hri-suite=by-hand", "-p", "no:xdist", "--hri-plan=plan.toml")
PLAN = """
title = "Lamps"

[light]
title = "Light as wished"
owner = "ana"

[light.wish]
title = "Wishes come true"
requirements = ["R1"]
triggers = 4

[light.glare]
requirements = ["R2"]
owner = "ben"

[manners]
[manners.answer]
requirements = ["R3"]
triggers = 100

[reach.code]
statements = 94
branches = 100
files = ["lamps/guide.py"]

[reach.light]
cross = { light = 60 }
plans = { visitor = 70, guide = 100 }
"""


def write(lamps: pytest.Pytester, text: str = PLAN) -> None:
    (lamps.path / "plan.toml").write_text(text, encoding="utf-8")


def goals(parts: list[dict[str, Any]]) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Name -> state and what is missing, of goals and sections."""
    return {part["name"]: (part.get("state", "open"), tuple(part.get("missing", ()))) for part in parts}


@pytest.mark.slow
def test_each_goal_has_a_state_and_what_it_lacks(lamps: pytest.Pytester) -> None:
    write(lamps)
    result = lamps.runpytest_inprocess(*SUITE)
    written = report(lamps.path)
    json_schema.REPORT.validate(written)
    found = goals(written["plan"])
    assert found["light.wish"] == ("met", ())
    assert found["light.glare"] == ("waived", ("R2 is known to fail: the hall has no dimmer",))
    assert found["light"] == ("waived", ())
    assert found["manners.answer"] == ("open", ("R3 was triggered 2 of 100 times",))
    assert found["reach.code"] == ("met", ())
    assert found["reach.light"] == ("open", ("light: 50.0 % (4 of 8), 60 % wanted",))
    whole, *_ = written["plan"]
    assert (whole["title"], whole["met"], whole["goals"]) == ("Lamps", 3, 5)
    result.stdout.fnmatch_lines(
        ["plan: 3 of 5 goals met (Lamps)", "  open  manners.answer: R3 was triggered 2 of 100 times"]
    )


@pytest.mark.slow
def test_a_violation_and_what_was_not_checked(lamps: pytest.Pytester) -> None:
    write(lamps)
    lamps.runpytest_inprocess(*SUITE, "--hri-strict", "-k", "hall")
    assert goals(report(lamps.path)["plan"])["light.glare"] == ("failed", ("R2 failed in 1 of 3 tests",))
    lamps.runpytest_inprocess(*SUITE, "-k", "curt")
    assert goals(report(lamps.path)["plan"])["manners.answer"] == ("not checked", ("R3 was not checked",))


@pytest.mark.slow
def test_a_merged_report_has_the_plan_over_all_sessions(lamps: pytest.Pytester) -> None:
    write(lamps)
    lamps.runpytest_inprocess(*SUITE)
    whole = report(lamps.path)["plan"]
    for shard in ("1/2", "2/2"):
        lamps.runpytest_inprocess(*SUITE, f"--hri-shard={shard}", f"--hri-report=part{shard[0]}")
    assert command("merge", "part1", "part2", "-o", "hri-report").returncode == 0
    assert report(lamps.path)["plan"] == whole


def test_the_page_has_it_beside_the_requirements_and_its_state_in_the_summary(lamps: pytest.Pytester) -> None:
    write(lamps)
    lamps.runpytest_inprocess(*SUITE)
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    summary = page.partition('<section class="view" id="summary">')[2].partition("</section>")[0]
    assert '<a href="#plan">Plan: 3 of 5 goals met (Lamps)</a>' in summary
    assert page.index('href="#requirements"') < page.index('href="#plan"')
    assert "Wishes come true" in page


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[a]\nrequirements = ['R7']", "plan.toml:1: [a]: requirements: there is no 'R7'; nearest: R"),
        ("\n[a]\ncross = {lihgt = 3}", "plan.toml:2: [a]: cross: there is no 'lihgt'; nearest: light"),
        ("[a]\nplans = {usher = 3}", "[a]: plans: there is no 'usher'"),
        ("[a]\nstatements = 101", "[a]: Expected `int` <= 100 - at `$.statements`"),
        ("[a]\nrequirements = 'R1'", "[a]: Expected `array`, got `str` - at `$.requirements`"),
        ("[a]\nrequirements = ['R1']\ntriggers = 0", "[a]: Expected `int` >= 1 - at `$.triggers`"),
        ("[a]\nstatement = 90", "[a]: unknown key 'statement'; nearest: statements - at `$` of a goal"),
        (
            "[a]\nstatements = 90\n[a.b]\nbranches = 1",
            "[a]: unknown key 'statements'; known: title, owner, text - at `$` of a section, which contains tables",
        ),
        ("[a]\ntitle = 'nothing'", "[a]: a goal without criteria"),
        ("[a]\ntitle = 3", "[a]: Expected `str`, got `int` - at `$.title`"),
        ("title = 'empty'", "plan.toml: no goal in this plan"),
        ("[a", "plan.toml:1:1: not TOML"),
    ],
)
def test_a_wrong_plan_is_an_error_with_its_place(lamps: pytest.Pytester, text: str, said: str) -> None:
    write(lamps, text)
    result = lamps.runpytest_inprocess(*SUITE)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert "ERROR: --hri-plan: " in result.stderr.str()
    assert said in result.stderr.str()
