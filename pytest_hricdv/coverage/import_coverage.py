"""`ImportCoverage`: what importing each module under test covers, measured at its first import.

A session has one, from `follow_imports`; its `Measurement` adds the coverage of imports to that of each test. Import
lines run once per process: in the first test that needs a module, or before any test when a conftest imports early.
They count for every test that imports the module, itself or by another one, so that the order of tests, the worker, and
the imports of the project change nothing. Modules that nothing imports are not run, and cover nothing.
"""

from __future__ import annotations

import sys
import sysconfig
import warnings
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from pytest_hricdv.coverage.code_map import Arc, Bits, CodeMap
from pytest_hricdv.coverage.import_process import describe_error, import_again
from pytest_hricdv.coverage.imports import ImportWatch, file_of
from pytest_hricdv.coverage.own_coverage import FilesOf, OwnCoverage, debugger, exactly, literally, users_tracer
from pytest_hricdv.coverage.source_files import INSTALLED

if TYPE_CHECKING:
    import coverage
    from coverage.sqldata import CoverageData

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

PREFIX = "hricdv import|"
"""Prefix of the name under which coverage.py records an import (its context); the module's name follows."""

BEFORE = "modules that were imported before imports were followed"
"""Key of their coverage, in place of a module's name."""


@dataclass
class TracerRecord:
    """A tracer's record: file -> lines, and file -> arcs."""

    lines: dict[str, set[int]] = field(default_factory=dict)
    arcs: dict[str, set[Arc]] = field(default_factory=dict)

    def add(self, file: str, lines: Iterable[int], arcs: Iterable[Arc]) -> None:
        """Take in what was recorded of a file."""
        self.lines.setdefault(file, set()).update(lines)
        self.arcs.setdefault(file, set()).update(arcs)

    def of_file(self, file: str) -> tuple[set[int], set[Arc]]:
        """The record of a file."""
        return self.lines.get(file, set()), self.arcs.get(file, set())


class ImportCoverage:
    """Measures the imports of this process from when it is installed; see `ImportWatch`.

    Args:
        roots: the folders of the project, whose modules are followed also before it is known what the code under test
            is. Those of the testbench are followed after that, too, as they import the code under test.
    """

    def __init__(self, *roots: Path) -> None:
        self._roots = roots
        self._library = Path(sysconfig.get_path("stdlib"))
        self._plugin = Path(__file__).parents[1]  # in its own checkout, its modules would be followed: 266 of them
        self._own = _project_coverage(roots) if roots else None
        self._own_is_of_project = True
        self._code: CodeMap | None = None
        self._files: frozenset[Path] = frozenset()
        self._measured: dict[str, TracerRecord] = {}
        self._pending: dict[str, OwnCoverage] = {}
        self._bits: dict[frozenset[str], Bits] = {}
        self._problems: dict[str, str] = {}
        self._users: dict[str, coverage.Coverage] = {}
        """The modules that the user's measurement sees imported before the first test -> this measurement."""
        self._has_begun = False
        self._depth = 0
        self.base: set[str] = set()
        """The modules that every test has imported, as the testbench did."""
        self.watch = ImportWatch(self._is_of_interest, self._measure)

    def _is_of_interest(self, file: Path) -> bool:
        if file in self._files:
            return True
        if not any(file.is_relative_to(root) for root in self._roots):
            return False
        if file.is_relative_to(self._library) or file.is_relative_to(self._plugin):
            return False
        return INSTALLED.isdisjoint(file.parts)

    def follow(self, code: CodeMap, own: OwnCoverage, before: tuple[str, ...] = ()) -> None:
        """Follow the imports of the code under test with this measurement from now on.

        Its modules that were loaded unfollowed are imported once more, in a separate process.
        """
        self.collect()
        self._code, self._files = code, frozenset(file.path for file in code.files)
        self._own, self._own_is_of_project = own, False
        import coverage

        current = coverage.Coverage.current()
        lost = {name for name, by in self._users.items() if by is not current}  # with a measurement that continued
        files = [(name, file) for name, file in list_loaded_files() if file in self._files]
        loaded = [name for name, _ in files if name in lost or name not in self.watch.files]
        if loaded:
            answer = import_again(loaded, [str(file.path) for file in code.files], before)
            measured = self._measured[BEFORE] = TracerRecord()
            for name in answer.lines:
                measured.add(name, answer.lines[name], answer.arcs[name])
            self._problems = answer.problems

    def begin(self) -> None:
        """The first test of the process begins now: what the user's measurement has until here, was run by imports.

        Not read earlier: what it has would be written into its file, which pytest-cov in another worker would remove.
        """
        import coverage

        if self._has_begun:
            return
        self._has_begun, current = True, coverage.Coverage.current()
        names = [name for name, by in self._users.items() if by is current]
        if names and current is not None:
            data = FilesOf(users_data(current))
            for name in names:
                file = str(self.watch.files[name])
                self._measured.setdefault(name, TracerRecord()).add(file, data.lines(file), data.arcs(file))
            self._bits.clear()
        self._users.clear()

    def _measure(self, name: str) -> AbstractContextManager[None]:
        file = self.watch.files[name]
        if (self._code is not None and file not in self._files) or debugger():
            return _empty()
        import coverage

        current = coverage.Coverage.current()
        if current is not None and not (self._own and self._own.is_running(current)):
            if users_tracer() is None:
                return _empty()
            if self._has_begun:
                return self._join(name, str(file), current)
            self._users[name] = current
            return _empty()
        if self._own is None:
            return _empty()
        self._pending[name] = self._own
        return self._own.record(f"{PREFIX}{name}")

    @contextmanager
    def _join(self, name: str, file: str, current: coverage.Coverage) -> Iterator[None]:
        """Reads off the user's measurement what an import ran; its contexts stay his.

        A module's own file has been run by its import only. In the others, an import runs what was not run before.
        """
        earlier, self._depth = (TracerRecord() if self._depth else self._load(current)), self._depth + 1
        try:
            yield
        finally:
            self._depth -= 1
            files = [file] if self._depth else [str(path) for path in self.watch.files.values()]
            data, measured = FilesOf(users_data(current)), self._measured.setdefault(name, TracerRecord())
            for path in files:
                lines, arcs = earlier.of_file(path)
                measured.add(path, set(data.lines(path)) - lines, set(data.arcs(path)) - arcs)
            self._bits.clear()

    def _load(self, current: coverage.Coverage) -> TracerRecord:
        """Load the user's measurement of the modules that are loaded now."""
        data, measured = FilesOf(users_data(current)), TracerRecord()
        for path in map(str, self.watch.files.values()):
            measured.add(path, data.lines(path), data.arcs(path))
        return measured

    def collect(self) -> None:
        """Take what imports covered out of the data of the tracer, which is erased after each test."""
        if not self._pending:
            return
        for own in {id(own): own for own in self._pending.values()}.values():
            data = own.data()
            names = [name for name, by in self._pending.items() if by is own]
            for name, measured in read_import_records(data, names).items():
                mine = self._measured.setdefault(name, TracerRecord())
                for file in measured.lines:
                    mine.add(file, *measured.of_file(file))
            if self._own_is_of_project:
                data.erase()
        self._pending.clear()
        self._bits.clear()

    def with_imports(self, bits: Bits, files: Iterable[str], asked: Iterable[str]) -> Bits:
        """The coverage of a test, including that of importing its modules.

        Args:
            bits: the bits that it covered itself.
            files: the files in which it covered a bit.
            asked: names of the modules that it imported.
        """
        of_files = self.watch.of_files(set(map(Path, files)))
        return bits | self._coverage_by(self.watch.close_over_imports({*self.base, *asked, *of_files}))

    def _coverage_by(self, names: frozenset[str]) -> Bits:
        assert self._code is not None, "the code under test is known before it is measured"
        if names not in self._bits:
            union = TracerRecord()
            for name in (*names, BEFORE):
                measured = self._measured.get(name, TracerRecord())
                for file in measured.lines:
                    union.add(file, *measured.of_file(file))
            unmeasured = tuple(sorted(self._names_to_measure(names)))
            self._bits[names] = replace(self._code.translate(union.lines, union.arcs), unmeasured=unmeasured)
        return self._bits[names]

    def _names_to_measure(self, names: Iterable[str]) -> Iterator[tuple[str, str]]:
        """Files of which the import was not measured, or not to its end, and why."""
        of_code = self._code.files if self._code else ()
        shown = {file.path: file.name for file in of_code}
        statements = {file.path for file in of_code if file.statements}
        with_lines = {
            Path(path) for measured in self._measured.values() for path, lines in measured.lines.items() if lines
        }
        files = self.watch.files | (dict(list_loaded_files()) if self._problems else {})
        for name, problem in self._problems.items():
            if files.get(name) in shown:
                yield shown[files[name]], f"imported again to be measured, it {problem}"
        for name in names:
            path, error = self.watch.files[name], self.watch.failures.get(name)
            if path not in shown:
                continue
            if error is not None:
                yield shown[path], f"its import raised {describe_error(error)}"
            elif path in statements and path not in with_lines:
                yield shown[path], "it was imported, but the running measurement (--cov) recorded nothing of it"


def _project_coverage(roots: Iterable[Path]) -> OwnCoverage:
    return OwnCoverage([f"{literally(str(root))}/*" for root in roots], [f"*/{folder}/*" for folder in INSTALLED])


@contextmanager
def _empty() -> Iterator[None]:
    yield


def read_import_records(data: CoverageData, names: Iterable[str]) -> dict[str, TracerRecord]:
    """The records made while these modules were imported."""
    contexts = {f"{PREFIX}{name}": TracerRecord() for name in names}
    for file in data.measured_files():
        data.set_query_contexts(None)
        recording = {context for by in data.contexts_by_lineno(file).values() for context in by}
        for context in recording & contexts.keys():
            if len(recording) > 1:  # a query for a context compares each row with it, and most files have one only
                data.set_query_contexts([exactly(context)])
            contexts[context].add(file, data.lines(file) or (), data.arcs(file) or ())
    data.set_query_contexts(None)
    return {context.removeprefix(PREFIX): measured for context, measured in contexts.items()}


def users_data(current: coverage.Coverage) -> CoverageData:
    """The records of the user's running measurement so far."""
    from coverage.exceptions import CoverageWarning

    with warnings.catch_warnings():
        # Coverage repeats its warnings at the end of the session; here there would be one for each test.
        warnings.simplefilter("ignore", CoverageWarning)
        return current.get_data()


def list_loaded_files() -> Iterator[tuple[str, Path]]:
    """The modules that are loaded from a file, in the order in which their imports began."""
    for name, module in [*sys.modules.items()]:
        spec = getattr(module, "__spec__", None) if isinstance(module, ModuleType) else None
        file = None if spec is None else file_of(spec)
        if file is not None:
            yield name, file
