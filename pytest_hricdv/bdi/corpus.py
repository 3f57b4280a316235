"""``hricdv model corpus``: which models in a folder can be parsed, and why others cannot.

Each file is parsed alone: what a source includes is a file of its own, or lies in a library that is not there. A text
that occurs several times, as copies of examples do, is parsed once.
"""

from __future__ import annotations

import os
import re
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv._base.input_file import MalformedError, read_bytes
from pytest_hricdv.bdi.actions import describe_missing, foreign_calls, wrong_calls
from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError
from pytest_hricdv.bdi.language.parser import parse_alone
from pytest_hricdv.bdi.language.project import read_project

_JAVA, _UNKNOWN = "an internal action in Java", "unknown internal action"
_PLACE = re.compile(r"^.*?:\d+:\d+: ", re.DOTALL)
_NAME_FOUND = re.compile(r"found '(?!not\b|begin\b|end\b)[^\W\d]\w*'")
_TEXT_FOUND = re.compile(r"found (['\"]?)(?:[^'\"\s]{12,}|\".*|'\d.*).*")


@dataclass(frozen=True, slots=True)
class FileResult:
    """The result of one file.

    Args:
        path: the file.
        seconds: the processor time that reading and parsing it took.
        kind: the kind of its error, without places and names; empty if it can be parsed.
        message: the whole error with its place; empty if it can be parsed.
        calls: the first of each kind of call that ends a run, or lets none begin: there is no such action here, or it
            takes another number of arguments.
    """

    path: Path
    seconds: float
    kind: str = ""
    message: str = ""
    calls: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class CorpusResult:
    """The results of all files below a folder.

    Args:
        files: the number of files by suffix, copies of the same text included.
        results: one result for each different source text, and for each project.
    """

    files: dict[str, int]
    results: tuple[FileResult, ...]

    @property
    def failures(self) -> list[FileResult]:
        """The files that cannot be parsed."""
        return [result for result in self.results if result.kind]


def read_corpus(folder: Path) -> CorpusResult:
    """Parse every ``.asl`` and ``.mas2j`` file below a folder; symbolic links to folders are not followed.

    Raises:
        BdiError: there is no such folder, or it has no such file.
    """
    if not folder.is_dir():
        raise BdiError(f"{folder}: no such folder; expected one with .asl and .mas2j files below it")
    files = Counter[str]()
    results: list[FileResult] = []
    texts: set[bytes] = set()
    for path in _files(folder):
        files[path.suffix] += 1
        if path.suffix == ".mas2j":
            results.append(_result(path, _load_project))
        elif _is_new(path, texts):
            results.append(_result(path, _load_source))
    if not results:
        raise BdiError(f"{folder}: no .asl or .mas2j file below this folder")
    return CorpusResult(dict(files), tuple(results))


def table(corpus: CorpusResult) -> str:
    """The result as text: how many files were parsed, how many refused for which reason, and which took longest."""
    lines = [f"{'':8}{'files':>7}{'distinct':>10}{'parsed':>8}{'refused':>9}"]
    for suffix, count in sorted(corpus.files.items()):
        results = [result for result in corpus.results if result.path.suffix == suffix]
        refused = sum(bool(result.kind) for result in results)
        percent = f"  {100 * refused / len(results):.1f} %"
        lines.append(
            f"{suffix:8}{count:7,}{len(results):10,}{len(results) - refused:8,}{refused:9,}{percent if refused else ''}"
        )
    lines += _counts("refused", [(result.kind, result.message, result.path) for result in corpus.failures])
    calls = [(kind, message, result.path) for result in corpus.results for kind, message in result.calls]
    lines += _counts("parsed, but a run with such a call ends or does not begin", calls)
    slowest = sorted(corpus.results, key=lambda result: -result.seconds)[:5]
    lines += ["", "slowest"] + [f"{result.seconds:7.2f} s  {result.path}" for result in slowest]
    return "\n".join(lines)


def _counts(title: str, faults: list[tuple[str, str, Path]]) -> list[str]:
    """The kinds of faults, the most frequent first, each with the number of its files and its first place."""
    if not faults:
        return []
    first: dict[str, tuple[str, Path]] = {}
    for kind, message, path in faults:
        first.setdefault(kind, (message, path))
    lines = ["", title]
    for kind, count in Counter(kind for kind, _, _ in faults).most_common():
        message, path = first[kind]
        place = _PLACE.match(message)
        lines += [f"{count:7,}  {kind}", f"{'':9}first in {place[0].rstrip(': ') if place else path}"]
    return lines


def _files(folder: Path) -> Iterator[Path]:
    """The sources and projects below a folder, in the order of their paths."""
    for parent, folders, names in os.walk(folder):
        folders.sort()
        yield from (Path(parent, name) for name in sorted(names) if name.endswith((".asl", ".mas2j")))


def _is_new(path: Path, texts: set[bytes]) -> bool:
    """Whether no earlier file had this text; what cannot be read is new, so that its error is reported."""
    try:
        text = read_bytes(path)
    except (FileNotFoundError, MalformedError):
        return True
    if text in texts:
        return False
    texts.add(text)
    return True


def _load_source(path: Path) -> tuple[tuple[str, str], ...]:
    program = parse_alone(path)
    kinds: dict[str, str] = {}
    for call in foreign_calls(program):
        kinds.setdefault(_JAVA if not call.name.startswith(".") else f"{_UNKNOWN} {call.name}", describe_missing(call))
    for message in wrong_calls(program):
        kinds.setdefault(_general(_PLACE.sub("", message, count=1)), message)
    return tuple(kinds.items())


def _load_project(path: Path) -> tuple[()]:
    for entry in read_project(path).agents:
        if not os.path.exists(entry.source):
            raise BdiSyntaxError.at("the source of an agent does not exist", entry.location, "")
    return ()


def _result(path: Path, load: Callable[[Path], tuple[tuple[str, str], ...]]) -> FileResult:
    start_s = time.process_time()
    kind = message = ""
    calls: tuple[tuple[str, str], ...] = ()
    try:
        calls = load(path)
    except FileNotFoundError:  # a link to nowhere
        kind = message = "no such file"
    except BdiError as error:
        message = str(error)
        kind = _kind(error)
    return FileResult(path, time.process_time() - start_s, kind, message, calls)


def _kind(error: BdiError) -> str:
    """The first sentence of an error without its place, its names and its advice."""
    return _general(error.message if isinstance(error, BdiSyntaxError) else _PLACE.sub("", str(error), count=1))


def _general(text: str) -> str:
    """A message without its names and its advice."""
    text = text.split("\n")[0].split("; ")[0]
    return _TEXT_FOUND.sub("found something else", _NAME_FOUND.sub("found a name", text))
