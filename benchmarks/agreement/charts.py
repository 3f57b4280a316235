"""The picture of the agreement: coverage of each test, then and now."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from benchmarks.agreement import original
from benchmarks.agreement.pair import Pair
from benchmarks.experiment.published import METHODS
from benchmarks.pictures import STYLES, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def coverage(pairs: Sequence[Pair]) -> Figure:
    """A mark for each pair of coverages, the larger the more tests have it."""
    made, (axes,) = figure()
    for (name, published), (colour, _, marker) in zip(METHODS.items(), STYLES, strict=True):
        mine = [each for each in pairs if original.method(each.theirs.suite) == name]
        points = Counter((each.theirs.coverage, each.ours.coverage) for each in mine)
        axes.scatter(
            [then for then, _ in points],
            [now for _, now in points],
            s=[18.0 * count for count in points.values()],
            marker=marker,
            facecolors="none",
            edgecolors=colour,
            linewidths=1.2,
            label=f"{published.title} ({len(mine)})",
        )
    axes.set_xlabel("statements covered in the original (% of 264)")
    axes.set_ylabel("statements covered here (%)")
    legend = axes.legend(loc="lower right", title="area: number of tests")
    for handle in legend.legend_handles:
        handle.set_sizes([30.0])  # type: ignore[union-attr]
    return made
