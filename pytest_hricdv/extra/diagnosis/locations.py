"""Where in the code under test the bug behind a cause probably is, and where its nodes were at the violation.

`rank_places` orders statements by how suspicious they are. Coverage shows what only failing tests execute, but nothing
if all tests execute the same. So `weight_suspects` adds time: what runs only after the violation cannot have led to it;
what ran just before, or was in progress, probably has. The diagnosis of a session (`causes`) shows the first places.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from pytest_hricdv.coverage.code_map import Bits, SourceFile
from pytest_hricdv.coverage.gaps import Function, functions
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT, Failure
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.records import SuspiciousPlace
from pytest_hricdv.extra.diagnosis.spectrum import Spectra, Suspect, combine
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.extra.diagnosis.switching import SWITCHED
from pytest_hricdv.extra.diagnosis.trace import ViolationTrace

Place = tuple[str, int]
"""Name of a file, and first line of a statement."""

HALF = 4
"""Number of statements after which the weight of recency is halved. Chosen over 23 bugs in the testbenches of
two tutorials: with half to twice the value of this constant or the next ones, results were not clearly better."""

LEAST = 0.5
"""The weight of a statement executed long before the violation."""

LATER = 0.1
"""The weight of a statement executed only after the violation. Not 0: the trace may be incomplete."""

DEFINED = 0.9
"""A constant has the score of the statement that reads it times this factor, so it comes after that statement. Chosen
over 39 bugs in three testbenches: with 0.8, one fewer is among the first five; with 0.95, as many."""

REPEATED = 0.07
"""The score of a statement executed n times before the violation is divided by n to this power: n - 1 times it did no
harm. Chosen over the same bugs: with 0.07, two more are among the first five; from 0.1 on, fewer."""

MAX_TIMES = 8
"""Maximum n above: a loop that polls runs hundreds of times, and may be wrong each time."""

SPECTRUM = 2.0
"""Scores of coverage are raised to this power before they are weighted: where they differ, they say more than the order
does. Chosen over the same 39 bugs: with 1.5, the buggy function comes first for one fewer; with 3, for two fewer."""

SHOWN = 0.5
"""The least score of a statement without which a failing test passes, as an experiment has shown."""

WAITING = 1
"""Number of statements that precede a wait in the order."""

WAITS = re.compile(r"\b\w*(?:sleep|wait|poll|join|spin)\w*\(")
"""Calls that only wait. Other calls that take time, as of an arm that moves, are the code's actions."""

AROUND = 4
"""A call in progress counts as executed this many statements ago: it began earlier, but takes effect now."""


def weight_suspects(
    suspects: Sequence[Suspect],
    traces: Sequence[ViolationTrace],
    files: Sequence[SourceFile],
    shown: Collection[Place] = (),
) -> list[Suspect]:
    """The statements in the order of their suspiciousness, weighted by when runs executed them.

    Args:
        suspects: the suspects, with the suspiciousness that coverage gives, in their order.
        traces: the traces of failing runs up to the violation; without any, the order stays.
        files: the files of the code under test.
        shown: statements without which a failing test passes.
    """
    if not traces:
        return [*suspects]
    texts = {file.name: file.text.splitlines() for file in files}
    weights = [_weights(trace, texts) for trace in traces]
    taken = {branch for trace in traces for branch in trace.branches}
    times: dict[Place, int] = {}
    for executed in (executed for trace in traces for executed in trace.executed):
        place = executed.file, executed.line
        times[place] = max(times.get(place, 1), executed.times)
    places = {(suspect.file, suspect.line) for suspect in suspects}
    read_by = dict(readers(files, places))
    scores: dict[Place, float] = {}
    for suspect in suspects:
        place = suspect.file, suspect.line
        weight = sum(weight.get(place, LATER) for weight in weights) / len(weights)
        weight /= min(MAX_TIMES, times.get(place, 1)) ** REPEATED
        scores[place] = weight * _until_violation(suspect, taken) ** SPECTRUM
        if place in shown:
            scores[place] = SHOWN + (1.0 - SHOWN) * scores[place]
    for place, reading in read_by.items():
        read = max((scores[reader] for reader in reading if reader in scores), default=0.0)
        if place in scores:
            scores[place] = max(scores[place], DEFINED * read)
    ranked = [replace(suspect, score=scores[suspect.file, suspect.line]) for suspect in suspects]
    return sorted(ranked, key=lambda suspect: -suspect.score)


def _until_violation(suspect: Suspect, taken: Collection[tuple[str, int, int]]) -> float:
    """The score of a statement, or of a branch that failing runs took before the violation."""
    ways = (score for to, score in suspect.branches if (suspect.file, suspect.line, max(to, 0)) in taken)
    return max(suspect.own, *ways, 0.0) if suspect.branches else suspect.score


def _weights(trace: ViolationTrace, texts: Mapping[str, Sequence[str]]) -> dict[Place, float]:
    """Weights from 1 for the last executed statement to `LEAST` for the first."""
    return {place: LEAST + (1.0 - LEAST) * 0.5 ** (number / HALF) for number, place in enumerate(_recent(trace, texts))}


def _recent(trace: ViolationTrace, texts: Mapping[str, Sequence[str]]) -> list[Place]:
    """The executed statements, the last first.

    Nodes take turns, as one that only polls is always the last; the busiest node gives two statements for one of each
    other.
    """
    nodes: dict[int, list[Place]] = {}
    for statement in trace.executed:
        nodes.setdefault(statement.node, []).append((statement.file, statement.line))
    for node, stack in enumerate(trace.stood):
        places = nodes.setdefault(node, [])
        if stack and places[:1] == [stack[0]] and (trace.is_said or _only_waits(stack[0], texts)):
            # Time passes only where the code waits, so a wait is always the last: it says less than what led to it.
            # A message says what was decided before it was sent.
            places.insert(min(WAITING, len(places)), places.pop(0))
        for around in reversed(stack[1:]):
            places.insert(min(AROUND, len(places)), around)
    busiest, *others = sorted(([*dict.fromkeys(places)] for places in nodes.values()), key=len, reverse=True) or [[]]
    recent = []
    while busiest or any(others):
        recent += busiest[:2] + [place for places in others for place in places[:1]]
        busiest, others = busiest[2:], [places[1:] for places in others]
    return [*dict.fromkeys(recent)]


def _only_waits(place: Place, texts: Mapping[str, Sequence[str]]) -> bool:
    name, line = place
    return name not in texts or WAITS.search(texts[name][line - 1]) is not None


def readers(files: Iterable[SourceFile], places: Collection[Place]) -> Iterator[tuple[Place, list[Place]]]:
    """Constants: a statement outside of functions that gives a name its value, and the statements that read the name.

    A field of a class counts, too, by its name alone.

    Args:
        files: the files of the code under test.
        places: constants among these.
    """
    trees = {file.name: _parse(file.text) for file in files}
    reading: dict[str, list[Place]] = {}
    for file in files:
        for name, line in _read(trees[file.name]):
            first = max((first for first in file.statements if first <= line), default=0)
            reading.setdefault(name, []).append((file.name, first))
    for file in files:
        for names, line in _definitions(trees[file.name]):
            first = max((first for first in file.statements if first <= line), default=0)
            if (file.name, first) in places:
                yield (file.name, first), [place for name in names for place in reading.get(name, ())]


def _parse(text: str) -> ast.Module:
    try:
        return ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module([], [])


def _read(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """Names that functions read, with the lines."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            for node in ast.walk(function):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                    yield node.id, node.lineno
                elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
                    yield node.attr, node.lineno


def _definitions(tree: ast.Module | ast.ClassDef) -> Iterator[tuple[list[str], int]]:
    """Names that statements outside of functions define, with the lines."""
    for statement in tree.body:
        if isinstance(statement, ast.ClassDef):
            yield from _definitions(statement)
        elif isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            names = [node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)]
            yield names, statement.lineno


MAX_PLACES = 5
"""The number of statements that a report lists, the most suspicious first."""

LEAD = 0.15
"""The least lead of a statement that is shown: the difference of its score and the next one's. Of 41 bugs in five
testbenches, six have such a statement, in the faulty function for five; of 14 whose score is at least 0.7, whatever the
next one's, seven were right."""


def traces_of(experiments: Experiments, group: Group) -> list[ViolationTrace]:
    """Traces of runs that failed for a cause, up to the first failure; known ones count only if nothing else failed."""
    first: dict[str, Failure] = {}
    for failure in sorted(group.failures, key=lambda failure: failure.is_known):
        first.setdefault(failure.nodeid, failure)
    runs = ((failure.requirement, experiments.controls.get(name)) for name, failure in first.items())
    return [run.traces[requirement] for requirement, run in runs if run is not None and requirement in run.traces]


def variation_coverage(experiments: Experiments, group: Group) -> list[tuple[Bits, bool]]:
    """Coverage of runs that vary a cause's tests, and whether they failed for it; other runs show nothing."""
    shown = []
    for result in (result for name in group.nodeids for result in experiments.runs.get(name, ())):
        bits, fails = Bits.of(result.code), not {*group.requirements}.isdisjoint(result.violated)
        passes = not result.violated and group.first[0] in (FAULT, *result.checked)
        if bits is not None and (fails or passes):
            shown.append((bits, fails))
    return shown


def rank_places(
    subject: Subject,
    group: Group,
    traces: Sequence[ViolationTrace],
    varied: Sequence[tuple[Bits, bool]] = (),
    switched: Sequence[tuple[str, int]] = (),
) -> list[Suspect]:
    """The statements of the code, those first in which a cause is probably.

    Args:
        subject: what the failures are of.
        group: the failures that have the cause.
        traces: the traces of runs that failed for it, up to what failed first.
        varied: what runs of variations of its tests executed, and whether they failed for it.
        switched: file and line of decisions with which tests of it pass, reversed.
    """
    code = subject.spectra.code
    suspects = subject.spectra.suspects(group.nodeids, subject.find_violators(group))
    if {fails for _, fails in varied} == {True, False}:
        spectra = Spectra(code, {str(number): bits for number, (bits, _) in enumerate(varied)})
        failing = [str(number) for number, (_, fails) in enumerate(varied) if fails]
        suspects = combine(suspects, spectra, failing)
    return weight_suspects(suspects, traces, () if code is None else code.files, switched)


def locate(
    subject: Subject, ranked: Sequence[Suspect], switched: Sequence[tuple[str, int]], *, is_compared: bool
) -> tuple[SuspiciousPlace, ...]:
    """The most suspicious statements, as a report has them.

    Args:
        subject: the subject whose code they are of.
        ranked: the most suspicious first.
        switched: file and line of decisions with which tests pass, reversed.
        is_compared: whether the code was measured in a run that fails for the cause, and in one that passes.
    """
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    first, second = (*(suspect.score for suspect in ranked[:2]), 0.0, 0.0)[:2]
    leads = first - second >= LEAD
    return tuple(
        SuspiciousPlace(
            file=suspect.file,
            line=suspect.line,
            function=_function(functions(sources[suspect.file]), suspect.line),
            score=round(suspect.score, 4),
            likely=number == 0 and leads and (is_compared or (suspect.file, suspect.line) in switched),
            experiment=SWITCHED if (suspect.file, suspect.line) in switched else "",
            text=_line(sources[suspect.file], suspect.line),
        )
        for number, suspect in enumerate(ranked[:MAX_PLACES])
    )


def node_places(subject: Subject, traces: Sequence[ViolationTrace]) -> tuple[str, ...]:
    """The innermost statements where the code of a run raised, or where its nodes were."""
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    for trace in traces[:1]:
        stood = [trace.raised] if trace.raised else [stack[0] for stack in trace.stood if stack]
        return tuple(f"{file}:{line} in {_function(functions(sources[file]), line)}" for file, line in stood)
    return ()


def _function(all_functions: Sequence[Function], line: int) -> str:
    return next(function.name for function in all_functions if line in function)


def _line(source: str, number: int) -> str:
    lines = source.splitlines()
    return lines[number - 1].strip() if number <= len(lines) else ""
