"""Writes the skeleton of a project into a folder."""

from __future__ import annotations

import json
import keyword
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base.message import InputError

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
    """The skeleton cannot be written; the text says why, and what to do."""


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
    """A name of a module that is like a text; that of the template where nothing is left of it.

    >>> name_like("Kitchen-Robot 2")
    'kitchen_robot_2'
    """
    name = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    return name if _NAME.fullmatch(name) and not keyword.iskeyword(name) and name not in _TAKEN else ROBOT
