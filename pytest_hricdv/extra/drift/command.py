"""`python -m pytest_hricdv init --update`: what the code has that model and testbench lack, and the lines to add."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

RECORDING = "--recording="
"""How the process is told of a recording."""


def update(folder: Path, *, write: bool, recordings: Sequence[Path] = ()) -> int:
    """Compare code and testbench of a project, in a process of its own.

    Args:
        folder: of the project.
        write: whether to change its conftest file; otherwise the change is shown.
        recordings: of the real system, with which ranges and texts are compared, too.

    Returns:
        0: no drift; 1: drift; 2 and above: the testbench could not be built, which the process has said.
    """
    module = "pytest_hricdv.extra.drift.process"
    command = [sys.executable, "-m", module, "write" if write else "show"]
    command += [f"{RECORDING}{path.absolute()}" for path in recordings]
    return subprocess.run(command, cwd=folder, check=False).returncode
