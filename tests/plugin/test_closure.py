"""Closure: what is open and how to close it, what each test adds, and the smallest suite that covers as much."""

from __future__ import annotations

from typing import Any

import pytest

from tests.plugin.project import command, report


def covered(written: dict[str, Any]) -> dict[str, Any]:
    """Everything that counts as covered."""
    (suite,) = written["suites"]
    verdicts = {(name, v["verdict"]) for test in written["tests"] for name, v in test["requirements"].items()}
    return {
        "files": written["code_under_test"]["files"],
        "code": suite["code"],
        "plans": {agent: plans["covered"] for agent, plans in suite["plans"].items()},
        "bins": [hit["bin"] for hit in suite["cross"]["products"]["light"]["hits"]],
        "verdicts": {each for each in verdicts if each[1] != "NC"},
    }


@pytest.mark.slow
def test_the_smallest_suite_covers_as_much_when_it_is_run(lamps: pytest.Pytester) -> None:
    assert lamps.runpytest_inprocess("--hri-suite=rl").ret == 0
    whole = report(lamps.path)
    steps = whole["closure"]["minimal"]
    done = command("minimal", "hri-report", "small")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == f"small/rl.txt: {len(steps)} tests"
    assert lamps.runpytest_inprocess("--hri-suite=small").ret == 0
    small = report(lamps.path)
    assert {test["nodeid"] for test in small["tests"]} == {step["nodeid"] for step in steps}
    assert len(small["tests"]) < len(whole["tests"]) / 2
    assert covered(small) == covered(whole)
    assert small["closure"]["points"] == whole["closure"]["points"] == steps[-1]["points"]
    assert small["closure"]["adds_nothing"] == []
    assert len(small["closure"]["minimal"]) == len(steps)


def test_tests_that_add_nothing_and_what_only_one_test_covers_are_told(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand")
    written = report(lamps.path)
    closure = written["closure"]
    assert closure == written["suites"][0]["closure"] | {"gaps": closure["gaps"]}
    needed = {step["nodeid"] for step in closure["minimal"]}
    assert {*needed, *closure["adds_nothing"]} == {test["nodeid"] for test in written["tests"]}
    # Nobody else is in the cellar, and nobody else is violated by a glare.
    (cellar, bright) = (next(t for t in written["tests"] if part in t["id"]) for part in ("cellar", "hall-polite"))
    assert closure["unique"][cellar["nodeid"]] >= 3  # its plan, its bin, the lines about the cellar
    assert closure["unique"][bright["nodeid"]] >= 2  # its bin, and R2 Failed
    assert sum(step["gain"] for step in closure["minimal"]) == closure["points"]


def gaps(lamps: pytest.Pytester, kind: str) -> list[dict[str, Any]]:
    return [gap for gap in report(lamps.path)["closure"]["gaps"] if gap["kind"] == kind]


def test_what_is_open_has_a_reason_or_a_suggestion(lamps: pytest.Pytester) -> None:
    guide = lamps.path / "lamps" / "guide.py"
    text = guide.read_text(encoding="utf-8").replace('"by hand"', '"by hand"  # unreachable: done by the caretaker')
    guide.write_text(text, encoding="utf-8")
    lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "hall-polite")
    (tested,) = report(lamps.path)["tests"]
    lines = {gap["location"]: gap for gap in gaps(lamps, "statements")}
    assert lines["lamps/guide.py"]["reason"] == "waived as unreachable: done by the caretaker"
    assert lines["lamps/guide.py dimmed"]["reason"] == "no test reaches this function"
    level = lines["lamps/guide.py level_for"]
    assert level["test"] == tested["id"]
    dark = next(number for number, line in enumerate(text.splitlines(), 1) if "if wish.cellar" in line)
    assert level["items"] == [str(dark + 1), str(dark + 3), str(dark + 5)]
    told = f"line {dark} has to continue to line {dark + 1} (`if wish.cellar and wish.level > GLARE:`)"
    assert level["suggestion"] == f"vary {tested['id']}: {told}"
    plans = {gap["items"][0] for gap in gaps(lamps, "plans")}
    assert plans == {"v2", "v4", "v5", "v6", "v7"}
    assert {gap["items"][0] for gap in gaps(lamps, "bins")} == set(report(lamps.path)["suites"][0]["cross"]["missing"])


def test_a_requirement_that_nobody_triggered_is_open_with_the_nearest_test(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "curt")
    (open_,) = gaps(lamps, "requirements")
    assert open_["location"] == "R3"
    assert open_["test"] in {test["id"] for test in report(lamps.path)["tests"]}
    assert open_["suggestion"].startswith(f"vary {open_['test']}, which lacked ")
