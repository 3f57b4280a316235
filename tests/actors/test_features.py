"""What a session does beside running tests, with several actors: traces, films, the oracle, changes, campaigns."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from mcap.reader import make_reader

from tests import json_schema
from tests.plugin.project import report

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
CONFTEST = """
import os

from tests.actors.corridor.bench import followed_ward
from tests.actors.hospital.bench import hospital

def pytest_hricdv_testbench(config):
    if os.environ["WHERE"] == "hospital":
        return hospital(online=True)
    return followed_ward(obeys=os.environ["WHERE"] == "corridor")
"""
SUITE = ("--hri-suite=pseudorandom,rl", "--hri-tests=6", "--hri-seed=1", "--hri-diagnose=0")


@pytest.fixture
def project(project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A project with the corridor or the hospital."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("WHERE", "corridor")
    project.makeconftest(CONFTEST)
    return project


def logged(path: Path) -> list[tuple[str, str]]:
    """Who did what in a trace, in order, without parameters."""
    with path.open("rb") as file:
        messages = [json.loads(message.data) for _, channel, message in make_reader(file).iter_messages()
                    if channel.topic == "/hricdv/log"]  # fmt: skip
    return [(content["name"], content["message"].split(" ")[0]) for content in messages]


def test_traces_say_who_did_what_films_show_it_and_the_oracle_follows(project: pytest.Pytester) -> None:
    project.runpytest_inprocess(*SUITE, "--hri-mcap-all", "--hri-film")
    written = report(project.path)
    json_schema.REPORT.validate(written)
    verdicts = {test["requirements"]["MODEL"]["verdict"] for test in written["tests"]}
    assert "Passed" in verdicts
    failed = [test for test in written["tests"] if test["outcome"] == "failed"]
    assert failed
    for test in written["tests"]:
        begun = [test["abstract"][number - 1].split(": ") for number in test["action_indices"]]
        told = logged(project.path / "hri-report" / "traces" / f"{test['id']}.mcap")
        assert [entry for entry in told if entry[0] in ("nurse", "child")] == [(who, act) for who, act in begun]
    assert all(test["film"]["frames"] > 20 and not test["film"]["note"] for test in failed)


def test_a_change_of_the_code_is_told_and_none_is_where_there_is_none(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = ("--hri-baseline=before.json",)
    project.runpytest_inprocess("-vv", *SUITE, *before, "--hri-update-baseline")
    same = project.runpytest_inprocess("-vv", *SUITE, *before, "--hri-fail-on-change")
    assert report(project.path)["changes"]["changed"] == {}
    assert "behave differently" not in same.stdout.str()
    monkeypatch.setenv("WHERE", "corridor without the fault")
    other = project.runpytest_inprocess("-vv", *SUITE, *before, "--hri-fail-on-change")
    assert other.ret == 1
    other.stdout.fnmatch_lines(["*tests behave differently from the baseline", "*`arrived` later*"])
