"""Which tests run again (failures first, then of each way to end one, the longest first), and how their runs differ."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest

from pytest_hricdv.results.model import TestResult, Timeline

MIN_TESTS = 3
"""Tests that every session runs again; 9 to 12 s of processor time with the table (`benchmarks.isolation`)."""

BUDGET = 0.03
"""Share of the time of all tests within which more run again; by the same benchmark, 3 to 4 % of a session."""


def choose_tests(results: Sequence[TestResult], place: Mapping[str, int], number: int | None) -> list[TestResult]:
    """The tests to run again, in order.

    Args:
        results: of the session's tests.
        place: node id -> how many tests ran before it in its process; those that did not run in this session have none.
        number: how many; None: `MIN_TESTS`, or more within `BUDGET` of the time.
    """
    ways: dict[tuple[object, ...], list[TestResult]] = defaultdict(list)
    for result in results:
        if result.nodeid in place and result.outcome != "not-run":
            ways[(not result.fails, result.outcome, result.end_reason, result.outcomes)].append(result)
    # What ran late in its process has the most before it that may have left something.
    lists = [sorted(group, key=lambda result: (-place[result.nodeid], result.id)) for group in ways.values()]
    lists.sort(key=lambda group: -sum(result.sim_s for result in group) / len(group))
    failing = [group for group in lists if group[0].fails]
    others = [group for group in lists if not group[0].fails]
    order = [*_in_turn(failing), *_in_turn(others)]
    if number is not None:
        return order[:number]
    budget_s = BUDGET * sum(result.wall_s or 0.0 for result in results)
    tests: list[TestResult] = []
    for result in order:
        budget_s -= result.wall_s or 0.0
        if len(tests) >= MIN_TESTS and budget_s < 0.0:
            break
        tests.append(result)
    return tests


def _in_turn(groups: Sequence[Sequence[TestResult]]) -> list[TestResult]:
    """One of each group, then the next of each."""
    return [result for row in zip_longest(*groups) for result in row if result is not None]


NOTHING = "nothing further"


def first_difference(one: TestResult | None, other: TestResult | None) -> tuple[str, str]:
    """What the first event that differs is in each of two runs; two empty texts where none differs."""
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
            return (f"{name} differs in digits or instants that a timeline has not",) * 2
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
