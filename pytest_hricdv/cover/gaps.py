"""Gaps: what no test covers, each with the reason or with what is likely to close it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pytest_hricdv.cover.functions import MODULE, Function, functions
from pytest_hricdv.cover.listing import bits_of
from pytest_hricdv.cover.source import Arc, Bits, CodeMap, SourceFile

Plain = dict[str, Any]


@dataclass(frozen=True)
class Gap:
    """Something that no test covers.

    Args:
        kind: "statements", "branches", "plans", "bins" or "requirements".
        place: where: a file and function, an agent, a cross product, a requirement.
        items: what: lines, branches as `30->31`, a plan, a bin.
        reason: why it is not covered, as far as that is known.
        suggestion: what is likely to cover it; empty where nothing is known.
        test: the id of the test that came nearest, or of another suite's that covers it; may be empty.
        beliefs: the belief set that is likely to cover it; may be empty.
    """

    kind: str
    place: str
    items: tuple[str, ...]
    reason: str
    suggestion: str = ""
    test: str = ""
    beliefs: tuple[str, ...] = ()

    def plain(self) -> Plain:
        """As the report has it."""
        return asdict(self) | {"items": list(self.items), "beliefs": list(self.beliefs)}


def code_gaps(code: CodeMap, total: Bits, tests: Iterable[Mapping[str, Any]]) -> Iterator[Gap]:
    """Lines and branches that no test ran, by function; waived ones with the waiver's reason."""
    measured = [(test["id"], bits) for test in tests if (bits := bits_of(test["code"])) is not None]
    first = 0
    for file, lines, arcs in code.uncovered(total):
        part = _Part(file, {line: first + place for place, line in enumerate(file.statements)}, measured)
        first += len(file.statements)
        waived = {waiver.line: waiver.reason for waiver in file.waivers}
        yield from _waived(file, waived)
        homes = functions(file.text)
        for function in homes:
            mine = [line for line in lines if line not in waived and _home(homes, line) == function]
            open_arcs = [arc for arc in arcs if not set(arc) & {*lines, *waived} and _home(homes, arc[0]) == function]
            if mine:
                yield part.lines(function, mine, arcs)
            yield from (part.branch(function, arc) for arc in open_arcs)


@dataclass(frozen=True)
class _Part:
    """A file, the bits of its statements, and the tests that were measured."""

    file: SourceFile
    bits: Mapping[int, int]
    measured: Sequence[tuple[str, Bits]]

    def lines(self, function: Function, lines: Sequence[int], arcs: Sequence[Arc]) -> Gap:
        """Lines of a function that no test runs."""
        near = self._nearest([line for line in self.bits if line in function])
        items = tuple(map(str, lines))
        if not near:
            return Gap("statements", self._where(function), items, "no test comes to this function")
        into = [arc for arc in arcs if arc[1] == lines[0] and arc[0] not in lines]
        how = f": {self._turn(into[0])}" if into else ""
        reason = "the function is run, this part of it is not"
        return Gap("statements", self._where(function), items, reason, f"vary {near}{how}", near)

    def branch(self, function: Function, arc: Arc) -> Gap:
        """A branch that no test takes, between lines that are run."""
        near = self._nearest([arc[0]])
        target = "exit" if arc[1] < 0 else str(arc[1])
        reason = f"line {arc[0]} runs, but never goes on to {target}"
        how = f"vary {near}: {self._turn(arc)}" if near else ""
        return Gap("branches", self._where(function), (f"{arc[0]}->{target}",), reason, how, near)

    def _where(self, function: Function) -> str:
        return self.file.name if function.name == MODULE else f"{self.file.name} {function.name}"

    def _nearest(self, lines: Sequence[int]) -> str:
        """The test that ran most of these lines; empty where none ran any."""
        mask = sum(1 << self.bits[line] for line in lines if line in self.bits)
        best = max(self.measured, key=lambda test: ((test[1].statements & mask).bit_count(), test[0]), default=None)
        return best[0] if best is not None and best[1].statements & mask else ""

    def _turn(self, arc: Arc) -> str:
        text = self.file.text.splitlines()[arc[0] - 1 : arc[0]] or [""]
        target = "the exit" if arc[1] < 0 else f"line {arc[1]}"
        return f"line {arc[0]} has to go on to {target} (`{text[0].strip()}`)"


def _waived(file: SourceFile, waived: Mapping[int, str]) -> Iterator[Gap]:
    reasons: dict[str, list[int]] = {}
    for line, reason in waived.items():
        reasons.setdefault(reason, []).append(line)
    for reason, lines in reasons.items():
        yield Gap("statements", file.name, tuple(map(str, lines)), f"waived as unreachable: {reason}")


def _home(homes: Sequence[Function], line: int) -> Function | None:
    """The innermost function that a line is in."""
    return next((function for function in homes if line in function), None)


def plan_gaps(
    suites: Iterable[Plain], tests: Sequence[Mapping[str, Any]], exploration: Mapping[str, Any]
) -> Iterator[Gap]:
    """Plans that no test's beliefs triggered."""
    declared = {agent: plans["declared"] for suite in suites for agent, plans in suite["plans"].items()}
    known = exploration.get("plans", {})
    for agent, labels in declared.items():
        covered = {label for test in tests for label in test["plans"].get(agent, ())}
        for label in labels:
            if label in covered:
                continue
            beliefs = tuple(known.get(agent, {}).get(label, ()))
            if beliefs:
                told = f"the beliefs {' '.join(beliefs)} reach it"
                yield Gap("plans", agent, (label,), "no test has beliefs that trigger it", told, "", beliefs)
            else:
                yield Gap("plans", agent, (label,), _unknown(exploration, "triggers it"))


def bin_gaps(
    products: Mapping[str, Plain], missing: Mapping[str, Iterable[Sequence[str]]], exploration: Mapping[str, Any]
) -> Iterator[Gap]:
    """Bins that no test hit and that are possible."""
    for name, bins in missing.items():
        planned = {tuple(each["bin"]): tuple(each["beliefs"]) for each in exploration.get("bins", {}).get(name, ())}
        size = max(map(len, planned), default=0)
        for each in bins:
            beliefs = planned.get(tuple(each[:size]), ()) if size else ()
            proof = products[name]["proof"]
            reason = "not hit yet" if proof else "not hit yet; the model does not say whether it can be"
            if beliefs and len(each) > size:
                told = f"the beliefs {' '.join(beliefs)} aim at {' x '.join(each[:size])}; the rest is up to the run"
            else:
                told = f"the beliefs {' '.join(beliefs)} aim at it" if beliefs else ""
            yield Gap("bins", name, (" x ".join(each),), reason, told, "", beliefs)


def requirement_gaps(requirements: Iterable[str], tests: Sequence[Mapping[str, Any]]) -> Iterator[Gap]:
    """Requirements that no test triggered, with the test that came nearest."""
    for name in requirements:
        verdicts = [(test["id"], test["requirements"][name]) for test in tests]
        if any(verdict["triggers"] for _, verdict in verdicts):
            continue
        misses = [
            (len(miss["missing"]), test, miss["missing"])
            for test, verdict in verdicts
            if (miss := verdict.get("nearest_miss"))
        ]
        _, test, lacking = min(misses, default=(0, "", []))
        told = f"vary {test}, which lacked {' & '.join(lacking)}" if test else ""
        yield Gap("requirements", name, (), "no test triggers it", told, test)


def _unknown(exploration: Mapping[str, Any], what: str) -> str:
    status = exploration.get("status")
    if status == "proven":
        return f"no set of beliefs {what}: all {exploration['runs']} runs of the model were explored"
    why = f" ({exploration['reason']})" if exploration.get("reason") else ""
    return f"no test {what}; whether any beliefs do is not proven{why}"
