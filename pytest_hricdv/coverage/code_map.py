"""`CodeMap`: the statements, branches and waivers of the code under test; `Bits`: which of them a test covered.

Each statement or branch has one bit, ordered by file, then by line. So a test's coverage is two numbers, which are
cheap to send between processes, and coverage is merged with `|` in any order. A session calls `map_code` once;
measurement, reports, the closing loop, mutation and diagnosis use the map.
"""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_hricdv.coverage.records import CodeShare, MappedFile, ReportedCode, WaiverRecord
from pytest_hricdv.coverage.source_files import CoverageError, CoverageSettings, ModuleFile, module_files

if TYPE_CHECKING:
    from coverage.plugin import FileReporter

__all__ = ["Arc", "Bits", "CodeMap", "CoverageError", "SourceFile", "map_code", "percent"]

Arc = tuple[int, int]
"""A branch, as coverage.py has it: from line, to line."""

WAIVER = re.compile(r"#\s*unreachable:\s*(?P<reason>.*)")
"""A comment that says why a line need not be covered."""


@dataclass(frozen=True)
class SourceFile:
    """A file: statements are the numbers of their first lines, branches pairs of lines; `name` is shown in reports."""

    name: str
    path: Path
    statements: tuple[int, ...]
    branches: tuple[Arc, ...]
    waivers: tuple[WaiverRecord, ...]
    text: str = ""


def percent(part: int, whole: int) -> float:
    """A part as a percentage of the whole; 100 if the whole is 0."""
    return round(100.0 * part / whole, 2) if whole else 100.0


@dataclass(frozen=True)
class Bits:
    """Covered statements and branches as bit sets; `branches` is None if only lines were measured.

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
        """The bits of a test's record; None if it was not measured."""
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
    """All files of the code under test that are measured.

    Args:
        packages: the packages that it is made of.
        files: path -> file.
        sha256: over the contents of all files, measured or not: equal hashes, comparable bits.
        contents: name of a file, measured or not -> SHA-256 of what is in it.
        unmeasured: name of a file that is not measured, though nobody left it out -> why.
        nothing: why there is no file to measure; empty if there is.
    """

    packages: tuple[str, ...]
    files: tuple[SourceFile, ...]
    sha256: str
    contents: Mapping[str, str] = field(default_factory=dict, compare=False)
    unmeasured: Mapping[str, str] = field(default_factory=dict, compare=False)
    nothing: str = ""
    reporters: Mapping[str, FileReporter] = field(default_factory=dict, compare=False, repr=False)
    """Path of a file -> what coverage.py says of it."""

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
    def records(self) -> tuple[MappedFile, ...]:
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

    def translate(self, lines: Mapping[str, Iterable[int]], arcs: Mapping[str, Iterable[Arc]] | None) -> Bits:
        """Lines and arcs as the tracer recorded them (keyed by `str(file.path)`) as bit sets.

        Branches that need not be taken, as of a line with `pragma: no branch`, count as taken, as for coverage.py.
        """
        first_lines = {name: reporter.translate_lines(lines.get(name, ())) for name, reporter in self.reporters.items()}
        if arcs is None:
            return self.bits(first_lines, None)
        first_arcs = {name: reporter.translate_arcs(arcs.get(name, ())) for name, reporter in self.reporters.items()}
        bits = self.bits(first_lines, first_arcs)
        return replace(bits, branches=(bits.branches or 0) | self._not_needed)

    @cached_property
    def _not_needed(self) -> int:
        """The branches that need not be taken."""
        partial = {str(f.path): self.reporters[str(f.path)].no_branch_lines() for f in self.files}
        return _bitset((f.branches, [arc for arc in f.branches if arc[0] in partial[str(f.path)]]) for f in self.files)

    def without_waivers(self) -> CodeMap:
        """The same code, of which no statement is waived."""
        return replace(self, files=tuple(replace(file, waivers=()) for file in self.files))

    def waiver_bits(self) -> Bits:
        """Statements under a waiver, and branches that lead to or from one."""
        lines = {str(f.path): {w.line for w in f.waivers} for f in self.files}
        arcs = {
            str(f.path): {arc for arc in f.branches if arc[0] in lines[str(f.path)] or arc[1] in lines[str(f.path)]}
            for f in self.files
        }
        return self.bits(lines, arcs)

    def list_misses(self, bits: Bits) -> tuple[tuple[SourceFile, tuple[int, ...], tuple[Arc, ...]], ...]:
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


def map_code(packages: Iterable[str], root: Path, settings: CoverageSettings | None = None) -> CodeMap:
    """Read the packages (or modules) under test without importing them.

    Args:
        packages: importable names.
        root: the folder that file names are given relative to, where they lie below it.
        settings: what coverage.py counts; None: what it counts without a configuration.

    Raises:
        CoverageError: a package that is not there or that does not parse, or a waiver without a reason.
    """
    settings, packages = settings or CoverageSettings(), tuple(packages)
    listed = module_files(packages, root)
    digest, contents, unmeasured, files, reporters = sha256(), {}, {}, [], {}
    for file in listed:
        data = _content(file.path)
        contents[file.name] = sha256(data).hexdigest()
        digest.update(f"{file.name}\0".encode() + _text(file, data).encode() + b"\0")
        if not settings.is_measured(file):
            continue
        if file.problem:
            unmeasured[file.name] = file.problem
            continue
        reporter = settings.reporter(file.path)
        try:
            files.append(_read(file.name, file.path, reporter))
            reporters[str(file.path)] = reporter
        except NotPythonError as error:
            if file.module in packages:  # nothing of the package can be imported
                raise CoverageError(f"code under test: {error}") from None
            unmeasured[file.name] = str(error)
    return CodeMap(
        packages,
        tuple(files),
        digest.hexdigest(),
        contents,
        unmeasured,
        nothing="" if files else _empty_map(packages, settings, any(not file.problem for file in listed)),
        reporters=reporters,
    )


def _empty_map(packages: Iterable[str], settings: CoverageSettings, has_source: bool) -> str:
    if has_source:
        why = f"the configuration of coverage.py in {settings.file} leaves no file of it (source, include, omit)"
    else:
        why = "it has no Python source"
    return f"code under test, {', '.join(packages)}: {why}"


def _content(path: Path) -> bytes:
    """The content of a file, which may be in an archive."""
    from coverage.python import get_zip_bytes

    return path.read_bytes() if path.is_file() else get_zip_bytes(str(path)) or b""


def _text(file: ModuleFile, data: bytes) -> str:
    """A text with the content of a file, from which its bytes follow but for the ends of lines."""
    return sha256(data).hexdigest() if file.problem else data.decode("utf-8", "replace").replace("\r\n", "\n")


class NotPythonError(Exception):
    """A file that is not Python; the message says where and why."""


def _read(name: str, path: Path, reporter: FileReporter) -> SourceFile:
    from coverage.exceptions import CoverageException

    try:
        text, statements = reporter.source(), reporter.lines()
        excluded, exits = reporter.excluded_lines(), reporter.exit_counts()
        arcs = reporter.arcs()
    except (CoverageException, SyntaxError, ValueError, LookupError, RecursionError) as error:
        raise NotPythonError(str(error).replace(str(path), name)) from None
    branches = sorted((a, b) for a, b in arcs if exits.get(a, 0) > 1 and b not in excluded)
    waivers = tuple(_waivers(name, text, frozenset(statements), reporter))
    return SourceFile(name, path, tuple(sorted(statements)), tuple(branches), waivers, text)


def _waivers(name: str, text: str, statements: frozenset[int], reporter: FileReporter) -> Iterable[WaiverRecord]:
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        match = WAIVER.search(token.string) if token.type == tokenize.COMMENT else None
        if match is None:
            continue
        line = next(iter(reporter.translate_lines([token.start[0]])), token.start[0])
        if not match["reason"].strip():
            raise CoverageError(f"{name}:{token.start[0]}: a waiver needs its reason: write '# unreachable: <reason>'")
        if line not in statements:
            raise CoverageError(
                f"{name}:{token.start[0]}: no statement is on the line of this waiver; move it, or set hri_no_waivers "
                "where it is none"
            )
        yield WaiverRecord(file=name, line=line, reason=match["reason"].strip())
