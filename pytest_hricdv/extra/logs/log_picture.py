"""`LogPicture`: makes the timeline of a logged run in bounded memory, from extremes of signals and the first messages.

`judge` adds each signal and message to it while it reads the run.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from itertools import islice

from pytest_hricdv._base.message import MAX_LINE, cut
from pytest_hricdv.monitor import Verdict
from pytest_hricdv.recordings.bags import Value
from pytest_hricdv.results.model import Timeline
from pytest_hricdv.results.timeline import SPANS, trigger_text

MAX_MESSAGES = 2000
"""Maximum number of messages in the timeline of a run; no screen has room for more."""

MAX_TRIGGERS = 300
"""Maximum number of triggers of a requirement in the timeline."""

_Point = tuple[float, float]


class LogPicture:
    """Collects the timeline while the run is read: it keeps only values that are visible on the page."""

    def __init__(self, end_s: float) -> None:
        self._end_s, self._width_s = end_s, end_s / SPANS or 1.0
        self._signals: dict[str, dict[int, list[_Point]]] = {}
        self._messages: list[str] = []

    def add(self, time_s: float, name: str, value: Value | Mapping[str, Value]) -> None:
        """Add a value of a signal, or a message."""
        if isinstance(value, Mapping):
            if len(self._messages) < MAX_MESSAGES:
                fields = {
                    key: cut(entry, MAX_LINE) if isinstance(entry, str) else entry for key, entry in value.items()
                }
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

    def timeline(self, verdicts: Iterable[Verdict]) -> Timeline:
        """The run with the triggers of its requirements."""
        return Timeline(
            end_s=round(self._end_s, 3),
            messages=tuple(self._messages),
            signals={name: " ".join(map(_text, spans.values())) for name, spans in self._signals.items()},
            triggers={
                verdict.requirement: " ".join(map(trigger_text, islice(verdict.history, MAX_TRIGGERS)))
                for verdict in verdicts
                if verdict.history
            },
        )


def _text(points: Iterable[_Point]) -> str:
    return " ".join(f"{time_s:.3f} {value:.4g}" for time_s, value in sorted({*points}))
