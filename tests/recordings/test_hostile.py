"""Damaged and hostile recordings end with a sentence that names them, in bounded memory and time."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.recordings.recording import read_recordings
from tests.recordings.hostile import HOSTILE

QUICK = ("name with %2F", "name with # and ?", "endless view", "integer of 400 digits", "deep JSON", "aliases of YAML")


@pytest.mark.parametrize("case", QUICK)
def test_it_is_read_as_it_is_or_named(case: str, tmp_path: Path) -> None:
    make, said = HOSTILE[case]
    made = make(tmp_path)
    before = {*tmp_path.rglob("*")}
    (recording,) = read_recordings([made], lambda topic: True, lambda kind: None)
    assert said in " ".join(recording.problems)
    assert {*tmp_path.rglob("*")} == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory and pipes of Linux")
def test_each_is_named_in_bounded_memory_and_time(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tests.recordings.hostile", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=Path(__file__).parents[2])
    *read, peak, new = map(json.loads, done.stdout.splitlines())
    assert [case["name"] for case in read] == [*HOSTILE]
    unnamed = [case for case in read if HOSTILE[case["name"]][1] not in " ".join(case["said"])]
    assert unnamed == []
    assert [case for case in read if case["s"] > 60.0] == []  # seconds, on a machine with nothing else to do
    assert peak["peak"] < 700_000_000
    assert new["new"] == []
