"""Line charts as inline SVG, coloured by the page's style sheet so that they follow its light and dark themes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

from pytest_hricdv.report.axis import Axis

_WIDTH, _HEIGHT = 480, 270
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 12, 12, 44
_PLOT_WIDTH, _PLOT_HEIGHT = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
_MAX_DOTS = 12  # so few points get a dot each; more would hide the line

COLOURS = 6
"""Colours that the style sheet knows, `.c0` to `.c5`: told apart by colour-blind readers, and dashed differently."""

Point = tuple[float, float]


@dataclass(frozen=True)
class Curve:
    """A named sequence of points in the axes' units; `colour` is its number in the style sheet's palette."""

    name: str
    points: tuple[Point, ...]
    colour: int = 0
    note: str = ""


def svg(title: str, curves: Sequence[Curve], x: Axis, y: Axis) -> str:
    """The chart as an `<svg>` element that scales with the page; every name in it is escaped."""
    parts = [
        f'<svg class="chart" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(_told(title, curves))}">',
        *_grid(x, y),
        *(part for curve in curves for part in _curve(curve, x, y)),
        "</svg>",
    ]
    return "\n".join(parts)


def thinned(points: Sequence[Point], columns: int = _PLOT_WIDTH) -> tuple[Point, ...]:
    """At most two points a column, the lowest and the highest: a long curve keeps its shape and not its bytes."""
    if len(points) <= 2 * columns:
        return tuple(points)
    kept: list[Point] = []
    for column in range(columns):
        part = points[column * len(points) // columns : (column + 1) * len(points) // columns]
        ends = {min(part, key=_height), max(part, key=_height)}
        kept += sorted(ends)
    return (points[0], *kept, points[-1])


def _grid(x: Axis, y: Axis) -> Iterator[str]:
    bottom, right = _TOP + _PLOT_HEIGHT, _WIDTH - _RIGHT
    for value, text in y.ticks:
        height = _y(y, value)
        yield f'<path class="grid" d="M{_LEFT} {height}H{right}"/>'
        yield f'<text class="tick end" x="{_LEFT - 6}" y="{height}" dy=".35em">{escape(text)}</text>'
    for value, text in x.ticks:
        place = _x(x, value)
        yield f'<path class="axis" d="M{place} {bottom}v4"/>'
        yield f'<text class="tick middle" x="{place}" y="{bottom + 17}">{escape(text)}</text>'
    yield f'<path class="axis" d="M{_LEFT} {_TOP}V{bottom}H{right}"/>'
    yield f'<text class="label middle" x="{_LEFT + _PLOT_WIDTH / 2:g}" y="{_HEIGHT - 6}">{escape(x.label)}</text>'
    centre = f"{_TOP + _PLOT_HEIGHT / 2:g}"
    yield f'<text class="label middle" transform="translate(13 {centre}) rotate(-90)">{escape(y.label)}</text>'


def _curve(curve: Curve, x: Axis, y: Axis) -> Iterator[str]:
    colour = f"c{curve.colour % COLOURS}"
    points = [(_x(x, across), _y(y, up)) for across, up in thinned(curve.points)]
    if len(points) > 1:
        path = "L".join(f"{across} {up}" for across, up in points)
        yield f'<path class="curve {colour}" d="M{path}"><title>{escape(curve.name)}</title></path>'
    if len(points) <= _MAX_DOTS:
        for across, up in points:
            circle = f'<circle class="dot {colour}" cx="{across}" cy="{up}" r="3">'
            yield f"{circle}<title>{escape(curve.name)}</title></circle>"


def _told(title: str, curves: Sequence[Curve]) -> str:
    """The chart in words, for who cannot see it: each curve's last value."""
    ends = (f"{curve.name} ends at {curve.points[-1][1]:.4g}" for curve in curves if curve.points)
    return f"{title}: {'; '.join(ends)}"


def _x(axis: Axis, value: float) -> float:
    return round(_LEFT + axis.place(value) * _PLOT_WIDTH, 1)


def _y(axis: Axis, value: float) -> float:
    return round(_TOP + (1 - axis.place(value)) * _PLOT_HEIGHT, 1)


def _height(point: Point) -> float:
    return point[1]
