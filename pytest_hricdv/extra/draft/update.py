"""`hricdv update`: prints what the code has and the testbench lacks, or the other way round (drift).

A child process compares them: it configures pytest, and so builds the testbench as a session does.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.draft.drift import drifts, models_of
from pytest_hricdv.extra.draft.feature import FEATURE
from pytest_hricdv.session.child_process import NO_REWRITE_WARNING, run_configured
from pytest_hricdv.session.run_context import RunContext

SUITE = "pseudorandom"
"""A session needs a suite, although no test is generated; this one needs nothing else."""


def update(folder: Path) -> int:
    """Compare code and testbench of a project, in a process of its own.

    Returns:
        0: no drift; 1: drift; 2 and above: the testbench could not be built, which the process has said.
    """
    if not folder.is_dir():
        print(f"error: {visible(str(folder))}: no such folder; expected that of a project", file=sys.stderr)
        return 2
    command = [sys.executable, "-m", "pytest_hricdv.extra.draft.update"]
    return subprocess.run(command, cwd=folder, check=False).returncode


def compare(context: RunContext, say: Callable[[str], None]) -> int:
    """Tell the drift; returns the exit status: 1 if there is some."""
    testbench, known = context.collection.testbench, FEATURE.settings(context.options)
    roots = [Path(context.collection.config.rootpath), Path.cwd(), *(Path(folder or ".") for folder in sys.path)]
    models, problems = models_of(testbench.code, [root for root in dict.fromkeys(roots) if root.is_dir()])
    every = {drift.key: drift for drift in drifts(models, testbench)}
    outdated = [f"hri_known_drift has {key!r}, which no longer exists" for key in known if key not in every]
    for text in (*problems, *outdated):
        say(text)
    new = [drift for drift in every.values() if drift.key not in known]
    for drift in new:
        say(f"{drift.location or 'conftest.py'}: {drift.text}  [{drift.key}]")
    if declared := [key for key in every if key in known]:
        say(f"known: {', '.join(declared)}")
    if not new:
        say("no drift: the testbench has what the code has")
        return 0
    say("what may be so goes to hri_known_drift, a line each: KIND NAME: reason")
    return 1


# --- the process


def main() -> None:
    """Compare; arguments are those of pytest."""

    def say(text: str) -> None:
        with suppress(BrokenPipeError):  # of whoever read it: the status says the same
            print(visible(text), flush=True)

    def work(context: RunContext) -> None:
        status = compare(context, say)
        with suppress(BrokenPipeError):
            sys.stdout.flush()
        os._exit(status)

    sys.exit(run_configured((f"--hri-suite={SUITE}", *sys.argv[1:], *NO_REWRITE_WARNING), work) or 2)


if __name__ == "__main__":
    main()
