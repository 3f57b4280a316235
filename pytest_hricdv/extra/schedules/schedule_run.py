"""Runs tests under schedules in forks, and observes violations, executed pairs, and the effects of decisions."""

from __future__ import annotations

import zlib
from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from itertools import chain, islice

import msgspec

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord
from pytest_hricdv.execution.forked import ForkError, InFork, fork
from pytest_hricdv.extra.schedules.execution import note_runs
from pytest_hricdv.extra.schedules.pairs import DataConflict, conflicts, thin
from pytest_hricdv.extra.schedules.scheduler import Scheduler, accesses
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.session.replaying import TestRerunner, name_test

MAX_PACKED = 50_000
"""Number of steps of a run that are packed."""


class HeldNode(PlainRecord, frozen=True, kw_only=True):
    """What a decision did: the place, the node that waited there, when and for how long (s), and what came between."""

    place: str
    node: str
    time_s: NotNegative
    for_s: NotNegative
    between: tuple[tuple[str, str], ...] = ()


class ScheduleRun(PlainRecord, frozen=True, kw_only=True):
    """A run with a schedule, or one without that was noted.

    Args:
        violated: requirements.
        faults: what else was wrong with it, a sentence each.
        threads: how many threads of the code, or tasks of asyncio, executed anything.
        conflicts: some of each pair.
        executed: place -> how often.
        ready: of each choice between nodes, how many were ready.
        actions: when they began (s), and their numbers from 1.
        held: what decisions did.
        steps: thread and point of what was executed, one after the other, as `pack_steps` packs the first ones.
        record: SHA-256 of the record.
    """

    violated: Names = ()
    faults: Names = ()
    threads: Count = 0
    conflicts: tuple[DataConflict, ...] = ()
    executed: Mapping[str, Count] = {}
    ready: tuple[Count, ...] = ()
    actions: tuple[tuple[NotNegative, Count], ...] = ()
    held: tuple[HeldNode, ...] = ()
    steps: bytes = b""
    record: str = ""

    @property
    def fails(self) -> frozenset[str]:
        """Requirements, and an empty text for a fault."""
        return frozenset(self.violated) | ({""} if self.faults else set())

    @property
    def involves(self) -> frozenset[str]:
        """Places where nodes were held up, and those that came in between."""
        places = [held.place for held in self.held] + [place for held in self.held for place, _ in held.between]
        return frozenset(place.rstrip("=") for place in places)


RunTest = Callable[[ConcreteTest], ScheduleRun | None]
"""Runs a test; None where the run came to no end."""


def runner(rerunner: TestRerunner) -> RunTest:
    """Runs tests in forks, so that whatever a schedule leads to ends with its run."""

    def run(test: ConcreteTest) -> ScheduleRun | None:
        process = fork()
        if isinstance(process, InFork):
            message = b"null"
            with suppress(BaseException):  # whatever it is: what stands above is for the process that was forked
                message = msgspec.json.encode(_run(rerunner, test))
            process.send_and_end(message)
        try:
            with rerunner.let_through():
                return msgspec.json.decode(process.message(), type=ScheduleRun | None)
        except ForkError:
            return None
        finally:
            process.close()

    return run


def _run(rerunner: TestRerunner, test: ConcreteTest) -> ScheduleRun | None:
    noted: list[Scheduler] = []
    note_runs(noted)
    result = rerunner.run(name_test(test, "schedule"))
    if result is None or not noted:
        return None
    violated = [
        verdict.requirement
        for verdict in result.verdicts
        if verdict.verdict == "Failed" and rerunner.is_violated(verdict.requirement, verdict)
    ]
    return msgspec.structs.replace(
        _summary(noted[0]),
        violated=tuple(violated),
        faults=result.errors,
        actions=tuple(zip(result.action_times_s, result.begun, strict=True)),
        record=result.record.sha256,
    )


def _summary(scheduler: Scheduler) -> ScheduleRun:
    places = scheduler.points.places
    return ScheduleRun(
        threads=len({step.thread for step in scheduler.steps}),
        conflicts=thin(conflicts(scheduler.steps, places, accesses(scheduler.points))),
        executed=dict(sorted(Counter(places[step.point] for step in scheduler.steps).items())),
        ready=tuple(choice.ready for choice in scheduler.choices),
        held=tuple(
            HeldNode(
                place=held.decision.place,
                node=held.node,
                time_s=round(held.time_s, 6),
                for_s=round(held.for_s, 6),
                between=held.meanwhile,
            )
            for held in scheduler.held_up
        ),
        steps=pack_steps((step.thread, step.point) for step in scheduler.steps),
    )


def pack_steps(steps: Iterable[tuple[int, int]]) -> bytes:
    """Threads and points, each as a number of 32 bits."""
    return zlib.compress(array("I", chain.from_iterable(islice(steps, MAX_PACKED))).tobytes())


def unpack_steps(packed: bytes) -> list[tuple[int, int]]:
    """What `pack_steps` has packed."""
    numbers = array("I")
    numbers.frombytes(zlib.decompress(packed) if packed else b"")
    return [*zip(numbers[::2], numbers[1::2], strict=True)]
