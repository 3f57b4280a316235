"""The bug of the tutorial is found by repairing it: the first place is its statement, and the hint is what mends it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.page import blocks, write_files


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="repairs are tried in forks")
def test_a_repair_of_the_tutorials_bug_is_a_hint(tmp_path: Path) -> None:
    write_files(blocks("tutorial.md"), tmp_path)
    pouring = tmp_path / "pouring.py"
    text = pouring.read_text(encoding="utf-8")
    assert text.count("scale.cup_is_there() and ") == 1
    pouring.write_text(text.replace("scale.cup_is_there() and ", ""), encoding="utf-8")
    arguments = [sys.executable, "-m", "pytest", "--hri-tests=8", "--hri-diagnose=40", "--hri-audit=off"]
    done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 1, done.stdout
    (cause,) = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))["causes"]
    assert (cause["places"][0]["file"], cause["places"][0]["function"]) == ("pouring.py", "pour")
    assert cause["places"][0]["text"].startswith("while scale.level_ml()")
    assert cause["hints"][0].startswith("with the condition `scale.cup_is_there() and (")
    assert cause["hints"][0].endswith("3 of 3 failing tests pass, none of 2 others changes")
    assert "Might mend it" in (tmp_path / "hri-report" / "index.html").read_text(encoding="utf-8")
