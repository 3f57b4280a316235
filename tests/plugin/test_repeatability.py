"""Runs of code that draws at random, or goes through a set, are the same in each session and on each worker."""

from __future__ import annotations

from pathlib import Path

import numpy  # noqa: F401  # a process loads it once, and pytester forgets what a test has loaded
import pytest

from tests.plugin import project

ANSWER = "bus.publish(Answer())"


def says(text: str) -> str:
    """What the guide does beside its answer, so that the hash of the record depends on it."""
    return f"bus.publish(Switched({text})); {ANSWER}"


def records(folder: Path) -> dict[str, str]:
    """Id of a test -> hash of its record, of the report."""
    return {test["id"]: test["record_sha256"] for test in project.report(folder)["tests"]}


@pytest.mark.slow
def test_workers_hash_alike_without_a_hash_seed(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", "random")
    project.change(lamps.path, "lamps/guide.py", ANSWER, says('float(hash("a lamp") % 1000)'))
    options = ("--hri-suite=by-hand", "--hri-no-cov", "-n", "1")
    lamps.runpytest_subprocess(*options)
    first = records(lamps.path)
    lamps.runpytest_subprocess(*options)
    assert records(lamps.path) == first
    assert first


DRAWN = (
    "random.random() + float(numpy.random.rand()) + uuid.uuid4().int % 100 + secrets.randbelow(100) + os.urandom(1)[0]"
)
IMPORTS = "import os, random, secrets, uuid, numpy"


@pytest.mark.parametrize(
    ("file", "place", "text"),
    [
        pytest.param("lamps/guide.py", ANSWER, f"{IMPORTS}; {says(DRAWN)}", id="the code under test"),
        pytest.param(
            "conftest.py",
            "lamp = Lamp()",
            f'{IMPORTS}; lamp = Lamp(); run.recorder.signal(0.0, "lamp_level", {DRAWN})',
            id="the testbench",
        ),
    ],
)
def test_what_is_drawn_at_random_is_the_same_in_each_session(
    lamps: pytest.Pytester, file: str, place: str, text: str
) -> None:
    project.change(lamps.path, file, place, text)
    options = ("--hri-suite=by-hand", "-p", "no:xdist")  # measured: coverage draws, too
    lamps.runpytest_inprocess(*options)
    first = records(lamps.path)
    lamps.runpytest_inprocess(*options)
    assert records(lamps.path) == first
    assert len({*first.values()}) == len(first), "each test has its own seed"
    (alone,) = [test["id"] for test in project.report(lamps.path)["tests"]][-1:]
    lamps.runpytest_inprocess(*options, "-k", alone)
    assert records(lamps.path) == {alone: first[alone]}


HASHED = 'float(hash("a lamp") % 1000)'


def in_fresh_process(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, hash_seed: str, *options: str) -> str:
    """Run the suite under a hash seed; returns what was printed, its lines joined where they were wrapped."""
    monkeypatch.setenv("PYTHONHASHSEED", hash_seed)
    result = lamps.runpytest_subprocess("-vv", "--hri-no-cov", "-p", "no:xdist", *options)
    return " ".join(" ".join(result.outlines).split())


@pytest.mark.slow
def test_a_report_says_the_hash_seed_and_a_difference_from_the_baseline_names_it(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    project.change(lamps.path, "lamps/guide.py", ANSWER, says(HASHED))
    suite = ("--hri-suite=by-hand", "--hri-baseline=base.json", "--hri-fail-on-change")
    in_fresh_process(lamps, monkeypatch, "1", *suite, "--hri-update-baseline")
    assert project.report(lamps.path)["origin"]["hash_seed"] == "1"
    other = in_fresh_process(lamps, monkeypatch, "2", *suite)
    assert "FAILED 2 of 4 tests behave differently from the baseline" in other
    assert "Python's hash seed differs from the one before (1, now 2)" in other
    assert "set PYTHONHASHSEED=1 for both" in other
    assert "the model or a library has changed, if it is not the hash seed, or runs depend" in other
    drawn = in_fresh_process(lamps, monkeypatch, "random", *suite)
    assert "Python's hash seed differs from the one before (1, now random)" in drawn
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert 'Hash seed</td><td class="wide">random: drawn by Python' in page
    assert "all 4 tests behave as in the baseline" in in_fresh_process(lamps, monkeypatch, "1", *suite)


@pytest.mark.slow
def test_a_replay_under_another_hash_seed_says_so(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    project.change(lamps.path, "lamps/guide.py", ANSWER, says(HASHED))
    project.change(lamps.path, "requirements.toml", "lamp_level <= 80", "lamp_level <= 5")
    suite = ("--hri-suite=by-hand", "--hri-strict")
    in_fresh_process(lamps, monkeypatch, "1", *suite)
    assert [*(lamps.path / "hri-report" / "failures").iterdir()]
    replay = ("--hri-replay=hri-report/failures", "--hri-report=again")
    other = in_fresh_process(lamps, monkeypatch, "2", *replay)
    assert "Or it is Python's hash seed, 1, now 2 (PYTHONHASHSEED=1 repeats it)" in other
    assert "differs from the recording; cause unknown: --hri-audit looks for it" in other
    assert "it may be Python's hash seed, which was 1, now 2" in other
    assert "the same run, bit for bit" in in_fresh_process(lamps, monkeypatch, "1", *replay)
