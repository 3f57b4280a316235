"""Pages of docs/ that are made of figures: a template each, filled and written aside and renamed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2

from benchmarks.estimates import Interval

FOLDER = Path(__file__).parent


def render(template: str, context: Mapping[str, Any]) -> str:
    """The text of a page.

    Args:
        template: its path in benchmarks/.
        context: what is filled in; a name that is missing is an error.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER),
        autoescape=False,  # Markdown
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(percent=percent, interval=interval, minutes=minutes, thousands=thousands, points=points)
    return environment.get_template(template).render(context)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown. Raises ValueError for a row that is not as wide as its head."""
    lines = [head, ["---"] * len(head), *rows]
    if any(len(line) != len(head) for line in lines):
        raise ValueError(f"a table of {len(head)} columns has a row that is not: {rows!r}")
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def write(path: Path, text: str) -> None:
    """Write a page."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f"{path.name}.part")
    aside.write_text(text, encoding="utf-8")
    aside.replace(path)


def percent(value: float | None, digits: int = 1) -> str:
    """`80.5 %` of 80.5, or a dash."""
    return "-" if value is None else f"{value:.{digits}f} %"


def interval(each: Interval | None, scale: float = 100.0, digits: int = 1) -> str:
    """`12.3 (10.1 to 14.9)` of a share, in per cent unless scaled otherwise; or a dash."""
    if each is None:
        return "-"
    value, low, high = (f"{scale * number:.{digits}f}" for number in (each.value, each.low, each.high))
    return f"{value} ({low} to {high})"


def points(value: float | None) -> str:
    """`+7.9` or `-0.7` of percentage points, or a dash."""
    return "-" if value is None else f"{value:+.1f}"


def minutes(seconds: float) -> str:
    """`0.8 s`, `51 s`, `3.4 min`, `2.6 h`."""
    if seconds < 60:
        return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.1f} min" if seconds < 3600 else f"{seconds / 3600:.1f} h"


def thousands(number: int) -> str:
    """`6,560`."""
    return f"{number:,}"
