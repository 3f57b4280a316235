"""`python -m pytest_hricdv init --update`: what the code has that model and testbench lack, and the lines to add.

It compares in a process that configures pytest, so that the testbench is that of a session.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.draft.feature import FEATURE, find_drift
from pytest_hricdv.extra.draft.proposal import add_lines, difference
from pytest_hricdv.hooks import HOOK
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.serving import UNWARNED, in_session

SUITE = "pseudorandom"
"""Nothing is generated, but a session needs a suite, and this one needs nothing of a testbench."""


def update(folder: Path, *, write: bool) -> int:
    """Compare code and testbench of a project, in a process of its own.

    Args:
        folder: of the project.
        write: whether to change its conftest file; otherwise the change is shown.

    Returns:
        0: no drift; 1: drift; 2 and above: the testbench could not be built, which the process has said.
    """
    command = [sys.executable, "-m", "pytest_hricdv.extra.draft.update", "write" if write else "show"]
    return subprocess.run(command, cwd=folder, check=False).returncode


def compare(context: RunContext, *, write: bool, say: Callable[[str], None]) -> int:
    """Tell the drift, and the change of the conftest file; returns the exit status: 1 where there is drift."""
    tests, of_tests = _tests(context)
    result = find_drift(context, tests, FEATURE.settings(context.options).known)
    for text in (of_tests, *result.problems, *result.outdated):
        if text:
            say(text)
    for drift in result.new:
        say(f"{drift.location or 'conftest.py'}: {drift.text}  [{drift.key}]")
    if result.known:
        say(f"known: {', '.join(drift.key for drift in result.known)}")
    path = _conftest(context)
    before = path.read_text(encoding="utf-8")
    if not result.new:
        say("no drift: testbench and tests have what the code has")
        return 0
    _propose(context, (path, before, add_lines(before, result.new)), write=write, say=say)
    return 1


def _conftest(context: RunContext) -> Path:
    hook = getattr(context.collection.config.hook, HOOK)
    return Path(hook.get_hookimpls()[-1].function.__code__.co_filename)


def _propose(context: RunContext, change: tuple[Path, str, str], *, write: bool, say: Callable[[str], None]) -> None:
    """Show a change of a file, its text before and after; or write it."""
    path, before, after = change
    say("")
    if after == before:
        say("nothing of it is a line of conftest.py: plans and disturbances lead to states; what may be so goes to")
        say("hri_known_drift in the ini file, one a line: KIND NAME: reason")
    elif write:
        write_text(path, after)
        say(f"{path}: changed; review it, above all the ranges")
    else:
        name = os.path.relpath(path, context.collection.config.invocation_params.dir)
        for line in difference(before, after, name).splitlines():
            say(line)
        say("")
        say("nothing was written: the same with --write changes the file")


def _tests(context: RunContext) -> tuple[tuple[TestResult, ...] | None, str]:
    """The tests of the last report, and what is to be said where there are none."""
    folder = context.options.report
    try:
        report = load(folder)
    except ReportError:
        return None, f"no report in {folder}: run pytest first, and states that no plan leads to are told, too"
    return report.tests, ""


def main() -> None:
    """Compare; arguments are `--write` or nothing, and then those of pytest."""
    write, rest = sys.argv[1] == "write", sys.argv[2:]

    def say(text: str) -> None:
        with suppress(BrokenPipeError):  # of whoever read it: the status says the same
            print(visible(text), flush=True)

    def work(context: RunContext) -> None:
        status = compare(context, write=write, say=say)
        with suppress(BrokenPipeError):
            sys.stdout.flush()
        os._exit(status)

    sys.exit(in_session((f"--hri-suite={SUITE}", *rest, *UNWARNED), work) or 2)


if __name__ == "__main__":
    main()
