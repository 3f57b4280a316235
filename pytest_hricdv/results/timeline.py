"""The timeline of a run: messages, signals and triggers of monitors, as short text.

`report_builder` adds the `timeline` to each result; the page draws it, and baselines compare it. A record holds
thousands of changes of each signal: only what a picture can show is kept, including extremes.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from zlib import crc32

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.message import MAX_LINE, cut
from pytest_hricdv.monitor import Trigger, Verdict
from pytest_hricdv.results.model import TestResult, Timeline
from pytest_hricdv.runtime import Record, RecordedMessage
from pytest_hricdv.runtime.record import Value

SPANS = 80
"""Number of time spans of a signal's run; the least and the greatest value of each span are kept."""

_MARKS = {"passed": "", "failed": "!", "pending": "?"}


def timeline(record: Record, verdicts: Iterable[Verdict], end_s: float) -> Timeline:
    """The timeline of a run.

    Args:
        verdicts: the verdicts of its monitors.
        end_s: when it ended (s of simulated time).
    """
    return Timeline(
        end_s=round(end_s, 3),
        messages=tuple(map(_message, record.messages)),
        signals={name: _signal(*series, end_s) for name, series in sorted(record.signals.items())},
        triggers={
            verdict.requirement: " ".join(map(trigger_text, verdict.history)) for verdict in verdicts if verdict.history
        },
        checksums=dict(sorted(_checksums(record))),
        texts={
            name: tuple((round(time_s, 3), cut(text, MAX_LINE)) for time_s, text in zip(*series, strict=True))
            for name, series in sorted(record.texts.items())
        },
    )


def _message(message: RecordedMessage) -> str:
    values = {name: _cut(value) for name, value in message.fields.items()}
    fields = json.dumps(values, separators=(",", ":"))
    return "\t".join([_time(message.time_s), message.sender.replace("\t", " "), message.topic, fields])


def _cut(value: Value) -> Value:
    return cut(value, MAX_LINE) if isinstance(value, str) else value


def trigger_text(trigger: Trigger) -> str:
    """A trigger as a timeline has it."""
    return f"{_time(trigger.begin_s)}-{_time(trigger.end_s)}{_MARKS[trigger.outcome]}"


def _signal(times: Sequence[float], values: Sequence[float], end_s: float) -> str:
    return " ".join(f"{_time(times[n])} {values[n]:.4g}" for n in thin_signal(times, values, end_s))


def _checksums(record: Record) -> Iterator[tuple[str, str]]:
    for name, (times, values) in record.signals.items():
        yield name, f"{crc32(values, crc32(times)):08x}"
    for name, (times, texts) in record.texts.items():
        yield name, f"{crc32(json.dumps(texts).encode(), crc32(times)):08x}"


def thin_signal(times: Sequence[float], values: Sequence[float], end_s: float) -> Iterator[int]:
    """The places of the changes that are kept, in order: the first and the last, and each span's least and greatest.

    Args:
        times: the times of the changes, ascending (s).
        values: as many.
        end_s: when the run ended (s).
    """
    if len(times) <= 2 * SPANS:
        yield from range(len(times))
        return
    start = 0
    width_s = (max(end_s, times[-1]) - times[0]) / SPANS
    for span in range(1, SPANS + 1):
        stop = bisect_left(times, times[0] + span * width_s, start) if span < SPANS else len(times)
        part = values[start:stop]
        if part:
            ends = {start + part.index(min(part)), start + part.index(max(part))}
            if start == 0:
                ends.add(0)
            if stop == len(times):
                ends.add(stop - 1)
            yield from sorted(ends)
        start = stop


def _time(time_s: float) -> str:
    """Milliseconds are finer than any picture."""
    return f"{time_s:.3f}".rstrip("0").rstrip(".")


NOTHING = "nothing further"


def differing_events(one: TestResult | None, other: TestResult | None) -> tuple[str, str]:
    """The first different event of each of two runs; two empty strings if none differs."""
    timelines = [result.timeline if result is not None else None for result in (one, other)]
    if timelines[0] is None or timelines[1] is None:
        said = tuple(_without_run(result) for result in (one, other))
        return (said[0], said[1]) if said[0] != said[1] else ("", "")
    lists = [sorted(_events(timeline), key=lambda event: event[0]) for timeline in timelines if timeline is not None]
    for here, there in zip_longest(*lists):
        if here != there:
            return _text(here), _text(there)
    sums = [timeline.checksums for timeline in timelines if timeline is not None]
    for name in sorted(sums[0].keys() | sums[1].keys()):
        if sums[0].get(name) != sums[1].get(name):
            return (f"{name} differs in digits or instants that a timeline does not show",) * 2
    assert one is not None, "it has a timeline"
    assert other is not None, "it has a timeline"
    ends = tuple(f"{result.outcome}, {result.end_reason}" for result in (one, other))
    return (ends[0], ends[1]) if ends[0] != ends[1] else ("", "")


def _without_run(result: TestResult | None) -> str:
    if result is None:
        return "no result"
    if result.timeline is not None:
        return f"a run of {result.timeline.end_s:g} s"
    lines = result.failure.strip().splitlines()
    raised = [line.removeprefix("E").strip() for line in lines if line.startswith("E ")]
    return f"no run: {(raised or lines or ['it was not run'])[0]}"


def _events(timeline: Timeline) -> Iterator[tuple[float, str]]:
    for message in timeline.messages:
        time_s, sender, topic, fields = message.split("\t", 3)
        yield float(time_s), f"{sender} {topic} {fields}"
    for name, series in timeline.signals.items():
        values = series.split()
        for time_text, value in zip(values[::2], values[1::2], strict=True):
            yield float(time_text), f"{name} = {value}"
    for name, texts in timeline.texts.items():
        yield from ((at_s, f"{name} = {text!r}") for at_s, text in texts)
    yield timeline.end_s, "end of the run"


def _text(event: tuple[float, str] | None) -> str:
    return NOTHING if event is None else f"{event[0]:g} s: {event[1]}"
