"""Tests with chosen values through the plugin: run, exported, minimized, shrunk, replayed, refused."""

from __future__ import annotations

import json

import pytest

from tests import json_schema
from tests.plugin.project import command, report
from tests.plugin.test_bad_input import refused

CHOSEN = """\
# values run: patience_s 6.25
# values 3: pause_s 0.9
enter hall
greet
set_lamp level = 100
leave
"""
VALUES = {"run": {"patience_s": 6.25}, "3": {"pause_s": 0.9}}


@pytest.fixture
def chosen(lamps: pytest.Pytester) -> pytest.Pytester:
    """The project with a suite of one test, which has chosen values and violates R2."""
    (lamps.path / "chosen.txt").write_text(CHOSEN, encoding="utf-8")
    return lamps


def test_chosen_values_are_run_and_reported(chosen: pytest.Pytester) -> None:
    chosen.runpytest_inprocess("--hri-suite=chosen.txt")
    written = report(chosen.path)
    json_schema.REPORT.validate(written)
    (test,) = written["tests"]
    assert test["values"] == VALUES
    assert test["concrete"]["run"] == VALUES["run"]
    assert test["concrete"]["actions"][2]["parameters"] == VALUES["3"]
    assert 0.5 <= test["concrete"]["actions"][0]["parameters"]["pause_s"] <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("how", ["export", "minimal"])
def test_a_test_with_values_that_is_written_and_read_back_is_the_same_run(chosen: pytest.Pytester, how: str) -> None:
    chosen.runpytest_inprocess("--hri-suite=chosen.txt", *(["--hri-export=kept"] if how == "export" else []))
    (before,) = report(chosen.path)["tests"]
    if how == "minimal":
        assert command("minimal", "hri-report", "kept").returncode == 0
    chosen.runpytest_inprocess("--hri-suite=kept")
    (after,) = report(chosen.path)["tests"]
    for key in ("id", "values", "concrete", "record_sha256"):
        assert after[key] == before[key], key


@pytest.mark.slow
def test_a_failing_test_with_values_is_shrunk_and_replayed(chosen: pytest.Pytester) -> None:
    chosen.runpytest_inprocess("--hri-suite=chosen.txt", "--hri-shrink", "--hri-strict")
    (test,) = report(chosen.path)["tests"]
    for file in (test["replay"], test["shrunk"]["R2"]["replay"]):
        data = json.loads((chosen.path / file).read_text(encoding="utf-8"))
        json_schema.REPLAY.validate(data)
        chosen.runpytest_inprocess(f"--hri-replay={file}")
        (again,) = report(chosen.path)["tests"]
        assert again["replayed"]["same"]
        assert again["values"] == data["test"]["values"]
    # Dropping the actions before it made the third one the first.
    assert again["abstract"] == ["set_lamp level = 100"]
    assert again["values"] == {"run": {"patience_s": 6.5}, "1": {"pause_s": 0.75}}


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("# values 3: pauses_s 0.9", "chosen.txt: suite chosen, test "),
        ("# values 3: pauses_s 0.9", "command 3 (set_lamp level = 100): no parameter 'pauses_s'; nearest: pause_s"),
        ("# values 3: pause_s 2.0", "pause_s 2.0 is out of its range; expected range [0.5, 1] s"),
        ("# values 4: pause_s 0.9", "command 4 (leave): no parameter 'pause_s'; declared: none"),
        ("# values 5: pause_s 0.9", "chosen.txt:2:1: values of command 5: the test has 4 commands only"),
    ],
)
def test_values_that_cannot_be_chosen_are_refused(chosen: pytest.Pytester, line: str, told: str) -> None:
    (chosen.path / "chosen.txt").write_text(CHOSEN.replace("# values 3: pause_s 0.9", line), encoding="utf-8")
    assert told in refused(chosen, "--hri-suite=chosen.txt")
