"""What a picture can show of a logged run, in bounded memory: of signals the extremes, of messages the first ones."""

from __future__ import annotations

import json
from collections.abc import Mapping

from pytest_hricdv._base.message import MAX_LINE, cut
from pytest_hricdv.recordings.bags import Value
from pytest_hricdv.results.timeline import SPANS

MAX_MESSAGES = 2000
"""Messages of a run in its picture, which no screen has room for."""

_Point = tuple[float, float]


class LogPicture:
    """Thins a run while it is read.

    Args:
        end_s: when it ends.
    """

    def __init__(self, end_s: float) -> None:
        self._width_s = end_s / SPANS or 1.0
        self._signals: dict[str, dict[int, list[_Point]]] = {}
        self._messages: list[str] = []

    def add(self, time_s: float, name: str, value: Value | Mapping[str, Value]) -> None:
        """Add a value of a signal, or a message."""
        if isinstance(value, Mapping):
            if len(self._messages) < MAX_MESSAGES:
                fields = {key: cut(each, MAX_LINE) if isinstance(each, str) else each for key, each in value.items()}
                self._messages.append(f"{time_s:.3f}\tlog\t{name}\t{json.dumps(fields, separators=(',', ':'))}")
        elif isinstance(value, float | bool):
            spans, span, point = self._signals.setdefault(name, {}), int(time_s / self._width_s), (time_s, float(value))
            points = spans.get(span)
            if points is None:
                spans[span] = [point, point, point, point]  # the first, the least, the greatest, the last
                return
            if value < points[1][1]:
                points[1] = point
            elif value > points[2][1]:
                points[2] = point
            points[3] = point

    def signals(self) -> dict[str, str]:
        """As a timeline has them."""
        return {
            name: " ".join(
                f"{time_s:.3f} {value:.4g}" for points in spans.values() for time_s, value in sorted({*points})
            )
            for name, spans in self._signals.items()
        }

    def messages(self) -> tuple[str, ...]:
        """As a timeline has them."""
        return tuple(self._messages)
