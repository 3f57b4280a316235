"""The code under test: its statements, branches and waivers, and coverage of them as bit sets.

A statement or a branch is one bit. Bits are ordered by file, then by line. So the coverage of a test is one number,
which is cheap to send between processes, and coverage is merged with `|` in any order.
"""

from __future__ import annotations

import hashlib
import importlib.util
import io
import re
import tokenize
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_hricdv._base.message import InputError
from pytest_hricdv.coverage.records import CodeShare, MappedFile, ReportedCode, WaiverRecord

if TYPE_CHECKING:
    from coverage.parser import PythonParser

Arc = tuple[int, int]

WAIVER = re.compile(r"#\s*unreachable\b:?\s*(?P<reason>.*)")


class CoverageError(InputError):
    """The code under test cannot be measured as asked; the text says where and what to do."""


@dataclass(frozen=True)
class SourceFile:
    """One file: its displayed name, path, statements (first lines), branches (line to line), waivers and text."""

    name: str
    path: Path
    statements: tuple[int, ...]
    branches: tuple[Arc, ...]
    waivers: tuple[WaiverRecord, ...]
    text: str = ""


def percent(part: int, whole: int) -> float:
    """100 % of nothing is 100 %."""
    return round(100.0 * part / whole, 2) if whole else 100.0


@dataclass(frozen=True)
class Bits:
    """Covered statements and branches as bit sets; `branches` is None where only lines were measured.

    `unmeasured` are files of which not all was measured, each with the reason, sorted.
    """

    statements: int = 0
    branches: int | None = 0
    unmeasured: tuple[tuple[str, str], ...] = ()

    def __or__(self, other: Bits) -> Bits:
        branches = None
        if self.branches is not None and other.branches is not None:
            branches = self.branches | other.branches
        unmeasured = tuple(sorted({*self.unmeasured, *other.unmeasured}))
        return Bits(self.statements | other.statements, branches, unmeasured)

    @classmethod
    def of(cls, share: CodeShare | None) -> Bits | None:
        """The bits of a test's record; None where it was not measured."""
        if share is None:
            return None
        statements, branches = share.bits
        unmeasured = tuple(sorted(share.unmeasured.items()))
        return cls(int(statements, 16), None if branches is None else int(branches, 16), unmeasured)

    def share(self, total: int) -> CodeShare:
        """The record of these bits, of code with `total` statements."""
        count = self.statements.bit_count()
        branches = None if self.branches is None else hex(self.branches)
        bits = hex(self.statements), branches
        return CodeShare(
            statements=count, percent=percent(count, total), bits=bits, unmeasured=dict(reversed(self.unmeasured))
        )


@dataclass(frozen=True)
class CodeMap:
    """All files of the code under test. `sha256` is over their contents: equal hashes, comparable bits."""

    packages: tuple[str, ...]
    files: tuple[SourceFile, ...]
    sha256: str

    @classmethod
    def of(cls, listed: ReportedCode) -> CodeMap | None:
        """The code that a report lists, as far as coverage needs it; None where nothing is listed."""
        files = [
            SourceFile(
                file.file,
                Path(file.file),
                file.statements,
                file.branches,
                tuple(waiver for waiver in listed.waivers if waiver.file == file.file),
                file.source,
            )
            for file in listed.map
        ]
        return cls(listed.packages, tuple(files), listed.sha256) if files else None

    @property
    def listed(self) -> tuple[MappedFile, ...]:
        """The files as a report lists them, so that it can be merged where the code is not."""
        return tuple(
            MappedFile(file=file.name, statements=file.statements, branches=file.branches, source=file.text)
            for file in self.files
        )

    @property
    def statements(self) -> int:
        """Number of statements."""
        return sum(len(file.statements) for file in self.files)

    @property
    def branches(self) -> int:
        """Number of branches (ways out of statements that have more than one)."""
        return sum(len(file.branches) for file in self.files)

    @property
    def waivers(self) -> tuple[WaiverRecord, ...]:
        """All waivers, in the order of files and lines."""
        return tuple(waiver for file in self.files for waiver in file.waivers)

    def bits(self, lines: Mapping[str, Iterable[int]], arcs: Mapping[str, Iterable[Arc]] | None) -> Bits:
        """Measured lines and arcs (keyed by `str(file.path)`, already translated to first lines) as bit sets."""
        statements = _bitset((f.statements, lines.get(str(f.path), ())) for f in self.files)
        if arcs is None:
            return Bits(statements, None)
        return Bits(statements, _bitset((f.branches, arcs.get(str(f.path), ())) for f in self.files))

    def translated(self, lines: Mapping[str, Iterable[int]], arcs: Mapping[str, Iterable[Arc]] | None) -> Bits:
        """Lines and arcs as the tracer recorded them (keyed by `str(file.path)`) as bit sets."""
        first_lines = {name: parser.translate_lines(lines.get(name, ())) for name, parser in self._parsers.items()}
        if arcs is None:
            return self.bits(first_lines, None)
        first_arcs = {name: parser.translate_arcs(arcs.get(name, ())) for name, parser in self._parsers.items()}
        return self.bits(first_lines, first_arcs)

    @cached_property
    def _parsers(self) -> dict[str, PythonParser]:
        return {str(file.path): parse(file.path.read_text(encoding="utf-8"), file.path) for file in self.files}

    def waived(self) -> Bits:
        """Statements under a waiver, and branches that lead to or from one."""
        lines = {str(f.path): {w.line for w in f.waivers} for f in self.files}
        arcs = {
            str(f.path): {arc for arc in f.branches if arc[0] in lines[str(f.path)] or arc[1] in lines[str(f.path)]}
            for f in self.files
        }
        return self.bits(lines, arcs)

    def uncovered(self, bits: Bits) -> tuple[tuple[SourceFile, tuple[int, ...], tuple[Arc, ...]], ...]:
        """Per file: the statements and branches that `bits` lacks."""
        lacking = []
        statement = branch = 0
        for file in self.files:
            lines = tuple(n for i, n in enumerate(file.statements, statement) if not bits.statements >> i & 1)
            arcs: tuple[Arc, ...] = ()
            if bits.branches is not None:
                arcs = tuple(a for i, a in enumerate(file.branches, branch) if not bits.branches >> i & 1)
            statement += len(file.statements)
            branch += len(file.branches)
            lacking.append((file, lines, arcs))
        return tuple(lacking)


def _bitset(groups: Iterable[tuple[tuple[object, ...], Iterable[object]]]) -> int:
    bits = position = 0
    for universe, hit in groups:
        seen = set(hit)
        for item in universe:
            bits |= (item in seen) << position
            position += 1
    return bits


def map_code(packages: Iterable[str], root: Path) -> CodeMap:
    """Read the packages (or modules) under test without importing them.

    Args:
        packages: importable top-level names.
        root: the folder that file names are given relative to, where they lie below it.

    Raises:
        CoverageError: a package that is not there, a file that does not parse, or a waiver without a reason.
    """
    packages = tuple(packages)
    paths = sorted({path.resolve() for package in packages for path in _files(package)})
    digest = hashlib.sha256()
    files = []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(root).as_posix() if path.is_relative_to(root) else path.as_posix()
        digest.update(f"{name}\0{text}\0".encode())
        files.append(_read(name, path, text))
    return CodeMap(packages, tuple(files), digest.hexdigest())


def _files(package: str) -> Iterable[Path]:
    try:
        spec = importlib.util.find_spec(package)
    except ImportError:
        spec = None
    if spec is None:
        raise CoverageError(
            f"code under test: there is no package or module {package!r}; name one that can be imported"
        )
    if spec.submodule_search_locations is None:
        return [Path(spec.origin or "")]
    return [path for folder in spec.submodule_search_locations for path in Path(folder).rglob("*.py")]


def parse(text: str, path: Path) -> PythonParser:
    """A parsed source file, with bodies that are only `...` left out: they declare, and never run.

    Raises:
        CoverageError: the file is no Python.
    """
    from coverage.exceptions import NotPython
    from coverage.parser import PythonParser

    parser = PythonParser(text=text or "\n", filename=str(path), exclude=r":\s*\.\.\.\s*$")
    try:
        parser.parse_source()
    except NotPython as error:
        raise CoverageError(f"code under test: {error}") from None
    return parser


def _read(name: str, path: Path, text: str) -> SourceFile:
    parser = parse(text, path)
    exits = parser.exit_counts()
    branches = sorted((a, b) for a, b in parser.arcs() if exits[a] > 1)
    waivers = tuple(_waivers(name, text, frozenset(parser.statements), parser.first_line))
    return SourceFile(name, path, tuple(sorted(parser.statements)), tuple(branches), waivers, text)


def _waivers(
    name: str, text: str, statements: frozenset[int], first_line: Callable[[int], int]
) -> Iterable[WaiverRecord]:
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        match = WAIVER.search(token.string) if token.type == tokenize.COMMENT else None
        if match is None:
            continue
        line = first_line(token.start[0])
        if not match["reason"].strip():
            raise CoverageError(f"{name}:{token.start[0]}: a waiver needs its reason: write '# unreachable: <reason>'")
        if line not in statements:
            raise CoverageError(f"{name}:{token.start[0]}: this waiver stands on no statement; put it behind one")
        yield WaiverRecord(file=name, line=line, reason=match["reason"].strip())
