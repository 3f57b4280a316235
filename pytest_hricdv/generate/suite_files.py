"""Files of abstract tests: their text format (described in `abstract`), and a suite from files.

`parse_tests` reads a text and `dump_tests` writes one, as for `--hri-export`. `Files` is the method that reads a suite
from a text file, a folder of text files, or a JSON file of recorded runs, for `--hri-suite=PATH`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from difflib import get_close_matches
from itertools import islice
from pathlib import Path
from typing import TypeVar

from msgspec import Raw, Struct

from pytest_hricdv._base.input_file import MAX_DIGITS, MalformedError, from_json, read_text
from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.generate import GenerateError, chosen_values, name_place
from pytest_hricdv.generate.abstract import (
    AbstractDraft,
    AbstractTest,
    canonical_command,
    identify,
    slug,
    target_of_commands,
)
from pytest_hricdv.generate.actors import after_from_text, after_to_data, check_after
from pytest_hricdv.generate.beliefs import MAX_TESTS
from pytest_hricdv.generate.context import GenerationContext, evenly_spaced
from pytest_hricdv.generate.suite import Generation, Suite

T = TypeVar("T")

_HEADER = re.compile(r"#\s*(id|suite|target|beliefs|seed|name|plans \S+|values \S+|after \S+)\s*:(.*)\Z")
_LIKE_HEADER = re.compile(r"#\s*(\w+)(?:[ \t]+\S+)?\s*:")
_FORMS = {"plans": "plans AGENT", "values": "values NUMBER", "after": "after NUMBER"}
_KEYS = ("id", "suite", "target", "beliefs", "seed", "name", "plans", "values", "after")


@dataclass
class _Block:
    """The lines between two blank lines: a test, or comments only."""

    where: str = ""
    headers: dict[str, str] = field(default_factory=dict)
    commands: list[str] = field(default_factory=list)
    values: dict[int, dict[str, float]] = field(default_factory=dict)
    value_places: dict[int, str] = field(default_factory=dict)
    after: dict[int, tuple[int, ...]] = field(default_factory=dict)
    after_places: dict[int, str] = field(default_factory=dict)

    @property
    def is_test(self) -> bool:
        """Commands make a test; so does an id alone, as a test may have no action."""
        return bool(self.commands) or "id" in self.headers


def dump_tests(tests: Iterable[AbstractTest]) -> str:
    """The tests as text that `parse_tests` reads back unchanged."""
    return "\n".join(_dump(test) for test in tests)


def _dump(test: AbstractTest) -> str:
    headers = [f"# id: {test.id}", f"# suite: {test.suite}", f"# target: {test.target}", f"# seed: {test.seed}"]
    if test.beliefs:
        headers.append(f"# beliefs: {' '.join(test.beliefs)}")
    if test.name:
        headers.append(f"# name: {test.name}")
    headers += [f"# plans {agent}: {' '.join(labels)}".rstrip() for agent, labels in sorted(test.plans.items())]
    headers += [f"# values {key}: {text}" for key, text in chosen_values.to_text(test.values).items()]
    after = after_to_data(test.after).items()
    headers += [f"# after {number}: {' '.join(map(str, causes))}" for number, causes in after]
    return "\n".join([*headers, *test.lines]) + "\n"


def parse_tests(
    text: str, *, file: str, suite: str, master_seed: int = 0, commands: Collection[str] = ()
) -> tuple[AbstractTest, ...]:
    """The tests of a text.

    A test that states an id keeps it; others get id and seed from their content.

    Args:
        file: name of the text in errors.
        suite: the suite of tests that state none.
        master_seed: for the seeds of tests that state none.
        commands: those that can be executed; if any are given, others are errors.

    Raises:
        GenerateError: a malformed or unknown command or a malformed header, with file, line and column.
    """
    blocks = [block for block in _blocks(text, file, commands) if block.is_test]
    complete = [_complete_test(block) if "id" in block.headers else None for block in blocks]
    _check_ids(blocks)
    drafts: dict[str, list[AbstractDraft]] = {}
    for block, test in zip(blocks, complete, strict=True):
        if test is None:
            drafts.setdefault(block.headers.get("suite", suite), []).append(_draft_of_block(block))
    identified = {name: iter(identify(name, master_seed, listed)) for name, listed in drafts.items()}
    return tuple(
        test if test is not None else next(identified[block.headers.get("suite", suite)])
        for block, test in zip(blocks, complete, strict=True)
    )


def _check_ids(blocks: Iterable[_Block]) -> None:
    places: dict[str, str] = {}
    for block in blocks:
        name = block.headers.get("id")
        if name is not None and name in places:
            raise GenerateError(
                f"{block.where}: a second test with the id {name!r}, which is at {places[name]} already; expected "
                "each id once: without its '# id:' line a test gets a new one"
            )
        places |= {} if name is None else {name: block.where}


def _blocks(text: str, file: str, commands: Collection[str]) -> list[_Block]:
    blocks = [_Block()]
    for number, line in enumerate(text.splitlines(), 1):
        stripped = line.strip()
        if not stripped:
            if blocks[-1].where:  # else nothing has been in it
                blocks.append(_Block())
            continue
        where = f"{file}:{number}:{len(line) - len(line.lstrip()) + 1}"
        if stripped.startswith("#"):
            _read_comment(blocks[-1], stripped, where)
        else:
            blocks[-1].where = blocks[-1].where or where
            blocks[-1].commands.append(_read_command(stripped.partition("#")[0], where, commands))
        if blocks[-1].where and len(blocks) > MAX_TESTS:
            raise GenerateError(f"{where}: more than {MAX_TESTS} tests up to here; expected fewer in one file")
    return blocks


def _read_comment(block: _Block, comment: str, where: str) -> None:
    match = _HEADER.match(comment)
    if match is None:
        _refuse_misspelt(comment, where)
        return
    key, value = match[1], " ".join(match[2].split())
    if key in block.headers:
        raise GenerateError(f"{where}: a second '# {key}:' in one test; expected a blank line between tests")
    if key == "seed" and not (value.isascii() and value.isdigit() and len(value) <= MAX_DIGITS):
        raise GenerateError(f"{where}: seed {quote(value)}: expected a whole number, at least 0 and below 2**63")
    if key.startswith("values "):
        _read_values(block, key, value, where)
    if key.startswith("after "):
        _read_after(block, key, value, where)
    block.where = block.where or where
    block.headers[key] = value


def _refuse_misspelt(comment: str, where: str) -> None:
    like = _LIKE_HEADER.match(comment)
    if like is None:
        return
    for key in get_close_matches(like[1].lower(), _KEYS, n=1, cutoff=0.75):
        raise GenerateError(
            f"{where}: {quote(comment)} is not a field of a test; nearest: '# {_FORMS.get(key, key)}: ...'; a comment "
            "has no such word before a colon"
        )


def _read_values(block: _Block, key: str, text: str, where: str) -> None:
    with name_place(where):
        number = chosen_values.read_key(key.split()[1])
        block.values[number], block.value_places[number] = chosen_values.read_text(text), where


def _read_after(block: _Block, key: str, text: str, where: str) -> None:
    with name_place(where):
        (number,) = after_from_text(key.split()[1])
        block.after[number], block.after_places[number] = after_from_text(text), where


def _read_command(text: str, where: str, commands: Collection[str]) -> str:
    try:
        command = canonical_command(text)
    except GenerateError as error:
        raise GenerateError(f"{where}: {error}{nearest(text.strip(), commands)}") from None
    if commands and command not in commands:
        raise GenerateError(f"{where}: unknown command {quote(command)}{nearest(command, commands)}")
    return command


def _plans(block: _Block) -> dict[str, tuple[str, ...]]:
    return {key.split()[1]: tuple(value.split()) for key, value in block.headers.items() if key.startswith("plans ")}


def _draft_of_block(block: _Block) -> AbstractDraft:
    headers = block.headers
    for number, values in block.values.items():
        with name_place(block.value_places[number]):
            chosen_values.check({number: values}, len(block.commands))
    for number, causes in block.after.items():
        with name_place(block.after_places[number]):
            check_after({number: causes}, block.commands)
    name = headers.get("name", "")
    # 40 characters: the id of a named test, with its suite and eight digits, still fits a line of a terminal.
    target = headers.get("target") or (slug(name)[:40].rstrip("-") if name else target_of_commands(block.commands))
    beliefs = tuple(headers.get("beliefs", "").split())
    return AbstractDraft(target, beliefs, tuple(block.commands), _plans(block), name, block.values, after=block.after)


def _complete_test(block: _Block) -> AbstractTest:
    missing = [key for key in ("suite", "target", "seed") if key not in block.headers]
    if missing:
        raise GenerateError(
            f"{block.where}: test {block.headers['id']!r} has an id but no {missing[0]}; "
            f"expected '# {missing[0]}: ...' next to it, or no id at all"
        )
    draft = _draft_of_block(block)
    with name_place(block.where):
        return draft.as_test(block.headers["id"], block.headers["suite"], int(block.headers["seed"]))


@dataclass(frozen=True)
class Files:
    """The suite of tests from files.

    `path` is a text file (its format: see `abstract`), a folder with text files (`*.txt`, subfolders included), or a
    JSON file `{suite: [{"n": 1, "steps": [command, ...]}, ...]}`. Its entries without steps (null) are left out and
    counted. Tests without an id get one from their content and the name of their file, or of their suite in JSON.
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
            read = _from_json(self.path, context, notes)
        else:
            read = self._from_text(context)
        tests = tuple(islice(read, MAX_TESTS + 1))  # one too many is enough to be refused
        if len(tests) > MAX_TESTS:
            raise GenerateError(f"{self.path}: more than {MAX_TESTS} tests; expected fewer in one file or folder")
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
            if path != self.path and path.is_symlink():
                raise GenerateError(f"{path}: a symbolic link, which is not followed in a folder: name its target")
            suite = slug(path.stem)
            for test in parse_tests(
                _read(path), file=str(path), suite=suite, master_seed=context.seed, commands=context.commands
            ):
                if test.id in file_of:
                    raise GenerateError(
                        f"{path}: test {test.id!r} is in {file_of[test.id]} already; expected each id once: "
                        "remove one of them"
                    )
                file_of[test.id] = path
                yield test


def _read(path: Path) -> str:
    try:
        return read_text(path)
    except (FileNotFoundError, MalformedError) as error:
        fault = ": no such file" if isinstance(error, FileNotFoundError) else error
        raise GenerateError(f"{path}{fault}; expected a file of abstract tests") from None


class _Entry(Struct):
    """A recorded run; a note names its other keys."""

    steps: list[str] | None
    n: int | float | str | None = None


def _from_json(path: Path, context: GenerationContext, notes: list[str]) -> Iterator[AbstractTest]:
    for suite, text in _decode(str(path), _read(path), dict[str, Raw]).items():
        where = f"{path}: suite {quote(suite)}"
        entries = _decode(where, str(text, "utf-8"), list[_Entry])
        notes += _other_keys(where, _decode(where, str(text, "utf-8"), list[dict[str, Raw]]))
        drafts = [
            _draft_of_entry(path, suite, place, entry, context)
            for place, entry in enumerate(entries[: MAX_TESTS + 1], 1)  # one too many is enough to be refused
        ]
        recorded = [draft for draft in drafts if draft is not None]
        if len(recorded) < len(drafts):
            notes.append(
                f"{suite}: {len(drafts) - len(recorded)} of {len(drafts)} entries have no steps and are left out"
            )
        yield from identify(slug(suite), context.seed, recorded)


def _other_keys(where: str, entries: list[dict[str, Raw]]) -> Iterator[str]:
    """A note on keys that no test has, as results of a recorded run. Raises GenerateError for a misspelt one."""
    others = sorted({key for entry in entries for key in entry} - set(_Entry.__struct_fields__))
    for key in others:
        if similar := get_close_matches(key.lower(), _Entry.__struct_fields__, n=1, cutoff=0.75):
            raise GenerateError(f"{where}: unknown key {quote(key)}; nearest: {similar[0]}")
    if others:
        yield f"{where}: not read: {', '.join(map(quote, others))}"


def _decode(where: str, text: str, kind: type[T]) -> T:
    try:
        return from_json(text, kind)
    except MalformedError as error:
        expected = "expected an object of suites, each a list of tests with 'steps', a list of commands or null"
        raise GenerateError(f"{where}{error}; {expected}") from None


def _draft_of_entry(
    path: Path, suite: str, place: int, entry: _Entry, context: GenerationContext
) -> AbstractDraft | None:
    """The draft of an entry; None if its steps were not recorded."""
    if entry.steps is None:
        return None
    where = f"{path}: suite {quote(suite)}, entry {place}"
    lines = tuple(
        _read_command(step, f"{where}, step {number}", context.commands) for number, step in enumerate(entry.steps, 1)
    )
    name = "" if entry.n is None else f"{suite} {entry.n}"
    return AbstractDraft(target_of_commands(lines), (), lines, {}, " ".join(name.split()))
