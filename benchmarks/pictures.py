"""Pictures of figures: colours that colour-blind people can tell apart, and the same bytes for the same figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Okabe and Ito (2008), Color universal design; with a dash pattern and a marker each, for prints without colours.
STYLES: tuple[tuple[str, str, str], ...] = (
    ("#0072B2", "-", "o"),
    ("#D55E00", "--", "s"),
    ("#009E73", "-.", "^"),
    ("#CC79A7", ":", "D"),
)
GREY = "#595959"
SIZE_IN = (7.2, 4.2)

Points = Sequence[tuple[float, float]]


def figure(panels: int = 1) -> tuple[Figure, list[Axes]]:
    """A figure of some panels side by side, and their axes."""
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
    """A curve a name, with a legend.

    Args:
        lines: name -> points.
        x: what the axis says, with its unit.
        y: likewise.
        drawn: how points are joined, as in matplotlib's `drawstyle`.
        more: of `Axes.plot`.
    """
    for (name, points), (colour, dashes, _) in zip(lines.items(), STYLES, strict=False):
        across, up = [point[0] for point in points], [point[1] for point in points]
        axes.plot(across, up, color=colour, linestyle=dashes, linewidth=1.6, label=name, drawstyle=drawn, **more)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if len(lines) > 1:
        axes.legend()


def save(made: Figure, path: Path) -> None:
    """Write an SVG, aside and then renamed: no date in it, so the same figures give the same bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f"{path.name}.part")
    made.savefig(aside, format="svg", metadata={"Date": None, "Creator": None})
    aside.replace(path)
