"""Pages whose reader follows them in an empty folder: each file and command gives what the page shows."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from tests.docs.page import blocks, follow

LINES = 200
"""The second tutorial promises fewer."""


def test_the_project_of_the_second_tutorial_is_small() -> None:
    first: dict[str, str] = {}
    for block in blocks("vacuum.md"):
        if block.name and block.name != "test_lifted.py":
            first.setdefault(block.name, block.text)
    assert sum(len(text.splitlines()) for text in first.values()) < LINES
    assert "pytest_hricdv" not in first["vacuum.py"] + first["room.py"]


@pytest.mark.slow
@pytest.mark.skipif(sys.version_info >= (3, 14), reason="there, fields without a default are no statements")
def test_the_second_tutorial_leads_to_a_bug_and_to_its_end(tmp_path: Path) -> None:
    assert follow("vacuum.md", tmp_path) == 6
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["testbench"] == "vacuum"


@pytest.mark.slow
def test_code_of_each_form_runs(tmp_path: Path) -> None:
    assert follow("bring-your-code.md", tmp_path) == 4


@pytest.mark.slow
def test_a_world_in_another_process(tmp_path: Path) -> None:
    assert follow("own-world.md", tmp_path) == 2


@pytest.mark.slow
def test_two_people_lead_to_a_fault_that_takes_both(tmp_path: Path) -> None:
    assert follow("people.md", tmp_path) == 2


@pytest.mark.slow
def test_an_installation_runs_what_init_writes(tmp_path: Path) -> None:
    assert follow("install.md", tmp_path) == 2
