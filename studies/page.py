"""Pages of docs/ made of measured figures: Markdown tables, number formats, templates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2

from pytest_hricdv._base import atomic_file
from pytest_hricdv.results.proportion import Interval

FOLDER = Path(__file__).parent


def render(template: str, context: Mapping[str, Any], folder: Path = FOLDER) -> str:
    """The text of a page.

    Args:
        template: path of the template, relative to `folder`.
        context: values of the template; a missing name is an error.
        folder: of the templates.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=False,  # Markdown
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(
        percent=percent, interval=interval, duration=duration, thousands=thousands, points=points
    )
    return environment.get_template(template).render(context)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table. Raises ValueError for a row whose width is not that of the head."""
    lines = [head, ["---"] * len(head), *rows]
    if any(len(line) != len(head) for line in lines):
        raise ValueError(f"a table of {len(head)} columns has a row that is not: {rows!r}")
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def write(path: Path, text: str) -> None:
    """Write a page, atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    atomic_file.write_text(path, text)


def replace_figures(path: Path, command: str, figures: str) -> None:
    """Replace everything on a page below the mark that names the command which measures its figures.

    Up to the mark of another command, where there is one.
    """
    mark = f"<!-- figures: {command} -->"
    text, separator, below = path.read_text(encoding="utf-8").partition(mark)
    if not separator:
        raise ValueError(f"{path}: expected a line {mark}")
    _, next_mark, further = below.partition("\n<!-- figures: ")
    write(path, f"{text}{mark}\n\n{figures}\n{next_mark}{further}")


def percent(value: float | None, digits: int = 1) -> str:
    """`80.5 %` of 80.5, or a dash."""
    return "-" if value is None else f"{value:.{digits}f} %"


def interval(estimate: Interval | None, scale: float = 100.0, digits: int = 1) -> str:
    """`12.3 (10.1 to 14.9)`: a share in per cent, or scaled otherwise; a dash for None."""
    if estimate is None:
        return "-"
    value, low, high = (f"{scale * number:.{digits}f}" for number in (estimate.value, estimate.low, estimate.high))
    return f"{value} ({low} to {high})"


def points(value: float | None) -> str:
    """`+7.9` or `-0.7` of percentage points, or a dash."""
    return "-" if value is None else f"{value:+.1f}"


def duration(seconds: float) -> str:
    """`0.8 s`, `51 s`, `3.4 min`, `2.6 h`."""
    if seconds < 60:
        return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.1f} min" if seconds < 3600 else f"{seconds / 3600:.1f} h"


def thousands(number: int) -> str:
    """`6,560`."""
    return f"{number:,}"
