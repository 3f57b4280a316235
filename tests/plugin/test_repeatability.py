"""Runs of code that draws at random, or goes through a set, are the same in each session and on each worker."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin import project

ANSWER = "bus.publish(Answer())"


def says(text: str) -> str:
    """What the guide does beside its answer, so that the hash of the record depends on it."""
    return f"bus.publish(Switched({text})); {ANSWER}"


def records(folder: Path) -> dict[str, str]:
    """Id of a test -> hash of its record, of the report."""
    return {test["id"]: test["record_sha256"] for test in project.report(folder)["tests"]}


def test_workers_hash_alike_without_a_hash_seed(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", "random")
    project.change(lamps.path, "lamps/guide.py", ANSWER, says('float(hash("a lamp") % 1000)'))
    options = ("--hri-suite=by-hand", "--hri-no-cov", "-n", "1")
    lamps.runpytest_subprocess(*options)
    first = records(lamps.path)
    lamps.runpytest_subprocess(*options)
    assert records(lamps.path) == first
    assert first
