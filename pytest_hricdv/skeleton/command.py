"""`hricdv init` and `hricdv update`: create a project, and compare one with code that has changed since."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from pytest_hricdv._base.message import InputError, visible
from pytest_hricdv.registry import offers
from pytest_hricdv.skeleton.skeleton import Skeleton, name_like

OK, USAGE = 0, 2


def add_commands(commands: Any) -> None:
    """Add `init` and `update` to the commands of `hricdv`."""
    init = commands.add_parser(
        "init",
        help="write a project that runs, to be replaced part by part, or draft one from code",
        description="Write a testbench that runs: code under test, world, model of a person, requirements, host test.\n"
        "It asks nothing, and overwrites nothing.",
    )
    init.add_argument("folder", nargs="?", type=Path, default=Path(), help="where to (default: here)")
    init.add_argument("--robot", metavar="NAME", help="name of the module under test (default: that of the folder)")
    init.add_argument("--person", metavar="NAME", default="person", help="name of the person's agent (default: person)")
    init.add_argument(
        "--people", metavar="NAME,NAME", default="", help="names of several people's agents, who act side by side"
    )
    init.add_argument(
        "--from",
        dest="source",
        metavar="PACKAGE[:FUNCTION]",
        help="draft it from code: its messages, states and waits, as a project that runs (docs/draft.md)",
    )
    init.add_argument(
        "--ros2",
        metavar="'PACKAGE EXECUTABLE'",
        help="draft it for a node of ROS 2, as of `ros2 run`, or for PATH.py[:FUNCTION] (docs/draft.md)",
    )
    init.add_argument(
        "--launch",
        metavar="'FILE [NAME:=VALUE ...]'",
        help="draft it for the nodes that a launch file of ROS 2 starts, together as one system (docs/draft.md)",
    )
    init.add_argument(
        "--recording",
        metavar="FILE",
        type=Path,
        action="append",
        default=[],
        help="of a draft, take ranges of times and values from a recording of the real system: a bag of "
        "ROS 2 or an MCAP file; several times for several (docs/draft.md)",
    )
    init.add_argument(
        "--budget",
        type=float,
        default=60.0,
        metavar="S",
        help="of a draft, processor time for its first runs (default: %(default)g)",
    )
    init.add_argument("--no-run", action="store_true", help="of a draft, leave out the first runs: only read the code")
    init.set_defaults(do=_init)
    update = commands.add_parser(
        "update",
        help="tell what a project's code has that testbench and tests lack; exit 1 where there is something",
        description="Compare the code under test with the testbench of a project, and with its last report.",
    )
    update.add_argument("folder", nargs="?", type=Path, default=Path(), help="of the project (default: here)")
    update.set_defaults(do=_update)


def _update(options: argparse.Namespace) -> int:
    try:
        return int(_drafts().update(options.folder))
    except InputError as error:
        print(visible(f"error: update: {error}"), file=sys.stderr)
        return USAGE


def _init(options: argparse.Namespace) -> int:
    try:
        asked = [name for name, value in (("--from", options.source), ("--ros2", options.ros2),
                                          ("--launch", options.launch)) if value]  # fmt: skip
        if len(asked) > 1:
            raise InputError(
                f"expected one of --from, --ros2 and --launch, and {' and '.join(asked)} came: --ros2 and --launch "
                "read the code of their nodes, too"
            )
        if options.recording and not asked:
            raise InputError(
                "--recording: expected --from, --ros2 or --launch, too: its ranges are those of what the code receives"
            )
        if asked or options.ros2 is not None:
            return _draft(options)
        robot = options.robot or name_like(options.folder.resolve().name)
        skeleton = Skeleton(robot, options.people or options.person)
        for name in skeleton.write(options.folder):
            print(visible(str(options.folder / name)))
    except InputError as error:
        print(visible(f"error: init: {error}"), file=sys.stderr)
        return USAGE
    where = "" if options.folder == Path() else f"cd {options.folder}; "
    print()
    print(visible(f"now:  {where}pytest"))
    print(
        visible(f"then: replace {robot}.py with your code, world.py with your simulator, and models/ with your people")
    )
    return OK


def _draft(options: argparse.Namespace) -> int:
    asked = {"launch": options.launch, "ros2": options.ros2, "from": options.source}
    given = {"folder": options.folder, "robot": options.robot or "", "person": options.person,
             "runs": not options.no_run, "recordings": tuple(options.recording),
             "budget_s": options.budget}  # fmt: skip
    for line in _drafts().draft(asked, given):
        print(visible(line), flush=True)
    where = "" if options.folder == Path() else f"cd {options.folder}; "
    print()
    print(visible(f"now:  {where}pytest"))
    print(visible("then: QUESTIONS.md has what the code does not say, the most useful first"))
    return OK


def _drafts() -> Any:
    """The feature that drafts. Raises InputError where the installation has none."""
    offered = offers("command", "INIT")
    if not offered:
        raise InputError("--from, --ros2, --launch and update need the feature `draft`, which is not installed")
    return offered[0]
