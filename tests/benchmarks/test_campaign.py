"""A campaign on the lamps project: a killed campaign resumes, and results of other code are refused."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.campaign import __main__ as campaign
from benchmarks.campaign import results, shard, totals
from benchmarks.campaign.progress import duration
from benchmarks.campaign.shard import CampaignRun, Shard, ShardError, Total
from benchmarks.campaign.state import Plan, State, StateError
from studies import session
from tests.plugin import project

DEPENDS = ("conftest.py", "lamps", "requirements.toml")
SIZE = ("--tests=2", "--seeds=3", "--workers=1")


@pytest.fixture
def lamps(tmp_path: Path) -> Path:
    """A user's project."""
    folder = tmp_path / "project"
    folder.mkdir()
    project.write(folder)
    return folder


def command(lamps: Path, state: str, *more: str) -> list[str]:
    """The command line of a campaign on it."""
    where = [f"--root={lamps}", f"--state={lamps.parent / state}", "--suite=bdi-random"]
    return [sys.executable, "-m", "benchmarks.campaign", *where, *SIZE, *more, "--depends", *DEPENDS]


def run(lamps: Path, state: str, *more: str) -> subprocess.CompletedProcess[str]:
    """A campaign from begin to end."""
    return subprocess.run(
        command(lamps, state, *more), cwd=session.ROOT, capture_output=True, text=True, timeout=100, check=False
    )


def killed(lamps: Path, state: str, said: str) -> None:
    """A campaign that is killed as soon as it says something."""
    with subprocess.Popen(command(lamps, state), cwd=session.ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith(said):
                break
        os.kill(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL


@pytest.mark.slow
def test_a_campaign_that_was_killed_twice_gives_the_same_bytes(lamps: Path) -> None:
    whole = run(lamps, "whole")
    assert whole.returncode == 0, whole.stderr
    killed(lamps, "resumed", "campaign:")
    killed(lamps, "resumed", "seed 0:")
    assert (lamps.parent / "resumed" / "shards" / "seed-000.json").is_file()
    assert not (lamps.parent / "resumed" / "results.md").exists()
    resumed = run(lamps, "resumed")
    assert resumed.returncode == 0, resumed.stderr
    assert "seed 0:" not in resumed.stdout
    expected = (lamps.parent / "whole" / "results.md").read_bytes()
    assert (lamps.parent / "resumed" / "results.md").read_bytes() == expected
    assert not list((lamps.parent / "resumed").glob("work-*"))


@pytest.mark.slow
def test_its_runs_are_those_of_the_plugin_s_own_concretizations(lamps: Path) -> None:
    done = run(lamps, "state")
    assert done.returncode == 0, done.stderr
    options = ["--hri-suite=bdi-random", "--hri-tests=2", "--hri-concretizations=3", "-p", "no:xdist"]
    report = session.run(lamps.parent / "report", options, lamps).report
    state = State(lamps.parent / "state")
    runs = {each.id: each.record_sha256 for seed in state.done() for each in state.shard(seed).runs}
    assert runs == {test["id"]: test["record_sha256"] for test in report["tests"]}
    assert len(runs) == 6


@pytest.mark.slow
def test_code_that_changed_meanwhile_is_refused_by_name(lamps: Path) -> None:
    killed(lamps, "state", "seed 0:")
    project.change(lamps, "lamps/guide.py", "GLARE = 80.0", "GLARE = 70.0")
    refused = run(lamps, "state")
    assert refused.returncode == 1
    assert "holds 1 shards of another campaign: lamps/guide.py changed." in refused.stderr
    assert "another --state folder" in refused.stderr
    other = run(lamps, "state", "--tests=5")
    assert "count was 2, is 5" in other.stderr
    again = run(lamps, "state", "--again")
    assert again.returncode == 0, again.stderr


def test_nothing_to_run_is_asked_of_a_folder_without_seeds(lamps: Path) -> None:
    refused = run(lamps, "state", "--again")
    assert refused.returncode == 1
    assert refused.stderr.startswith("campaign: ")
    assert "no seed is done there" in refused.stderr


def test_two_campaigns_do_not_share_a_folder(tmp_path: Path) -> None:
    with State(tmp_path).held(), pytest.raises(StateError, match="another campaign runs in this folder"):
        State(tmp_path).held().__enter__()
    with State(tmp_path).held():
        assert State(tmp_path).done() == ()


OF_A = ("Failed", "Passed", "Passed")
PLAN = Plan("rl", 0, 2, {"code/a.py": "0" * 64, "python": "3.11.1"})


def a_run(test: str, seed: int, verdict: str = "Passed", statements: int = 0b1, **more: object) -> CampaignRun:
    """A run with one requirement."""
    given: dict[str, object] = {"margins": {"R1": 0.5}, "legs": ("released",), "bins": ("a x b",)}
    return CampaignRun(
        test=test,
        id=f"{test}-k{seed}",
        verdicts={"R1": verdict},
        triggers={"R1": int(verdict != "NC")},
        statements=statements,
        branches=None,
        sim_s=1.0,
        record_sha256="ab",
        **{**given, **more},  # type: ignore[arg-type]
    )


def a_shard(seed: int, runs: Sequence[CampaignRun], **more: object) -> Shard:
    """A shard of four statements."""
    given: dict[str, object] = {"identity": PLAN.identity, "wall_s": 1.0, "cpu_s": 2.0}
    return Shard(
        seed=seed,
        runs=tuple(runs),
        statements=Total(4, 4),
        branches=None,
        titles={"R1": "What is wished"},
        missing={"code/a.py": (2, 3)},
        waived={"code/a.py": (3,)},
        **{**given, **more},  # type: ignore[arg-type]
    )


def test_a_shard_is_read_as_it_was_written(tmp_path: Path) -> None:
    state, made = State(tmp_path), a_shard(7, [a_run("t", 7, statements=1 << 300)])
    with state.held():
        state.agree(PLAN)
        state.keep(made)
    assert state.done() == (7,)
    assert state.shard(7) == made
    assert State(tmp_path).plan() == PLAN


@pytest.mark.parametrize("text", ["", "{", "[]", '{"schema": "other"}', '{"schema": "hricdv-campaign-shard/1"}'])
def test_a_damaged_shard_is_named_and_can_be_run_again(tmp_path: Path, text: str) -> None:
    path = tmp_path / "seed-000.json"
    path.write_text(text)
    with pytest.raises(ShardError, match=r"seed-000\.json: .*remove the file to run it again"):
        shard.read(path)


def test_a_shard_of_another_campaign_is_refused(tmp_path: Path) -> None:
    state = State(tmp_path)
    with state.held():
        state.agree(PLAN)
        state.keep(a_shard(0, [], identity="other"))
    with pytest.raises(StateError, match="a shard of another campaign or seed"):
        state.shard(0)


def test_what_differs_between_plans_is_said() -> None:
    other = Plan("by-hand", 0, 2, {"code/a.py": "1" * 64, "code/b.py": "1" * 64, "numpy": "2"})
    assert other.differences(PLAN) == [
        "method was rl, is by-hand",
        "code/a.py changed",
        "code/b.py is new",
        "numpy is new",
        "python is gone",
    ]
    assert PLAN.differences(PLAN) == []
    assert Plan("rl", 0, 2, {**PLAN.depends, "python": "3.12.0"}).differences(PLAN) == ["python was 3.11.1, is 3.12.0"]


def test_totals_tell_what_depends_on_the_seed() -> None:
    shards = [
        a_shard(0, [a_run("a", 0, "Failed"), a_run("b", 0, "Failed"), a_run("c", 0, "NC")]),
        a_shard(1, [a_run("a", 1, "Failed"), a_run("b", 1, "Passed"), a_run("c", 1, "NC")]),
    ]
    (found,) = totals.requirements(shards)
    assert (found.passed, found.failed, found.nc, found.triggers) == (1, 3, 2, 4)
    assert (found.by_seed, found.ever, found.always, found.unsettled) == ((1, 2), 2, 1, 1)
    assert found.rate is not None
    assert found.rate.value == 0.75
    assert totals.failing(shards, "R1") == [(1.0, 2.0), (2.0, 2.0)]


def test_coverage_grows_with_seeds_and_waived_lines_are_not_missed() -> None:
    shards = [a_shard(0, [a_run("a", 0, statements=0b1)]), a_shard(1, [a_run("a", 1, statements=0b110)])]
    found = totals.coverage(shards)
    assert (found.statements, found.seed_statements, found.most) == (75.0, (25.0, 50.0), 50.0)
    assert found.missing == ("code/a.py: 2",)
    assert totals.growth(shards, totals.statements, 4) == [(1.0, 25.0), (2.0, 75.0)]


def test_a_run_that_did_not_end_counts_for_nothing_but_is_listed() -> None:
    broken = a_run("b", 0, "NC", statements=0, error="the arm fell off")
    shards = [a_shard(0, [a_run("a", 0), broken])]
    text = results.text(shards)
    assert "- `b-k0` did not end: the arm fell off" in text
    (found,) = totals.requirements(shards)
    assert (found.passed, found.nc) == (1, 0)


def test_results_do_not_depend_on_what_the_runs_cost() -> None:
    runs = [a_run("a", 0, "Failed")]
    text = results.text([a_shard(0, runs, wall_s=1.0, cpu_s=1.0)])
    assert text == results.text([a_shard(0, runs, wall_s=9.0, cpu_s=9.0)])
    assert "- R1 in `a-k0`" in text
    assert "- R1 in `a-k0`" not in results.text([a_shard(0, runs)], known=["R1"])


@given(st.floats(0, 1e6))
def test_time_left_is_said_in_words_without_sixty_of_anything(seconds: float) -> None:
    said = duration(seconds)
    assert "60 min" not in said
    assert said.endswith((" s", " min"))


@pytest.mark.parametrize(("seconds", "said"), [(0, "0 s"), (89, "89 s"), (720, "12 min"), (7500, "2 h 5 min")])
def test_time_left(seconds: float, said: str) -> None:
    assert duration(seconds) == said


def test_the_page_says_how_many_runs_there_are_and_of_what_code(tmp_path: Path) -> None:
    shards = [a_shard(seed, [a_run("a", seed, verdict), a_run("b", seed)]) for seed, verdict in enumerate(OF_A)]
    for folder in ("first", "second"):
        campaign.write(PLAN, shards, {"R1": "it is hard"}, tmp_path / folder)
    text = (tmp_path / "first" / "campaign.md").read_text(encoding="utf-8")
    assert text.startswith("# A campaign: 6 runs of one method\n")
    assert (
        "One seed finds R1 failing in 0 to 1 of 2 tests; with 3 seeds 1 tests fail it at least once and 0 always."
        in text
    )
    assert "every test as likely to fail it as any other, 1 would at least once." in text
    assert "- R1: What is wished. Known to fail: it is hard." in text
    assert f"| code/ | `{campaign.summed({'code/a.py': '0' * 64})['code/'][:16]}` |" in text
    assert "python 3.11.1." in text
    pictures = [(tmp_path / folder / "pictures" / "campaign-seeds.svg").read_bytes() for folder in ("first", "second")]
    assert pictures[0] == pictures[1]


def test_a_requirement_that_is_known_to_fail_under_a_condition_is_known_by_its_name() -> None:
    assert set(campaign.known_violations(session.ROOT)) == {"R1", "R3"}
