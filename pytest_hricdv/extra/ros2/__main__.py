"""`python -m pytest_hricdv.ros2`: how far nodes behave in virtual time as on a middleware of ROS 2."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from pytest_hricdv._base.message import InputError
from pytest_hricdv._base.output import work_on_unread
from pytest_hricdv.extra.ros2.rclpy_tests import RclpyFileResult, run_apart, run_file, tests_of


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m pytest_hricdv.ros2", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    check = commands.add_parser(
        "conformance",
        help="run rclpy's own tests in virtual time",
        description="Runs the tests of a checkout of ros2/rclpy on the installed rclpy, in virtual time, and prints a "
        "table. Exit code: 0 if no more fail than --may-fail says, 1 otherwise.",
    )
    check.add_argument("source", type=Path, metavar="RCLPY_SOURCE", help="a checkout of ros2/rclpy of that version")
    check.add_argument("-k", default="", metavar="TEXT", help="only files with this text in their name")
    check.add_argument("--may-fail", type=int, default=0, metavar="N", help="how many may fail (0)")
    run_one = commands.add_parser("run-file")  # what "conformance" starts a process of for each file
    run_one.add_argument("file", type=Path)
    run_one.add_argument("result", type=Path)
    run_one.add_argument("deselected", nargs="*")
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
    """Run a command; returns the exit code."""
    options = _parser().parse_args(arguments)
    if options.command == "run-file":
        run_file(options.file, options.result, options.deselected)
        sys.stdout.flush()
        os._exit(0)  # threads and destructors of a run that was left are of no interest
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
