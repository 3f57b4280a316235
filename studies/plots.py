"""Charts for docs/: colours for colour-blind readers; the same data give the same bytes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_hricdv._base import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Okabe and Ito (2008), Color universal design; with a dash pattern and a marker each, for prints without colours.
STYLES: tuple[tuple[str, str | tuple[int, tuple[int, ...]], str], ...] = (
    ("#0072B2", "-", "o"),
    ("#D55E00", "--", "s"),
    ("#009E73", "-.", "^"),
    ("#CC79A7", ":", "D"),
    ("#E69F00", (0, (5, 1, 1, 1, 1, 1)), "v"),
)
GREY = "#595959"
SIZE_IN = (7.2, 4.2)  # the width of a column of text in docs/, so that font sizes are those of the text

Points = Sequence[tuple[float, float]]


def figure(panels: int = 1) -> tuple[Figure, list[Axes]]:
    """A figure with panels side by side, and their axes."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    mpl.rcParams.update(
        {
            "svg.hashsalt": "pytest-hricdv",  # ids in an SVG are random otherwise
            "svg.fonttype": "path",  # the same picture whatever fonts a reader has
            "font.family": "DejaVu Sans",  # ships with matplotlib
            "font.size": 9,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "grid.color": "#D9D9D9",
            "grid.linewidth": 0.6,
            "legend.frameon": False,
        }
    )
    made = Figure(figsize=SIZE_IN if panels == 1 else (SIZE_IN[0] * 1.35, SIZE_IN[1]), layout="constrained")
    return made, list(made.subplots(1, panels, squeeze=False)[0])


def curves(axes: Axes, lines: Mapping[str, Points], *, x: str, y: str, drawn: str = "default", **more: Any) -> None:
    """One curve for each name, with a legend.

    Args:
        lines: name -> points.
        x: label of the axis, with its unit.
        y: likewise.
        drawn: how points are joined: matplotlib's `drawstyle`.
        more: further arguments of `Axes.plot`.
    """
    for (name, points), (colour, dashes, _) in zip(lines.items(), STYLES, strict=False):
        across, up = [point[0] for point in points], [point[1] for point in points]
        axes.plot(across, up, color=colour, linestyle=dashes, linewidth=1.6, label=name, drawstyle=drawn, **more)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if len(lines) > 1:
        axes.legend()


def save(made: Figure, path: Path) -> None:
    """Write an SVG file atomically; without a date, so that the same data give the same bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    image = io.BytesIO()
    made.savefig(image, format="svg", metadata={"Date": None, "Creator": None})
    atomic_file.write_bytes(path, image.getvalue())
