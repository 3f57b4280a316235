"""Learning through the plugin: constants, rewards, saved tables, and what is told of the suite."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.plugin.project import A_WORKER, change, nodeids, report
from tests.plugin.test_bad_input import refused, short

RL = "--hri-suite=rl"
COLLECT = ("--collect-only", "-q", RL)


def constants(folder: Path) -> dict[str, object]:
    """The constants that a saved table was learned with."""
    learning: dict[str, object] = json.loads((folder / "q.json").read_text(encoding="utf-8"))["learning"]
    return learning


@pytest.mark.slow
def test_diagnostics_are_in_the_report_and_in_the_summary(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("-v", "--hri-suite=rl,pseudorandom")
    learned, drawn = (suite["generation"] for suite in report(lamps.path)["suites"])
    assert learned["reward"] == "published"
    found = learned["diagnosis"]
    assert found["distinct_subsets"] == 34
    assert 0 < found["belief_entropy_bits"] <= found["belief_entropy_most_bits"]
    assert 1 <= found["last_new_plan"]["iteration"] <= learned["iterations"]
    assert 1 <= found["last_new_plan"]["test"] <= 34
    assert "mostly repeats" in learned["notes"][-1]
    assert (drawn["reward"], drawn["diagnosis"]["distinct_subsets"]) == ("", 0)
    assert drawn["diagnosis"]["last_new_plan"] == {"iteration": None, "test": 0}
    result.stdout.fnmatch_lines(["  note * tests asked for, but the policy leads to 34*"])


@pytest.mark.slow
def test_a_saved_table_is_learned_on_from(lamps: pytest.Pytester) -> None:
    cold = nodeids(lamps.runpytest_inprocess(*COLLECT))
    saving = lamps.runpytest_inprocess(*COLLECT, "--hri-rl-save=tables/q.json")
    assert nodeids(saving) == cold, "though the suite was in the cache, it was learned anew for its table"
    result = lamps.runpytest_inprocess(RL, "--hri-rl-start=tables/q.json", *A_WORKER)
    assert result.ret == 0
    written = report(lamps.path)
    assert "learning began with q.json" in written["suites"][0]["generation"]["notes"]
    assert written["rerun_options"]["options"] == ["--hri-rl-start=tables/q.json"]


def test_a_table_of_the_ini_file_is_relative_to_that_file(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (lamps.path / "pytest.ini").open("a", encoding="utf-8") as ini:
        ini.write("\nhri_rl_save = q.json\n")
    monkeypatch.chdir(lamps.mkdir("below"))
    assert lamps.runpytest_inprocess("..", *COLLECT).ret == 0
    assert (lamps.path / "q.json").is_file()
    assert not (lamps.path / "below" / "q.json").exists()


def test_a_table_of_another_model_is_refused(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(*COLLECT, "--hri-rl-save=q.json")
    change(lamps.path, "models/visitor.asl", "greet; set_lamp(level, 10)", "greet; greet; set_lamp(level, 10)")
    for options in ((), ("-n", "2")):
        message = refused(lamps, RL, "--hri-rl-start=q.json", *options)
        assert "q.json: a table of another model: it was learned on lamps.mas2j of sha256 " in message
        assert message.count("sha256") == 1
        assert len({word for word in message.replace(",", " ").replace(";", " ").split() if len(word) == 64}) == 2


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (
            [RL, "--hri-rl=gama=0.2"],
            "--hri-rl=gama=0.2: expected NAME=VALUE with the name of a constant of learning; n",
        ),
        ([RL, "--hri-rl=gama=0.2"], "nearest: gamma"),
        ([RL, "--hri-rl=gamma"], "--hri-rl=gamma: expected NAME=VALUE"),
        ([RL, "--hri-rl=gamma=much"], "--hri-rl=gamma=much: gamma = 'much'; expected a number"),
        ([RL, "--hri-rl=gamma=1.5"], "--hri-rl=gamma=1.5: QLearning: gamma = 1.5; expected 0 <= gamma < 1"),
        ([RL, "--hri-rl=iterations=2.5"], "iterations = '2.5'; expected a whole number"),
        ([RL, "--hri-rl=rewards=1,x"], "rewards = '1,x'; expected numbers, with commas between"),
        ([RL, "--hri-rl=stop_when_converged=maybe"], "expected true or false"),
        ([RL, "--hri-rl=reward=uncovered"], "the reward has an option of its own: --hri-rl-reward=NAME"),
        ([RL, "--hri-rl-reward=uncoverd"], "no reward 'uncoverd'; nearest: uncovered"),
        ([RL, "--hri-rl-start=nowhere.json"], "--hri-rl-start: "),
        ([RL, "--hri-rl-start=nowhere.json"], "nowhere.json: there is no such file"),
        ([RL, "--hri-rl-start=pytest.ini"], "pytest.ini:1:2: not JSON, perhaps cut off"),
        ([RL, "--hri-rl-save=pytest.ini/q.json"], "q.json: File exists; choose another file"),
        (
            ["--hri-suite=by-hand", "--hri-rl-save=q.json"],
            "--hri-rl-save=q.json: nothing is learned; select the suite rl",
        ),
    ],
    ids=short,
)
def test_bad_input(lamps: pytest.Pytester, options: list[str], told: str) -> None:
    assert told in refused(lamps, *options)
