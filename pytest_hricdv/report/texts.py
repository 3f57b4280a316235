"""Source texts line by line, with what reaches each line: the code under test, and the agents of the model."""

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from operator import add
from typing import Any

from pytest_hricdv.report.rows import code_bits, plan_bits, plan_names


@dataclass(frozen=True)
class TextLine:
    """One line of a text.

    Attributes:
        number: from 1.
        text: without its end.
        kind: "hit", "missed", "partial" (some way out of it was never taken), "waived", or "" where nothing is to hit.
        unit: number of the statement or plan among all, for links to the tests that reach it; None where it is none.
        tests: how many tests reach it.
        note: what to say of it.
    """

    number: int
    text: str
    kind: str = ""
    unit: int | None = None
    tests: int = 0
    note: str = ""


@dataclass(frozen=True)
class Text:
    """A file with its lines; `covered` of `total` statements or plans were reached."""

    title: str
    file: str
    lines: tuple[TextLine, ...]
    covered: int
    total: int


def code(report: Mapping[str, Any]) -> tuple[Text, ...]:
    """The files under test; none where the report has no texts or nothing was measured."""
    files = report.get("code_under_test", {}).get("map", ())
    if not any(test["code"] and test["code"].get("bits") for test in report["tests"]):
        return ()
    statements, branches = zip(*map(code_bits, report["tests"]), strict=True)
    hits = totals(statements, sum(len(file["statements"]) for file in files))
    taken = totals(branches, sum(len(file["branches"]) for file in files))
    waived = {(w["file"], w["line"]) for w in report.get("code_under_test", {}).get("waivers", ())}
    texts, first, first_branch = [], 0, 0
    for file in files:
        texts.append(_code(file, first, first_branch, hits, taken, waived))
        first, first_branch = first + len(file["statements"]), first_branch + len(file["branches"])
    return tuple(text for text in texts if text.total)


def models(report: Mapping[str, Any]) -> tuple[Text, ...]:
    """The agents' sources."""
    names = plan_names(report)
    numbers = {plan: number for number, plan in enumerate(names)}
    hits = totals((plan_bits(test, numbers) for test in report["tests"]), len(names))
    texts = []
    for agent, model in sorted(report.get("models", {}).items()):
        lines = {line: label for label, line in model["plans"].items() if (agent, label) in numbers}
        units = {line: numbers[agent, label] for line, label in lines.items()}
        notes = {line: _beliefs(report, agent, label) for line, label in lines.items()}
        texts.append(_model(agent, model, units, hits, notes))
    return tuple(texts)


def totals(sets: Iterable[int], size: int) -> list[int]:
    """How many of the bit sets have each of the first `size` bits."""
    counts, number = [0] * size, 0
    for number, bits in enumerate(sets, start=1):  # noqa: B007
        counts = list(map(add, counts, f"{bits:0{size}b}"[::-1].encode()))
    return [count - number * ord("0") for count in counts]


def _code(
    file: Mapping[str, Any],
    first: int,
    first_branch: int,
    hits: Sequence[int],
    taken: Sequence[int],
    waived: Set[tuple[str, int]],
) -> Text:
    """A file whose first statement and branch have these numbers."""
    units = {line: unit for unit, line in enumerate(file["statements"], start=first)}
    missed: dict[int, list[str]] = {}
    for number, (start, end) in enumerate(file["branches"], start=first_branch):
        if not taken[number] and (file["file"], start) not in waived and (file["file"], end) not in waived:
            missed.setdefault(start, []).append("out" if end < 0 else f"to line {end}")
    lines = []
    for number, text in enumerate(file["source"].splitlines(), start=1):
        unit = units.get(number)
        if unit is None:
            lines.append(TextLine(number, text))
            continue
        kind, note = "hit" if hits[unit] else "missed", ""
        if (file["file"], number) in waived:
            kind = "waived"  # its reason stands in the line
        elif hits[unit] and number in missed:
            kind, note = "partial", f"never went {' nor '.join(missed[number])}"
        lines.append(TextLine(number, text, kind, unit, hits[unit], note))
    covered = sum(hits[unit] > 0 for unit in units.values())
    return Text(file["file"], "", tuple(lines), covered, len(units))


def _beliefs(report: Mapping[str, Any], agent: str, label: str) -> str:
    """The smallest belief set that triggers a plan, of all suites; or one that would, where exploring has found one."""
    plans = (suite["plans"].get(agent, {}) for suite in report["suites"])
    reached = [each["reached"][label]["shortest"] for each in plans if label in each.get("reached", {})]
    smallest = min(reached, key=lambda beliefs: (len(beliefs), beliefs), default=None)
    if smallest:
        return f"by {' '.join(smallest)}"
    known = report.get("exploration", {}).get("plans", {}).get(agent, {}).get(label)
    return f"the beliefs {' '.join(known)} would" if known and smallest is None else ""


def _model(
    agent: str, model: Mapping[str, Any], units: Mapping[int, int], hits: Sequence[int], notes: Mapping[int, str]
) -> Text:
    lines = []
    kind, unit = "", None
    for number, text in enumerate(model["source"].splitlines(), start=1):
        if number in units:
            unit = units[number]
            kind = "hit" if hits[unit] else "missed"
            lines.append(TextLine(number, text, kind, unit, hits[unit], notes[number]))
        else:
            # A plan ends where a line is empty, or tells of something else.
            kind = kind if text.strip() and not text.startswith("//") else ""
            lines.append(TextLine(number, text, kind))
    covered = sum(hits[unit] > 0 for unit in units.values())
    return Text(f"Agent {agent}", model["file"], tuple(lines), covered, len(units))
