"""`ScheduleWorker`: runs tests under schedules in forks, and tells what each run violated, executed and waited for.

`post_session` makes one for its search or measurement. Its `run` takes a test and returns a `ScheduleRun`, which
`ScheduleSearch` and `RaceExamination` evaluate.
"""

from __future__ import annotations

import os
import zlib
from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import chain, islice
from operator import itemgetter

import msgspec

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord
from pytest_hricdv.execution.case import UNMEASURED
from pytest_hricdv.execution.forks import Fork, ForkError, InFork, fork
from pytest_hricdv.extra.schedules.execution import INSTRUMENTATION
from pytest_hricdv.extra.schedules.pairs import DataConflict, ExecutedSteps
from pytest_hricdv.extra.schedules.scheduler import HeldNode, Scheduler, instrument_points
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.session.replaying import TestRerunner, name_test

MAX_PACKED = 50_000
"""Maximum number of steps that `pack_steps` keeps of a run, the first ones."""


class ScheduleRun(PlainRecord, frozen=True, kw_only=True):
    """A run with a schedule, or one without that was noted.

    Args:
        violated: the requirements that it violated.
        faults: what else was wrong with it, a sentence each.
        threads: how many threads of the code, or tasks of asyncio, executed anything.
        conflicts: some executions of each pair.
        executed: place -> how often.
        ready: for each choice between nodes, how many were ready, and the place that was executed next.
        messages: topic -> how many were published.
        arrivals: topics of messages in the order of their arrival, if one was late.
        actions: the times (s) at which actions began, and their numbers from 1.
        held: the effect of each decision of the schedule.
        steps: thread and point of what was executed, one after the other, as `pack_steps` packs the first ones.
        is_deadlock: whether nodes waited for locks of each other when it was over.
        waits: waits without end when the run was over, a sentence each.
        record: SHA-256 of the record.
        ended: how it ended.
    """

    violated: Names = ()
    faults: Names = ()
    threads: Count = 0
    conflicts: tuple[DataConflict, ...] = ()
    executed: Mapping[str, Count] = {}
    ready: tuple[tuple[Count, str], ...] = ()
    messages: Mapping[str, Count] = {}
    arrivals: Names = ()
    actions: tuple[tuple[NotNegative, Count], ...] = ()
    held: tuple[HeldNode, ...] = ()
    steps: bytes = b""
    is_deadlock: bool = False
    waits: Names = ()
    record: str = ""
    ended: str = ""
    outcomes: Names = ()

    @property
    def fails(self) -> frozenset[str]:
        """Requirements, and an empty string for a fault."""
        return frozenset(self.violated) | ({""} if self.faults else set())

    @property
    def involves(self) -> frozenset[str]:
        """Places where nodes were held up, and those that came in between."""
        places = [held.place for held in self.held] + [place for held in self.held for place, _ in held.between]
        return frozenset(place.rstrip("=") for place in places)


RunTest = Callable[[ConcreteTest], ScheduleRun | None]
"""Runs a test; None where the run came to no end."""

_BYTES = 8
"""Size (bytes) of the length in front of a request."""


class ScheduleWorker:
    """A fork of the session whose code is instrumented, and that runs one test after the other.

    After a run with a fault, or one that did not end, the next run takes place in a new fork: what a schedule has
    damaged ends with its run.
    """

    def __init__(self, rerunner: TestRerunner) -> None:
        self.rerunner = rerunner
        self._process: Fork | None = None
        self._writing = -1

    def run(self, test: ConcreteTest) -> ScheduleRun | None:
        """See `RunTest`."""
        process = self._process or self._start()
        ran = None
        try:
            data = test.to_json().encode()
            with self.rerunner.let_through():
                os.write(self._writing, len(data).to_bytes(_BYTES, "big") + data)
                ran = msgspec.json.decode(process.message(), type=ScheduleRun | None)
        except (ForkError, BrokenPipeError):
            ran = None
        finally:
            if ran is None or ran.faults:
                self.close()
        return ran

    def close(self) -> None:
        """End the fork."""
        if self._process is not None:
            os.close(self._writing)
            self._process.close()
        self._process = None

    @property
    def pid(self) -> int | None:
        """Of the fork; None where there is none."""
        return None if self._process is None else self._process.pid

    def _start(self) -> Fork:
        reading, self._writing = os.pipe()
        process = fork()
        if isinstance(process, InFork):
            os.close(self._writing)
            with suppress(BaseException):  # whatever it is: what stands above is for the process that was forked
                self._serve(process, reading)
            process.send_and_end(b"null")
        os.close(reading)
        self._process = process
        return process

    def _serve(self, process: InFork, reading: int) -> None:
        self.rerunner = replace(self.rerunner, settings=self.rerunner.settings.with_measurement(UNMEASURED))
        with open(reading, "rb") as requests, instrument_points(self.rerunner.settings.testbench.code) as points:
            INSTRUMENTATION.points = points
            while length := requests.read(_BYTES):
                test = ConcreteTest.from_json(requests.read(int.from_bytes(length, "big")).decode())
                process.send(msgspec.json.encode(self._observe(test)))

    def _observe(self, test: ConcreteTest) -> ScheduleRun | None:
        INSTRUMENTATION.last = None
        result = self.rerunner.run(name_test(test, "schedule"))
        if result is None or INSTRUMENTATION.last is None:
            return None
        violated = [
            verdict.requirement
            for verdict in result.verdicts
            if verdict.verdict == "Failed" and self.rerunner.is_violated(verdict.requirement, verdict)
        ]
        return msgspec.structs.replace(
            _summary(INSTRUMENTATION.last),
            violated=tuple(violated),
            faults=result.errors,
            actions=tuple(zip(result.action_times_s, result.begun, strict=True)),
            record=result.record.sha256,
            ended=result.outcome.ended,
            outcomes=tuple(result.outcome.outcomes),
        )


def _summary(scheduler: Scheduler) -> ScheduleRun:
    points, steps, places = scheduler.points, scheduler.steps, scheduler.points.places
    is_late = any(decision.kind == "delivery" for decision in scheduler.decisions)
    executed = ExecutedSteps(steps, scheduler.nodes, places, points.accesses)
    return ScheduleRun(
        threads=len(scheduler.nodes),
        conflicts=executed.conflicts(),
        executed=executed.executed,
        ready=tuple((count, places[steps[step][0]] if step < len(steps) else "") for count, step in scheduler.choices),
        is_deadlock=scheduler.is_deadlock,
        waits=tuple(scheduler.waits),
        messages=Counter(topic for _, topic in scheduler.messages),
        arrivals=tuple(topic for _, topic in sorted(scheduler.messages, key=itemgetter(0))) if is_late else (),
        held=tuple(scheduler.held_up),
        steps=pack_steps((thread, point) for point, thread, _ in steps),
    )


def pack_steps(steps: Iterable[tuple[int, int]]) -> bytes:
    """Threads and points, each as a number of 32 bits."""
    return zlib.compress(array("I", chain.from_iterable(islice(steps, MAX_PACKED))).tobytes(), 1)


def unpack_steps(packed: bytes) -> list[tuple[int, int]]:
    """What `pack_steps` has packed."""
    numbers = array("I")
    numbers.frombytes(zlib.decompress(packed) if packed else b"")
    return [*zip(numbers[::2], numbers[1::2], strict=True)]
