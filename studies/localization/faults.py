"""Faults that are put into code under test, and the places that count as pointing at each."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from pytest_hricdv.coverage.code_map import CodeMap, SourceFile
from pytest_hricdv.coverage.gaps import functions
from pytest_hricdv.extra.mutation.mutants import all_mutants, sample

HALVES = ("even", "odd")
"""Of the planted faults, by their position in the list from 0 on."""

PLANTED = Path(__file__).with_name("planted.toml")


class FaultError(Exception):
    """A planted fault that does not fit the code; the text says which."""


@dataclass(frozen=True)
class Fault:
    """Code under test with a fault.

    Args:
        id: within its testbench.
        kind: `planted`, or the operator of a mutant.
        file: name of the changed file.
        before: its text without the fault.
        text: its text.
    """

    id: str
    kind: str
    file: str
    before: str
    text: str


@dataclass(frozen=True)
class Truth:
    """What counts as pointing at a fault.

    Args:
        file: name.
        statements: by their first lines in the faulty text: those that differ, and where something is missing, the
            ones before and after it.
        functions: that it is in.
        is_omission: something is missing, and nothing stands in its place.
    """

    file: str
    statements: frozenset[int]
    functions: frozenset[str]
    is_omission: bool

    @classmethod
    def of(cls, fault: Fault, file: SourceFile) -> Truth:
        """Of a fault in a file, as coverage counts the statements of its faulty text."""
        blocks = [*_blocks(fault.before.splitlines(), fault.text.splitlines())]
        lines = {line for block in blocks for line in block.lines()}
        names = {
            next(function.name for function in functions(text) if line in function)
            for block in blocks
            for text, line in block.places(fault)
        }
        statements = {max((first for first in file.statements if first <= line), default=0) for line in lines}
        return cls(fault.file, frozenset(statements), frozenset(names), all(block.is_omission for block in blocks))


@dataclass(frozen=True)
class _Block:
    """Lines that differ: numbers of those of the text without the fault, and of the faulty text, and this text."""

    gone: range
    came: range
    after: Sequence[str]

    @property
    def is_omission(self) -> bool:
        return all(self.after[line - 1].strip() in ("", "pass") for line in self.came)

    def lines(self) -> Iterator[int]:
        """Those of the faulty text that count."""
        yield from (line for line in self.came if self.after[line - 1].strip())
        if self.is_omission:
            yield from _first_with_text(self.after, range(self.came.start - 1, 0, -1))
            yield from _first_with_text(self.after, range(self.came.stop, len(self.after) + 1))

    def places(self, fault: Fault) -> Iterator[tuple[str, int]]:
        """Texts with the numbers of lines in them that say where it is."""
        yield from ((fault.before, line) for line in self.gone)
        if not self.gone:
            yield from ((fault.text, line) for line in self.came)


def _blocks(before: Sequence[str], after: Sequence[str]) -> Iterator[_Block]:
    matcher = difflib.SequenceMatcher(None, before, after, autojunk=False)
    for tag, gone, gone_end, came, came_end in matcher.get_opcodes():
        if tag != "equal":
            yield _Block(range(gone + 1, gone_end + 1), range(came + 1, came_end + 1), after)


def _first_with_text(lines: Sequence[str], numbers: range) -> Iterator[int]:
    yield from [number for number in numbers if lines[number - 1].strip()][:1]


def planted(project: str, code: CodeMap) -> Iterator[Fault]:
    """Faults that people planted into the code of a testbench.

    Raises:
        FaultError: one does not fit its file.
    """
    texts = {file.name: file.text for file in code.files}
    for fault in tomllib.loads(PLANTED.read_text(encoding="utf-8")).get(project, []):
        before = texts[fault["file"]]
        if before.count(fault["before"]) != 1:
            raise FaultError(f"{PLANTED.name}: {fault['id']}: {fault['file']} has this text not just once")
        text = before.replace(fault["before"], fault["after"])
        yield Fault(fault["id"], "planted", fault["file"], before, text)


def mutants(code: CodeMap, seed: int, most: int) -> Iterator[Fault]:
    """Mutants of the code, in an order that is drawn with the seed; at most so many."""
    texts = {file.name: file.text for file in code.files}
    for mutant in sample(all_mutants(code) if most else (), seed, most):
        yield Fault(mutant.id, mutant.operator, mutant.file, texts[mutant.file], mutant.text)


@dataclass(frozen=True)
class Drawn:
    """Faults of a testbench: planted ones, all or every other, and so many mutants, drawn with a seed."""

    seed: int
    most: int
    half: str | None = None

    def of(self, project: str, code: CodeMap) -> Iterator[Fault]:
        """Those of a testbench, the planted ones first.

        Raises:
            FaultError: a planted one does not fit.
        """
        first, step = (HALVES.index(self.half), 2) if self.half else (0, 1)
        yield from islice(planted(project, code), first, None, step)
        yield from mutants(code, self.seed, self.most)
