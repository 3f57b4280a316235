"""Whoever follows the tutorial, and nothing but the tutorial, in an empty folder gets what it says."""

from __future__ import annotations

import json
from pathlib import Path

from tests.docs.page import blocks, commands, differences, run


def test_the_tutorial_leads_to_a_report(tmp_path: Path) -> None:
    ran = 0
    for block in blocks("tutorial.md"):
        if block.kind == "console":
            for command, shown in commands(block.text):
                status, printed = run(command, tmp_path)
                assert not (found := differences(shown, status, printed)), f"$ {command}\n{found}"
                ran += 1
        elif block.name:
            file = tmp_path / block.name
            file.parent.mkdir(exist_ok=True)
            file.write_text(block.text, encoding="utf-8")
    assert ran == 5
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["testbench"] == "coffee"
    assert report["selected"] == report["reported"] > 8
    assert {test["outcome"] for test in report["tests"]} == {"passed"}
