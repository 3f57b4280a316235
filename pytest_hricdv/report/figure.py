"""Figures as people read them: per cent, seconds, values, line ranges; and names in the order people count in."""

import re
from collections.abc import Iterable, Sequence


def percent(value: float | None) -> str:
    """`80.5 %`, or `-` for none; never `100.0 %` of what is not complete, nor `0.0 %` of what was begun."""
    if value is None:
        return "-"
    shown = min(max(round(value, 1), 0.1 if value > 0 else 0.0), 99.9 if value < 100 else 100.0)
    return f"{shown:.1f} %"


def share(part: int, whole: int) -> float | None:
    """Per cent of a whole; None of nothing."""
    return 100.0 * part / whole if whole else None


def seconds(value: float | None) -> str:
    """`0.52 s`, `71.2 s`, `17553 s`, or `-` for none."""
    if value is None:
        return "-"
    digits = 2 if abs(value) < 10 else 1 if abs(value) < 1000 else 0
    return f"{value:.{digits}f} s"


def quantity(value: object) -> str:
    """A measured value with four significant digits; whatever is no float as it is."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def plural(count: int, noun: str) -> str:
    """`1 test`, `2 tests`, `2 branches`."""
    ending = "" if count == 1 else "es" if noun.endswith("ch") else "s"
    return f"{count} {noun}{ending}"


def ranges(lines: Iterable[int]) -> tuple[str, ...]:
    """Line numbers as ranges: 60, 61, 62, 70 become `60-62`, `70`."""
    spans: list[list[int]] = []
    for line in sorted(set(lines)):
        if spans and line == spans[-1][1] + 1:
            spans[-1][1] = line
        else:
            spans.append([line, line])
    return tuple(str(first) if first == last else f"{first}-{last}" for first, last in spans)


def branches(arcs: Iterable[Sequence[int]]) -> tuple[str, ...]:
    """Branches as `58->60`; a negative line is the way out of (or into) a function, as coverage.py counts."""
    return tuple(f"{_end(start)}->{_end(end)}" for start, end in sorted((arc[0], arc[1]) for arc in arcs))


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """A sort key that puts R2 before R10."""
    parts = re.split(r"(\d+)", name)
    return tuple((1, int(part), part) if part.isdecimal() else (0, 0, part) for part in parts)


def _end(line: int) -> str:
    return "exit" if line < 0 else str(line)
