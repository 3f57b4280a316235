"""`python -m studies.rclpy_conformance RCLPY_SOURCE`: `rclpy`'s own tests in virtual time, a process for each file."""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv._base.command_line import work_on_unread
from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.ros2.overlay import virtual_rclpy
from pytest_hricdv.runtime.kernel import Kernel
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.virtual.outside import guard_run

_LIMIT_S = 1e9
"""Simulated time for a file: some of the tests have timers with a period of months."""

_RUN_FILE = "run-file"
"""What this module is started with for each file."""

_PACKAGE = "rclpy_tests"
"""What the copy of the tests is called: their own package, `test`, is called as one of Python's library."""

_STOPPED = "stopped the run"
"""The outcome of a test that waits for ever, or has a thread that fails."""

_TIMEOUT_S = 300.0
"""Real time for a file, as a last resort: the kernel finds nodes that hang."""


@dataclass(frozen=True)
class RclpyTestResult:
    """How one test ended: "passed", "failed", "skipped" or `_STOPPED`, and why, in one line."""

    name: str
    outcome: str
    reason: str = ""


@dataclass(frozen=True)
class RclpyFileResult:
    """The tests of one file."""

    file: str
    tests: tuple[RclpyTestResult, ...]

    def count(self, *outcomes: str) -> int:
        """How many ended so."""
        return sum(test.outcome in outcomes for test in self.tests)


class _Collector:
    """A plugin of pytest that notes how each test ended, and which one runs."""

    def __init__(self) -> None:
        self.results: dict[str, RclpyTestResult] = {}
        self.running: str | None = None

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.running = nodeid

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.running = None

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" or report.outcome != "passed":
            self.results[report.nodeid] = RclpyTestResult(report.nodeid, report.outcome, _reason(report))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.results[report.nodeid] = RclpyTestResult(report.nodeid, "failed", _reason(report))


def _reason(report: pytest.TestReport | pytest.CollectReport) -> str:
    if isinstance(report.longrepr, tuple):
        return str(report.longrepr[2]).strip()
    crash = getattr(report.longrepr, "reprcrash", None)
    lines = str(crash.message if crash is not None else report.longrepr or "").strip().splitlines()
    errors = [line[1:].strip() for line in lines if line.startswith("E ")]
    return (errors or lines or [""])[-1 if errors else 0]


def run_file(file: Path, result: Path, deselected: Sequence[str]) -> None:
    """Run the tests of a file in a node of a kernel, and write how they ended; in a process that does nothing else."""
    collector = _Collector()
    ended: list[Any] = []

    def tests() -> None:
        without = [f"--deselect={name}" for name in deselected]
        arguments = ["-q", "-p", "no:cacheprovider", "-W", "ignore", f"--rootdir={file.parent}", str(file), *without]
        ended.append(pytest.main(arguments, plugins=[collector]))

    with virtual_rclpy(_PACKAGE):
        kernel = Kernel()
        kernel.virtual = frozenset({"time", "threading", "asyncio"})
        kernel.spawn("tests", tests)
        try:
            with guard_run(kernel):
                why = f"the run is {kernel.run(_LIMIT_S)}: nobody ends its wait"
        except KernelError as error:
            why = str(error)
    results = list(collector.results.values())
    if not results and ended not in ([pytest.ExitCode.OK], [pytest.ExitCode.NO_TESTS_COLLECTED]):
        why = f"pytest ended with {ended[0]!r} before any test" if ended else why
        results.append(RclpyTestResult(file.name, "failed", why))
    if not ended and collector.running is not None:
        results.append(RclpyTestResult(collector.running, _STOPPED, why))
    written = [vars(test) for test in results]
    result.write_text(json.dumps({"complete": bool(ended), "tests": written}), encoding="utf-8")


def tests_of(source: Path) -> list[Path]:
    """The files of tests in a checkout of `rclpy`.

    Raises:
        InputError: there are none, or `rclpy` cannot be imported.
    """
    files = next((sorted(f.glob("test_*.py")) for f in (source / "rclpy" / "test", source / "test") if f.is_dir()), [])
    if not files:
        raise InputError(f"{source}: no tests of rclpy; expected a checkout of ros2/rclpy, with rclpy/test/test_*.py")
    if importlib.util.find_spec("rclpy") is None:
        raise InputError(
            "rclpy cannot be imported: run `source /opt/ros/DISTRIBUTION/setup.bash` of a ROS 2 distribution, in a "
            "Python of its version; or, on Linux, `pip install ros-rclpy ros-test-msgs`, and then `pip install "
            "--force-reinstall lark`"
        )
    return files


def run_apart(file: Path) -> RclpyFileResult:
    """Run the tests of one file, again without those that stop the run, so that the others are run, too."""
    with tempfile.TemporaryDirectory() as folder:
        tests = Path(folder) / _PACKAGE
        # The package's own __init__ wants the tests to be installed. Some tests read files beside them.
        shutil.copytree(file.parent, tests, ignore=shutil.ignore_patterns("__init__.py", "__pycache__"))
        (tests / "__init__.py").touch()
        results: dict[str, RclpyTestResult] = {}
        while True:
            stopped = [test.name for test in results.values() if test.outcome == _STOPPED]
            read = _run_in_process(tests / file.name, Path(folder) / "result.json", stopped)
            results |= {test.name: test for test in read[1]}
            if read[0] or len(stopped) == sum(test.outcome == _STOPPED for test in results.values()):
                return RclpyFileResult(file.name, tuple(results.values()))


def _run_in_process(file: Path, result: Path, deselected: Sequence[str]) -> tuple[bool, list[RclpyTestResult]]:
    """Whether all tests were run, and how each ended."""
    result.unlink(missing_ok=True)
    command = [sys.executable, "-m", "studies.rclpy_conformance", _RUN_FILE, str(file), str(result), *deselected]
    # No other plugins: this one would run `rclpy` twice in virtual time, and rclpy's tests count on none.
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=_TIMEOUT_S,
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return True, [RclpyTestResult(file.name, "failed", f"not over after {_TIMEOUT_S:g} s")]
    if not result.exists():
        last = (done.stderr.strip() or "no output").splitlines()[-1]
        return True, [RclpyTestResult(file.name, "failed", f"the process ended with {done.returncode}: {last}")]
    read = json.loads(result.read_text(encoding="utf-8"))
    return read["complete"], [RclpyTestResult(**fields) for fields in read["tests"]]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m studies.rclpy_conformance",
        description="Runs the tests of a checkout of ros2/rclpy on the installed rclpy, in virtual time, and prints a "
        "table. Exit code: 0 if no more fail than --may-fail says, 1 otherwise.",
    )
    parser.add_argument("source", type=Path, metavar="RCLPY_SOURCE", help="a checkout of ros2/rclpy of that version")
    parser.add_argument("-k", default="", metavar="TEXT", help="only files with this text in their name")
    parser.add_argument("--may-fail", type=int, default=0, metavar="N", help="how many may fail (0)")
    return parser


def _print_table(results: Sequence[RclpyFileResult]) -> None:
    width = max(len(result.file) for result in results)
    columns = (("passed",), ("failed", "stopped the run"), ("skipped",))
    print(f"\n{'file':{width}}  passed  failed  skipped")
    for result in results:
        counts = f"{result.count('passed'):6}  {result.count(*columns[1]):6}  {result.count('skipped'):7}"
        print(f"{result.file:{width}}  {counts}")
    sums = [sum(result.count(*outcomes) for result in results) for outcomes in columns]
    print(f"{f'{len(results)} files':{width}}  {sums[0]:6}  {sums[1]:6}  {sums[2]:7}")
    others = [test for result in results for test in result.tests if test.outcome != "passed"]
    for test in others:
        print(f"\n{test.outcome}: {test.name}\n    {test.reason}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all files, or one in a process of its own; returns the exit code."""
    words = [*(sys.argv[1:] if arguments is None else arguments)]
    if words[:1] == [_RUN_FILE]:
        run_file(Path(words[1]), Path(words[2]), words[3:])
        sys.stdout.flush()
        os._exit(0)  # threads and destructors of a run that was left are of no interest
    options = _parser().parse_args(words)
    try:
        files = [file for file in tests_of(options.source) if options.k in file.name]
    except InputError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 2
    if not files:
        print(f"ERROR: no file of tests has '{options.k}' in its name", file=sys.stderr)
        return 2
    results = []
    for number, file in enumerate(files, start=1):
        print(f"{number}/{len(files)} {file.name}", file=sys.stderr)
        results.append(run_apart(file))
    _print_table(results)
    return int(sum(result.count("failed", "stopped the run") for result in results) > options.may_fail)


if __name__ == "__main__":
    work_on_unread()
    sys.exit(main())
