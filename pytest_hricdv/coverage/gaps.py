"""Gaps, as reports list them: what no test covers, each with the reason or with what is likely to close it.

`results.derivation` gets the gaps of code, plans, bins and requirements from `code_gaps` and its like. For people,
`holes` groups the open bins of a cross product: a list of a hundred bins says little; the sentence "whatever the rest,
never released with none ready" says what to generate. Method: hole analysis by projection (Lachish, Marcus, Ur, Ziv:
Hole analysis for functional coverage data, DAC 2002).
"""

from __future__ import annotations

import ast
import heapq
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from pytest_hricdv.coverage.code_map import Arc, Bits, CodeMap, SourceFile
from pytest_hricdv.coverage.cross_product import Bin, ExplorationRecord, ProductDeclaration
from pytest_hricdv.coverage.records import Gap, GapKind
from pytest_hricdv.coverage.suite_coverage import RunCoverage, TestCoverage, list_vacuous_alternatives
from pytest_hricdv.monitor import RequirementResult

MAX_PROJECTIONS = 200_000
"""Most combinations of a bin and a subset of coordinates that are searched for holes, which takes 3 s. In a larger
product each open bin is a hole of its own."""

Projection = tuple[tuple[int, str], ...]
"""Values of some coordinates: the number of the coordinate, and its value."""


@dataclass(frozen=True)
class Hole:
    """All bins with these values of some coordinates, none of which was hit.

    Args:
        values: coordinate and value; all coordinates where it is a single bin.
        bins: number of its bins that no larger hole has, and that closing it adds.
    """

    values: tuple[tuple[str, str], ...]
    bins: int


def holes(coordinates: Sequence[str], open_bins: Collection[Bin], missing: Collection[Bin]) -> tuple[Hole, ...]:
    """The holes that have all missing bins, the largest first.

    Args:
        coordinates: the coordinates of the product, by name.
        open_bins: the open bins that are to be hit: possible and legal.
        missing: those of them that no test hit.
    """
    left = dict.fromkeys(missing)
    if len(open_bins) << len(coordinates) > MAX_PROJECTIONS:
        return tuple(Hole(tuple(zip(coordinates, bin_, strict=True)), 1) for bin_ in left)
    size = Counter(values for bin_ in open_bins for values in _projections(bin_))
    members: dict[Projection, list[Bin]] = {}
    for bin_ in left:
        for values in _projections(bin_):
            members.setdefault(values, []).append(bin_)
    count = {values: len(bins) for values, bins in members.items()}
    whole = sorted(
        (values for values in members if count[values] == size[values]), key=lambda values: (len(values), values)
    )
    # The largest first; of equal ones the one with fewest values. A count only falls, so a lazy heap re-evaluates few.
    queue = [(-count[values], place) for place, values in enumerate(whole)]
    heapq.heapify(queue)
    chosen = []
    while left:
        negative, place = heapq.heappop(queue)
        best = whole[place]
        if count[best] < -negative:
            heapq.heappush(queue, (-count[best], place))
            continue
        chosen.append(Hole(tuple((coordinates[number], value) for number, value in best), count[best]))
        for bin_ in members[best]:
            if bin_ in left:
                del left[bin_]
                for values in _projections(bin_):
                    count[values] -= 1
    return tuple(chosen)


def _projections(bin_: Bin) -> Iterator[Projection]:
    """Its values of each subset of coordinates, also of none: that is the hole of a product without any hit."""
    valued = tuple(enumerate(bin_))
    for number in range(len(bin_) + 1):
        yield from combinations(valued, number)


MODULE = "the module"
OUTSIDE = "other methods of its class run: objects may be made outside of run.measured, where nothing is measured"
MAKE_INSIDE = "make them in the body that run.measured wraps"
NEVER_IMPORTED = "never imported: no test imports this file"


def _gap(
    kind: GapKind,
    place: str,
    items: tuple[str, ...],
    reason: str,
    suggestion: str = "",
    test: str = "",
    beliefs: tuple[str, ...] = (),
) -> Gap:
    return Gap(kind, place, items, reason, suggestion, test, beliefs)


def code_gaps(code: CodeMap, total: Bits, runs: Iterable[RunCoverage]) -> Iterator[Gap]:
    """Lines and branches that no test ran, by function; waived ones with the waiver's reason."""
    measured = [(run.id, run.code) for run in runs if run.code is not None]
    first = 0
    for file, lines, arcs in code.list_misses(total):
        inner_first = functions(file.text)
        bits = {line: first + place for place, line in enumerate(file.statements)}
        part = _FileGaps(file, bits, measured, inner_first)
        first += len(file.statements)
        waived = {waiver.line: waiver.reason for waiver in file.waivers}
        yield from _waivers(file, waived)
        if lines == file.statements and file.name not in dict(total.unmeasured):
            needed = tuple(str(line) for line in lines if line not in waived)
            yield from [_gap("statements", file.name, needed, NEVER_IMPORTED)] if needed else []
            continue
        for function in inner_first:
            mine = [line for line in lines if line not in waived and _innermost(inner_first, line) == function]
            open_arcs = [
                arc for arc in arcs if not set(arc) & {*lines, *waived} and _innermost(inner_first, arc[0]) == function
            ]
            if mine:
                yield part.lines(function, mine, arcs)
            yield from (part.branch(function, arc) for arc in open_arcs)


@dataclass(frozen=True)
class _FileGaps:
    """Gaps of one file, from the bits of its statements and the tests that were measured."""

    file: SourceFile
    bits: Mapping[int, int]
    measured: Sequence[tuple[str, Bits]]
    functions: Sequence[Function]

    def lines(self, function: Function, lines: Sequence[int], arcs: Sequence[Arc]) -> Gap:
        """Lines of a function that no test runs."""
        near = self._nearest([line for line in self.bits if line in function])
        items = tuple(map(str, lines))
        if not near and self._has_objects(function):
            return _gap("statements", self._where(function), items, OUTSIDE, MAKE_INSIDE)
        if not near:
            return _gap("statements", self._where(function), items, "no test reaches this function")
        into = [arc for arc in arcs if arc[1] == lines[0] and arc[0] not in lines]
        how = f": {self._turn(into[0])}" if into else ""
        reason = "the function runs, but not this part of it"
        return _gap("statements", self._where(function), items, reason, f"vary {near}{how}", near)

    def _has_objects(self, function: Function) -> bool:
        """Whether it is the `__init__` of a class whose other methods run."""
        of_class, _, name = function.name.rpartition(".")
        others = [other for other in self.functions if other.name.rpartition(".")[0] == of_class]
        return name == "__init__" and any(self._nearest([line for line in self.bits if line in it]) for it in others)

    def branch(self, function: Function, arc: Arc) -> Gap:
        """A branch that no test takes, between lines that are run."""
        near = self._nearest([arc[0]])
        target = "exit" if arc[1] < 0 else str(arc[1])
        reason = f"line {arc[0]} runs, but never continues to {target}"
        how = f"vary {near}: {self._turn(arc)}" if near else ""
        return _gap("branches", self._where(function), (f"{arc[0]}->{target}",), reason, how, near)

    def _where(self, function: Function) -> str:
        return self.file.name if function.name == MODULE else f"{self.file.name} {function.name}"

    def _nearest(self, lines: Sequence[int]) -> str:
        """The test that ran most of these lines; empty if none ran any."""
        mask = sum(1 << self.bits[line] for line in lines if line in self.bits)
        best = max(self.measured, key=lambda test: ((test[1].statements & mask).bit_count(), test[0]), default=None)
        return best[0] if best is not None and best[1].statements & mask else ""

    def _turn(self, arc: Arc) -> str:
        text = self.file.text.splitlines()[arc[0] - 1 : arc[0]] or [""]
        target = "the exit" if arc[1] < 0 else f"line {arc[1]}"
        return f"line {arc[0]} has to continue to {target} (`{text[0].strip()}`)"


def _waivers(file: SourceFile, waived: Mapping[int, str]) -> Iterator[Gap]:
    reasons: dict[str, list[int]] = {}
    for line, reason in waived.items():
        reasons.setdefault(reason, []).append(line)
    for reason, lines in reasons.items():
        yield _gap("statements", file.name, tuple(map(str, lines)), f"waived as unreachable: {reason}")


def _innermost(inner_first: Sequence[Function], line: int) -> Function | None:
    """The innermost function that a line is in."""
    return next((function for function in inner_first if line in function), None)


@dataclass(frozen=True)
class Function:
    """A function, or the module itself: its name as in `Robot.move`, and the lines of its body."""

    name: str
    first: int
    last: int

    def __contains__(self, line: int) -> bool:
        return self.first <= line <= self.last


def functions(source: str) -> tuple[Function, ...]:
    """All functions, inner ones before outer ones, and the module last. Of text that is not Python: only the module."""
    lines = source.count("\n") + 1
    try:
        inner = _functions_in(ast.parse(source), "")
        inner_first = sorted(inner, key=lambda function: (function.last - function.first, function.first))
    except (SyntaxError, ValueError, RecursionError, MemoryError):  # the last two: nested too deeply for the parser
        inner_first = []
    return (*inner_first, Function(MODULE, 1, max(lines, 1)))


def _functions_in(node: ast.AST, prefix: str) -> Iterator[Function]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield Function(f"{prefix}{child.name}", child.body[0].lineno, child.end_lineno or child.lineno)
        named = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        yield from _functions_in(child, f"{prefix}{child.name}." if named else prefix)  # type: ignore[attr-defined]


def plan_gaps(
    declared: Mapping[str, Iterable[str]], runs: Sequence[RunCoverage], exploration: ExplorationRecord
) -> Iterator[Gap]:
    """Plans that no test's beliefs triggered, of the declared ones by agent."""
    reachable = exploration.plans or {}
    for agent, labels in declared.items():
        covered = {label for run in runs for label in run.plans.get(agent, ())}
        for label in labels:
            if label in covered:
                continue
            beliefs = reachable.get(agent, {}).get(label, ())
            if beliefs:
                suggestion = f"the beliefs {' '.join(beliefs)} reach it"
                yield _gap("plans", agent, (label,), "no test has beliefs that trigger it", suggestion, "", beliefs)
            else:
                yield _gap("plans", agent, (label,), _open_bins(exploration))


def _open_bins(exploration: ExplorationRecord) -> str:
    if exploration.status == "proven":
        return f"no set of beliefs triggers it: all {exploration.runs} runs of the model were explored"
    why = f" ({exploration.reason})" if exploration.reason else ""
    return f"no test triggers it; whether any beliefs do is not proven{why}"


def bin_gaps(
    products: Mapping[str, ProductDeclaration], missing: Mapping[str, Iterable[Bin]], exploration: ExplorationRecord
) -> Iterator[Gap]:
    """Bins that no test hit and that are possible."""
    for name, bins in missing.items():
        planned = {record.bin: record.beliefs for record in (exploration.bins or {}).get(name, ())}
        size = max(map(len, planned), default=0)
        explored = products[name].proof.status is not None
        reason = "not hit yet" if explored else "not hit yet; the model does not say whether it can be"
        for bin_ in bins:
            beliefs = planned.get(bin_[:size], ()) if size else ()
            suggestion = f"the beliefs {' '.join(beliefs)} aim at {_part(bin_, size)}" if beliefs else ""
            yield _gap("bins", name, (" x ".join(bin_),), reason, suggestion, "", beliefs)


def _part(bins: Bin, size: int) -> str:
    return "it" if len(bins) == size else f"{' x '.join(bins[:size])}; the rest is up to the run"


def requirement_gaps(requirements: Iterable[str], tests: Sequence[TestCoverage]) -> Iterator[Gap]:
    """Requirements that no test triggered, with the test that came nearest; and parts that never decided."""
    for name in requirements:
        results = [(test.id, test.requirements[name]) for test in tests if test.was_run]
        if any(result.triggers for _, result in results):
            for unused in list_vacuous_alternatives(result for _, result in results):
                yield _gap("requirements", name, (unused,), "no test made its response hold by this alternative")
            continue
        test, missing = near_miss(results)
        suggestion = f"vary {test}, which lacked {' & '.join(missing)}" if test else ""
        yield _gap("requirements", name, (), "no test triggers it", suggestion, test)


def near_miss(results: Iterable[tuple[str, RequirementResult]]) -> tuple[str, tuple[str, ...]]:
    """The test that came nearest to triggering a requirement, and the conditions that were false then: the fewest.

    Args:
        results: ids of tests, each with the test's result for the requirement.

    Returns:
        Empty if no test came near.
    """
    misses = [(len(miss.missing), test, miss.missing) for test, result in results if (miss := result.near_miss)]
    _, test, missing = min(misses, default=(0, "", ()))
    return test, missing
