"""Runs of a robot that serves orders, made up: what is suggested of them is known."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Mapping, Sequence

from pytest_hricdv.extra.suggestion.events import Runs
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage, StoredRun
from pytest_hricdv.monitor import Vocabulary

VOCABULARY = Vocabulary(
    signals={"tap_open": bool, "cup": bool, "level": float},
    messages={"order": {}, "served": {"level": float, "number": float}, "refused": {}},
)
Changes = Sequence[tuple[float, float]]
Sent = tuple[float, str, str, dict[str, float]]
"""Of a message: time (s), sender, topic, fields."""


def run(
    name: str,
    signals: Mapping[str, Changes],
    messages: Iterable[tuple[float, str, str, dict[str, bool | int | float | str]]],
    end_s: float,
) -> StoredRun:
    """A run with these changes of signals, and these messages: time (s), sender, topic, fields."""
    return StoredRun(
        test=name,
        sha256=name,
        end_s=end_s,
        signals={
            signal: (array("d", [at for at, _ in changes]).tobytes(), array("d", [v for _, v in changes]).tobytes())
            for signal, changes in signals.items()
        },
        messages=tuple(StoredMessage(*message) for message in sorted(messages, key=lambda each: each[0])),
        own_topics=("refused", "served"),
        own_signals=("tap_open",),
        other_signals=("cup",),
    )


def serving(name: str, delays_s: Sequence[float], *, refuses_after_s: float | None = None) -> StoredRun:
    """An order every 20 s, each served after its delay (s); in the end one without a cup."""
    signals: dict[str, list[tuple[float, float]]] = {
        "tap_open": [(0.0, 0.0)],
        "cup": [(0.0, 1.0)],
        "level": [(0.0, 0.0)],
    }
    messages: list[tuple[float, str, str, dict[str, bool | int | float | str]]] = []
    for number, delay_s in enumerate(delays_s, 1):
        at = 20.0 * number
        messages += [(at, "person", "order", {}), (at + delay_s, "robot", "served", {"level": 150.0, "number": number})]
        signals["tap_open"] += [(at, 1.0), (at + delay_s, 0.0)]
        signals["level"] += [(at + delay_s, 150.0), (at + 15.0, 0.0)]
    end_s = 20.0 * (len(delays_s) + 2)
    if refuses_after_s is not None:
        signals["cup"].append((end_s - 15.0, 0.0))
        messages += [(end_s - 14.0, "person", "order", {}), (end_s - 14.0 + refuses_after_s, "robot", "refused", {})]
    return run(name, signals, messages, end_s)


def some_runs(**changes: float) -> list[StoredRun]:
    """Three runs with delays from 4 to 6 s, each with a refusal after 0.2 s."""
    delays = ((4.0, 5.0), (6.0, 4.5), (5.5, 5.0, 4.2))
    return [
        serving(f"test-{place}", some, refuses_after_s=changes.get("refuses_after_s", 0.2))
        for place, some in enumerate(delays)
    ]


def views(runs: Sequence[StoredRun]) -> Runs:
    """What is mined."""
    return Runs(runs, VOCABULARY, frozenset({"person"}))
