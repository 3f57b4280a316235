"""A reader who follows the tutorial in an empty folder gets the output that it shows."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from tests.docs.page import follow


@pytest.mark.slow
@pytest.mark.skipif(sys.version_info >= (3, 14), reason="there, fields without a default are no statements")
def test_the_tutorial_leads_to_a_report(tmp_path: Path) -> None:
    assert follow("tutorial.md", tmp_path) == 11
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["testbench"] == "coffee"
    assert report["selected"] == report["reported"] > 8
    assert {test["outcome"] for test in report["tests"]} == {"passed"}
