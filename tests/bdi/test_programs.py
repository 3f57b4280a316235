"""Whole programs print what is expected: for the reference programs, what Jason printed for them."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import MultiAgentSystem


def _programs(folder: str) -> list[Path]:
    folders = sorted(file.parent for file in (Path(__file__).parent / folder).glob("*/expected.txt"))
    assert folders, f"no programs in {folder}: the tests would pass without any"
    return folders


PROGRAMS = _programs("programs")
REFERENCE_PROGRAMS = _programs("reference_programs")


@pytest.mark.parametrize("folder", [*PROGRAMS, *REFERENCE_PROGRAMS], ids=lambda folder: folder.name)
def test_program_prints_what_is_expected(folder: Path) -> None:
    result = MultiAgentSystem.load(folder / "mas.mas2j").run(max_rounds=10_000)
    assert result.prints == (folder / "expected.txt").read_text(encoding="utf-8").splitlines()
    assert result.ended == "idle"


@pytest.mark.parametrize("folder", [*PROGRAMS, *REFERENCE_PROGRAMS], ids=lambda folder: folder.name)
def test_every_run_of_a_loaded_system_is_the_same(folder: Path) -> None:
    system = MultiAgentSystem.load(folder / "mas.mas2j")
    assert system.run() == system.run()


def test_all_reference_programs_are_there() -> None:
    assert [folder.name for folder in REFERENCE_PROGRAMS] == [
        *("annotations", "arithmetic", "ask_one", "belief_events", "context_first_applicable", "fail_goal"),
        *("interleave_two_intentions", "nested_control", "no_applicable", "rules_backtracking", "tell_two"),
        "wait_and_time",
    ]
