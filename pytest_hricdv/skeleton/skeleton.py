"""`hricdv init` and `hricdv update`: write the skeleton of a project, compare a project with code that has changed."""

from __future__ import annotations

import argparse
import json
import keyword
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base.message import InputError, visible
from pytest_hricdv.registry import offers

TEMPLATE = Path(__file__).parent / "template"

PEOPLE = Path(__file__).parent / "people"
"""The files that are others where there are several people."""

TWO_PEOPLE = '("my_person", "my_other")'
"""In them, the names of the people."""

ROBOT, PERSON = "my_robot", "my_person"
"""The names in the template that stand for those of the project."""

_NAME = re.compile(r"[a-z][a-z0-9_]*")
# A module of this name would hide another one, or be a second file of that name.
_TAKEN = ("world", "conftest", "meta", "models", "pytest", "pytest_hricdv")


class SkeletonError(InputError):
    """The skeleton cannot be written; the message says why, and what to do."""


@dataclass(frozen=True)
class Skeleton:
    """A project to begin with.

    Args:
        robot: the name of the module under test, of the testbench, and of the host test.
        person: the name of the agent that models the person; of several, with commas between them.

    Raises:
        SkeletonError: a name that cannot be one of a module and of an agent, or that is taken.
    """

    robot: str
    person: str

    def __post_init__(self) -> None:
        option = "person" if len(self.people) == 1 else "people"
        for option, name in (("robot", self.robot), *((option, name) for name in self.people)):
            if not _NAME.fullmatch(name) or keyword.iskeyword(name):
                raise SkeletonError(
                    f"--{option}={name}: expected a name of small letters, digits and underscores that begins with a "
                    f"letter, such as {name_like(name)}"
                )
            if name in _TAKEN:
                raise SkeletonError(f"--{option}={name}: a file of the skeleton has this name; choose another one")
        if self.robot in self.people:
            raise SkeletonError(f"--robot and --{option}: both are {self.robot}; expected two names")
        if len(set(self.people)) < len(self.people):
            raise SkeletonError(f"--people={self.person}: expected each name once")

    @property
    def people(self) -> tuple[str, ...]:
        """The names of the agents that model people."""
        return tuple(self.person.split(","))

    def files(self) -> Iterator[tuple[str, str]]:
        """Name, relative to the project's folder, and content of each file."""
        templates = _files(TEMPLATE) | (_files(PEOPLE) if len(self.people) > 1 else {})
        for name, text in sorted(templates.items()):
            for person in self.people if PERSON in name else (self.person,):
                yield self._insert_names(name, person), self._insert_names(text, person)

    def _insert_names(self, text: str, person: str) -> str:
        people = json.dumps(self.people).replace("[", "(").replace("]", ")")
        agents = "; ".join(self.people)
        named = text.replace(TWO_PEOPLE, people).replace(f"; {PERSON}; }}", f"; {agents}; }}")
        return named.replace(ROBOT, self.robot).replace(PERSON, person)

    def write(self, folder: Path) -> tuple[str, ...]:
        """Write all files; returns their names.

        Raises:
            SkeletonError: a file exists, then none is written; or the folder cannot be written.
        """
        files = dict(self.files())
        there = [name for name in files if (folder / name).exists()]
        if there:
            raise SkeletonError(f"{folder / there[0]} exists: nothing was written; choose an empty folder")
        try:
            for name, text in files.items():
                atomic_file.write_text(folder / name, text)
        except OSError as error:
            raise SkeletonError(f"{folder}: cannot be written: {error.strerror or error}") from None
        return tuple(files)


def _files(folder: Path) -> dict[str, str]:
    """Name, relative to the folder, and text of each file in it."""
    # Installers compile what they install, the templates among it.
    paths = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"]
    return {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def name_like(text: str) -> str:
    """A module name made from a text; the template's if nothing is left of it.

    >>> name_like("Kitchen-Robot 2")
    'kitchen_robot_2'
    """
    name = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    return name if _NAME.fullmatch(name) and not keyword.iskeyword(name) and name not in _TAKEN else ROBOT


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
        "--recording",
        metavar="FILE",
        type=Path,
        action="append",
        default=[],
        help="of a draft, take values from a recording: of hricdv record, or of the real system, a bag of "
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
        help="tell what a project's code has that its testbench lacks; exit 1 where there is something",
        description="Compare the code under test with the testbench of a project.",
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
        asked = bool(options.source or options.ros2)
        if options.source and options.ros2:
            raise InputError("expected --from or --ros2, and both came: --ros2 reads the code of the node, too")
        if options.recording and not asked:
            raise InputError(
                "--recording: expected --from or --ros2, too: its ranges are those of what the code receives"
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
    asked = {"ros2": options.ros2, "from": options.source}
    settings = {
        "folder": options.folder,
        "robot": options.robot or "",
        "person": options.person,
        "runs": not options.no_run,
        "recordings": tuple(options.recording),
        "budget_s": options.budget,
    }
    for line in _drafts().draft(asked, settings):
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
        raise InputError("--from, --ros2 and update need the feature `draft`, which is not installed")
    return offered[0]
