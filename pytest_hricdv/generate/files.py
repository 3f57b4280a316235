"""Tests from files: text files, folders of them, or a JSON file of recorded runs."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest_hricdv.generate.abstract import AbstractTest, canonical_command
from pytest_hricdv.generate.context import GenerationContext, evenly_spaced
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.ids import Draft, identify, slug
from pytest_hricdv.generate.suite import Generation, Suite
from pytest_hricdv.generate.text_format import parse_tests, target_of_commands
from pytest_hricdv.suggestion import nearest


@dataclass(frozen=True)
class Files:
    """Abstract tests that exist already.

    `path` is a text file (see `text_format`), a folder with text files (`*.txt`, subfolders included), or a JSON file
    `{suite: [{"n": 1, "steps": [command, ...]}, ...]}`. Its entries without steps (null) are left out and counted.
    Tests without an id get one from their content and the name of their file, or of their suite in JSON.
    """

    path: Path

    @property
    def name(self) -> str:
        """The file's or the folder's name, in the characters of an id."""
        return slug(self.path.stem if self.path.is_file() else self.path.resolve().name)

    def generate(self, context: GenerationContext) -> Suite:
        """Read the tests; with `GenerationContext.tests`, that many of them, evenly spaced.

        The suite has the name that all its tests state, or else the name of the file.

        Raises:
            GenerateError: there is nothing to read, or something in it is wrong; with file, line and column.
        """
        notes: list[str] = []
        if self.path.suffix == ".json" and self.path.is_file():
            tests = tuple(_from_json(self.path, context, notes))
        else:
            tests = tuple(self._from_text(context))
        if not tests:
            raise GenerateError(f"{self.path}: no tests in it; expected at least one")
        if context.tests is not None and context.tests > len(tests):
            notes.append(f"{context.tests} tests asked for, but {self.path.name} has {len(tests)} only")
        if repeats := len(tests) - len({test.lines for test in tests}):
            notes.append(f"{repeats} of {len(tests)} tests repeat the commands of others")
        kept = evenly_spaced(tests, min(context.tests or len(tests), len(tests)))
        suites = {test.suite for test in tests}
        name = suites.pop() if len(suites) == 1 else self.name
        return Suite.of_tests(name, context.seed, kept, Generation(notes=tuple(notes)))

    def _from_text(self, context: GenerationContext) -> Iterator[AbstractTest]:
        paths = sorted(self.path.rglob("*.txt")) if self.path.is_dir() else [self.path]
        if not paths:
            raise GenerateError(f"{self.path}: no text file (*.txt) in this folder; expected at least one")
        file_of: dict[str, Path] = {}
        for path in paths:
            suite = slug(path.stem)
            for test in parse_tests(
                _read(path), file=str(path), suite=suite, master_seed=context.seed, known=context.commands
            ):
                if test.id in file_of:
                    raise GenerateError(
                        f"{path}: test {test.id!r} is in {file_of[test.id]} already; expected each id once: "
                        "take one of the two away"
                    )
                file_of[test.id] = path
                yield test


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise GenerateError(f"{path}: {error}; expected a file of abstract tests") from error


def _from_json(path: Path, context: GenerationContext, notes: list[str]) -> Iterator[AbstractTest]:
    try:
        data = json.loads(_read(path))
    except json.JSONDecodeError as error:
        raise GenerateError(f"{path}:{error.lineno}:{error.colno}: {error.msg}") from None
    if not isinstance(data, dict):
        raise GenerateError(f"{path}:1:1: a JSON {type(data).__name__}; expected an object of suites")
    for suite, entries in data.items():
        if not isinstance(entries, list):
            raise GenerateError(f"{path}: suite {suite!r} is {entries!r}; expected a list of tests")
        drafts = [_draft(path, suite, place, entry, context) for place, entry in enumerate(entries, 1)]
        recorded = [draft for draft in drafts if draft is not None]
        if len(recorded) < len(drafts):
            notes.append(
                f"{suite}: {len(drafts) - len(recorded)} of {len(drafts)} entries have no steps and are left out"
            )
        yield from identify(slug(suite), context.seed, recorded)


def _draft(path: Path, suite: str, place: int, entry: Any, context: GenerationContext) -> Draft | None:
    """The draft of an entry; None if its steps were not recorded."""
    where = f"{path}: suite {suite!r}, entry {place}"
    if not isinstance(entry, dict) or "steps" not in entry:
        raise GenerateError(f"{where}: expected an object with 'steps', a list of commands or null")
    steps = entry["steps"]
    if steps is None:
        return None
    if not isinstance(steps, list) or not all(isinstance(step, str) for step in steps):
        raise GenerateError(f"{where}: steps {steps!r}; expected a list of commands or null")
    lines = []
    for number, step in enumerate(steps, 1):
        try:
            command = canonical_command(step)
        except GenerateError as error:
            raise GenerateError(f"{where}, step {number}: {error}{nearest(step, context.commands)}") from None
        if context.commands and command not in context.commands:
            raise GenerateError(
                f"{where}, step {number}: unknown command {command!r}{nearest(command, context.commands)}"
            )
        lines.append(command)
    name = f"{suite} {entry['n']}" if "n" in entry else ""
    return Draft(target_of_commands(lines), (), tuple(lines), {}, " ".join(name.split()))
