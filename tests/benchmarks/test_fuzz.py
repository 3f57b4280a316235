"""Fuzzing: its seeds are sound, an input can be made again, a finding is one; and a portion of inputs."""

from __future__ import annotations

import time
from pathlib import Path
from random import Random

import pytest

from benchmarks.fuzz.__main__ import fuzz
from benchmarks.fuzz.targets import Target, draw
from benchmarks.fuzz.targets import targets as all_targets


@pytest.fixture(scope="module")
def targets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Target]:
    """All readers."""
    return all_targets(tmp_path_factory.mktemp("project"))


@pytest.mark.slow
def test_every_seed_is_accepted(targets: dict[str, Target], tmp_path: Path) -> None:
    assert len(targets) == 18
    for target in targets.values():
        for seed in target.seeds:
            target.read(seed, tmp_path / "input.txt")


@pytest.mark.slow
def test_ten_thousand_inputs_lead_to_documented_errors_only(targets: dict[str, Target], tmp_path: Path) -> None:
    tally = fuzz(10_000, 1, targets, tmp_path, tmp_path / "findings")
    assert not tally.findings
    assert tally.inputs.total() == 10_000
    assert all(tally.refused[name] for name in targets)


def _read(text: str, _: Path) -> None:
    if "a" not in text:
        raise ValueError("x" * 2000 if len(text) > 50 else "\x1b" if "\x1b" in text else "fine")
    if text.startswith("aa"):
        raise KeyError(text)


def test_what_is_not_documented_is_a_finding(tmp_path: Path) -> None:
    toy = {"toy": Target(_read, ["abc", "aabc"], (ValueError,))}
    tally = fuzz(3000, 5, toy, tmp_path, tmp_path / "findings")
    kinds = {finding.partition(":")[2].strip().split(" ")[0] for finding in tally.findings}
    assert kinds == {"KeyError", "a"}
    assert "toy: a message of 2000 characters" in tally.findings
    assert r"toy: a message with '\x1b'" in tally.findings
    assert len([*(tmp_path / "findings").iterdir()]) == len(tally.findings)


def test_what_takes_too_long_is_a_finding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.fuzz.__main__.LIMIT_S", 0.05)
    # The sleep is what takes too long: it is stopped after 0.05 s.
    toy = {"toy": Target(lambda text, _: time.sleep(9), ["abc"], (ValueError,))}
    assert [*fuzz(1, 0, toy, tmp_path, tmp_path).findings] == ["toy: more than 0.05 s"]


def test_an_input_is_a_function_of_its_number() -> None:
    toy = Target(_read, ['{"a": [1, "b"]}'], (), is_json=True)
    assert [draw(toy, Random(f"3:{n}")) for n in range(50)] == [draw(toy, Random(f"3:{n}")) for n in range(50)]
