"""Sessions of a testbench with a fault: each in a fork of this process, which has imported the plugin already."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

from pytest_hricdv.report import files
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import Report
from pytest_hricdv.session.child_process import NO_REWRITE_WARNING, limit_processor_time, preload, silence
from studies.localization.faults import Fault
from studies.localization.projects import Project
from studies.session import FINISHED, SessionError

REPORT = "hri-report"

MOST_S = 300
"""A session that takes more processor time (s) is ended. Chosen: one without a fault takes 2 to 20 s."""


def prepared(project: Project, folder: Path) -> None:
    """Write a testbench into a folder, anew, and import what its sessions need."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    project.fill(folder)
    preload()


def ran(project: Project, folder: Path, fault: Fault | None, options: tuple[str, ...] = ()) -> Report | None:
    """The report of a session; None where it had none, as where the code under test cannot be imported.

    Args:
        project: that was prepared in the folder.
        folder: of it.
        fault: in the code; None for the code as it is.
        options: further ones, of pytest.

    Raises:
        SessionError: without a fault, it ran no tests.
    """
    shutil.rmtree(folder / REPORT, ignore_errors=True)
    if fault is None:
        return _session(project, folder, options, is_faulty=False)
    path = folder / fault.file
    path.write_text(fault.text, encoding="utf-8")
    try:
        return _session(project, folder, options, is_faulty=True)
    finally:
        path.write_text(fault.before, encoding="utf-8")


def _session(project: Project, folder: Path, options: tuple[str, ...], *, is_faulty: bool) -> Report | None:
    arguments = [
        *NO_REWRITE_WARNING,
        "-q",
        "--tb=no",
        "--hri-audit=off",
        *project.options,
        f"--hri-report={REPORT}",
        *options,
    ]
    pid = os.fork()
    if pid == 0:
        _run(folder, arguments)
    _, status = os.waitpid(pid, 0)
    code = os.waitstatus_to_exitcode(status)
    try:
        report = load(folder / REPORT)
    except ReportError:
        report = None
    if not is_faulty and (report is None or code not in FINISHED):
        raise SessionError(f"{project.name}: pytest {' '.join(arguments)} in {folder} ended with {code}")
    return report


def _run(folder: Path, arguments: list[str]) -> None:
    """In the fork: a session, and the end of the process."""
    code = 3
    try:
        os.chdir(folder)
        silence(1)
        silence(2)
        sys.dont_write_bytecode = True  # faulty code is not to be found by the next session
        files._page = lambda report: ("", {})  # nobody looks at the page, which takes as long as the tests
        limit_processor_time(MOST_S)
        code = int(pytest.main(arguments))
    finally:
        os._exit(code)
