"""The second tutorial: each file and command of it, and what it says of itself."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from tests.docs.page import blocks, commands, differences, run, write_files

LINES = 200
"""The page promises fewer."""


def test_the_project_is_small(tmp_path: Path) -> None:
    first: dict[str, str] = {}
    for block in blocks("vacuum.md"):
        if block.name and block.name != "test_lifted.py":
            first.setdefault(block.name, block.text)
    assert sum(len(text.splitlines()) for text in first.values()) < LINES
    assert "import pytest_hricdv" not in first["vacuum.py"] + first["room.py"]


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="there, fields without a default are no statements")
def test_it_leads_to_a_bug_and_to_its_end(tmp_path: Path) -> None:
    ran = 0
    for block in blocks("vacuum.md"):
        if block.kind == "console":
            for command, shown in commands(block.text):
                status, printed = run(command, tmp_path)
                assert not (found := differences(shown, status, printed)), f"$ {command}\n{found}"
                ran += 1
        write_files([block], tmp_path)
    assert ran == 6
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert (report["testbench"], report["selected"]) in (("vacuum", 12), ("vacuum", 1))
