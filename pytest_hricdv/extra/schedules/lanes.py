"""Lanes: when each thread of the code went on around the decisions of a schedule."""

from __future__ import annotations

from pytest_hricdv.extra.schedules.records import NodeLane
from pytest_hricdv.extra.schedules.scheduler import US_PER_S, Scheduler

AROUND_S = 1.0
"""Switches are kept up to so long before and after a decision (s): within it people and robots react."""

MAX_SWITCHES = 500
"""Of a run: a busy second of ten threads."""


def lanes(scheduler: Scheduler) -> tuple[NodeLane, ...]:
    """Of each node that executed code then, in the order in which they began."""
    held = [entry for entry in scheduler.held_up if entry.kind != "delivery"]
    times = [(entry.time_s - AROUND_S, entry.time_s + entry.for_s + AROUND_S) for entry in scheduler.held_up]
    switches: list[tuple[str, float, str]] = []
    before = -1
    for point, thread, time_us in scheduler.steps:
        time_s = time_us / US_PER_S
        if thread != before and any(begin_s <= time_s <= end_s for begin_s, end_s in times):
            switches.append((scheduler.names[thread], time_s, scheduler.points.places[point]))
        before = thread
    shown = switches[:MAX_SWITCHES]
    return tuple(
        NodeLane(
            node=name,
            switches=tuple((time_s, place) for node, time_s, place in shown if node == name),
            held=tuple((entry.time_s, entry.time_s + entry.for_s, entry.place) for entry in held if entry.node == name),
        )
        for name in dict.fromkeys(scheduler.names)
    )
