"""A reader who follows the tutorial in an empty folder gets the output that it shows."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from tests.docs.page import blocks, commands, differences, run, write_files


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="there, fields without a default are no statements")
def test_the_tutorial_leads_to_a_report(tmp_path: Path) -> None:
    ran = 0
    for block in blocks("tutorial.md"):
        if block.kind == "console":
            for command, shown in commands(block.text):
                status, printed = run(command, tmp_path)
                assert not (found := differences(shown, status, printed)), f"$ {command}\n{found}"
                ran += 1
        write_files([block], tmp_path)
    assert ran == 11
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["testbench"] == "coffee"
    assert report["selected"] == report["reported"] > 8
    assert {test["outcome"] for test in report["tests"]} == {"passed"}
