"""Whole programs print what Jason prints for them."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import MultiAgentSystem

OWN = sorted((Path(__file__).parent / "programs").iterdir())
_REFERENCE = Path(__file__).parents[3] / "shared" / "reference" / "jason_programs"
REFERENCE = sorted(_REFERENCE.iterdir()) if _REFERENCE.is_dir() else []


@pytest.mark.parametrize("folder", [*OWN, *REFERENCE], ids=lambda folder: folder.name)
def test_program_prints_what_is_expected(folder: Path) -> None:
    result = MultiAgentSystem.load(folder / "mas.mas2j").run(max_rounds=10_000)
    assert result.prints == (folder / "expected.txt").read_text(encoding="utf-8").splitlines()
    assert result.ended == "idle"


@pytest.mark.parametrize("folder", OWN, ids=lambda folder: folder.name)
def test_every_run_of_a_loaded_system_starts_afresh(folder: Path) -> None:
    system = MultiAgentSystem.load(folder / "mas.mas2j")
    assert system.run() == system.run()
