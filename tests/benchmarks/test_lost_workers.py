"""Campaigns whose workers, client and scheduler are killed, on a project whose runs take milliseconds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.extra.campaign.conftest import environment
from tests.plugin import project


@pytest.mark.slow
def test_the_report_is_that_of_a_campaign_that_nobody_disturbs(tmp_path: Path) -> None:
    project.write(tmp_path)
    size = ("--suite=bdi-random", "--tests=4", "--concretizations=250")
    kills = ("--workers=3", "--clients=1", "--pace=1")
    arguments = [sys.executable, "-m", "benchmarks.lost_workers", *size, *kills, f"--root={tmp_path}"]
    done = subprocess.run(arguments, env=environment(), capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("expected 1,000, stored 1,000: 0 failed, 0 lost") == 2
    assert "killed: " in done.stdout
    assert done.stdout.rstrip().endswith("the reports are the same, times aside")
