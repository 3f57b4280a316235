"""`CauseSearch` finds why a rerun test gave another result, by experiments that change one condition each.

`Auditor` uses it, and reports the `RepeatCause` that it returns. A `Repeater` runs the experiments.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.extra.audit.process import RerunAnswer, RerunOrder
from pytest_hricdv.extra.audit.repeating import Repeater
from pytest_hricdv.extra.audit.sources import KINDS, Reading

NOT_FOUND = "not found"
HASH_ORDER = "hash order"
STATE = "state of earlier tests"
ONCE = "drawn once in a process"
ENVIRONMENT = "environment"
FILE = "file left behind"
"""Names of causes; further causes are the kinds of sources of nondeterminism (`sources.KINDS`)."""

FURTHER_SEEDS = 5
"""Number of other hash seeds to try. Two seeds order two elements alike with probability 1/2, so a dependence on the
order stays hidden with probability 1/32."""

MOST_BEFORE = 1_000
"""Maximum number of preceding tests among which the one that left the state is searched for. Chosen: it takes ten
doublings and ten halvings; other values were not measured."""

WORKER = {"PYTEST_XDIST_WORKER": "gw0", "PYTEST_XDIST_WORKER_COUNT": "2", "PYTEST_XDIST_TESTRUNUID": "audit"}
"""Variables of the environment that xdist sets in its workers."""


class OutOfTimeError(Exception):
    """The experiments have taken as long as they may."""


@dataclass(frozen=True)
class RepeatCause:
    """Why a test gave another result; see `records.Unrepeatable`."""

    name: str
    detail: str
    left_by: str = ""


@dataclass
class CauseSearch:
    """Experiments on one test.

    Args:
        repeating: runs tests.
        nodeid: the test.
        session_key: what it came to in the session (see `repeating.key_of`).
        alone: what it came to alone, under `hash_seed`.
        hash_seed: the hash seed of a fresh process.
        session_seed: the hash seed of the process in which it ran; empty if unknown.
        in_process: the tests that ran in its process, in order.
        changed: files of the project that the session wrote: path -> the test that ran then; empty: none is known.
        was_in_worker: whether it ran in a worker of xdist.
        until_s: no experiment begins later (by `time.monotonic`).
    """

    repeating: Repeater
    nodeid: str
    session_key: tuple[str | None, str]
    alone: RerunAnswer
    hash_seed: str
    session_seed: str
    in_process: Sequence[str]
    changed: Mapping[str, str]
    was_in_worker: bool
    until_s: float
    _place: Callable[[str], str] = field(default=os.path.basename)

    def cause(self) -> RepeatCause:
        """Why it differed. A silent process, or experiments that take too long, leave the cause unknown."""
        try:
            for experiment in (self._chance, self._state, self._order, self._files, self._worker):
                cause = experiment()
                if cause is not None:
                    return cause
        except OutOfTimeError:
            return RepeatCause(NOT_FOUND, "the time for experiments ran out")
        return RepeatCause(
            NOT_FOUND, f"neither hash seed, nor tests before it, nor chance make the difference{self._reads()}"
        )

    def _run(self, order: RerunOrder, seed: str | None = None, **options: object) -> RerunAnswer:
        if time.monotonic() > self.until_s:
            raise OutOfTimeError
        return self.repeating.run(order, self.hash_seed if seed is None else seed, **options)  # type: ignore[arg-type]

    def _single(self, **options: object) -> RerunOrder:
        return RerunOrder((self.nodeid,), **options)  # type: ignore[arg-type]

    # Chance: the same once more, in the same process and in another one

    def _chance(self) -> RepeatCause | None:
        again = self._run(self._single())
        other = self._run(self._single(), copy=1)
        if again.key == self.alone.key == other.key:
            return None
        if again.key == self.alone.key and self._run(self._single(), copy=1).key == other.key:
            differ = "each process repeats itself, and two with the same hash seed differ"
            why = "something was drawn when a module was imported, or is the id() of an object or thread"
            return RepeatCause(ONCE, f"{differ}: {why}{self._reads()}")
        return self._still() or self._left_files(again, everywhere=True) or self._observation()

    def _still(self) -> RepeatCause | None:
        """The kind of source that makes two runs the same when it is frozen."""
        readings = self._readings()
        for kind in KINDS:
            places = [reading for reading in readings if reading.kind == kind]
            if places and self._is_same(self._single(still=(kind,))):
                detail = f"alone, runs differ from each other, and are the same when it is frozen; {_at(places)}"
                return RepeatCause(kind, detail)
        if readings and self._is_same(self._single(still=KINDS)):
            return RepeatCause(" and ".join(dict.fromkeys(reading.kind for reading in readings)), _at(readings))
        return None

    def _is_same(self, order: RerunOrder) -> bool:
        keys = {self._run(order, copy=copy).key for copy in (0, 1, 0)}
        return len(keys) == 1

    def _observation(self) -> RepeatCause:
        readings = self._readings()
        if readings:
            kinds = " or ".join(dict.fromkeys(reading.kind for reading in readings))
            return RepeatCause(kinds, f"alone, under the same conditions, runs differ from each other; {_at(readings)}")
        return RepeatCause(
            NOT_FOUND,
            "alone, under the same conditions, runs differ from each other: chance, a thread, or a set of objects, "
            "which goes in the order of their addresses",
        )

    def _readings(self) -> tuple[Reading, ...]:
        return self._run(self._single(watched=True)).readings

    def _reads(self) -> str:
        readings = self._readings()
        return f"; {_at(readings)}" if readings else ""

    # Hash order

    def _order(self) -> RepeatCause | None:
        if self.session_seed:
            if self.session_seed == self.hash_seed:
                return None
            under_its_own = self._run(self._single(), self.session_seed)
            if under_its_own.key == self.alone.key:
                return None
            same = "as in the session" if under_its_own.key == self.session_key else "otherwise"
            return RepeatCause(
                HASH_ORDER,
                f"alone it runs {same} with PYTHONHASHSEED={self.session_seed}, and differs with {self.hash_seed}: "
                "something depends on the order of a set of strings, or on hash()",
            )
        for number in range(FURTHER_SEEDS):
            seed = str(int(self.hash_seed) + number + 1)
            if self._run(self._single(), seed).key != self.alone.key:
                return RepeatCause(
                    HASH_ORDER,
                    f"alone it differs between PYTHONHASHSEED={self.hash_seed} and {seed}, and repeats with each: "
                    "something depends on the order of a set of strings, or on hash()",
                )
        return None

    # State of earlier tests

    def _state(self) -> RepeatCause | None:
        """The last test that makes a difference when it runs before: found by doubling, then by halving."""
        place = self.in_process.index(self.nodeid) if self.nodeid in self.in_process else 0
        before = self.in_process[max(0, place - MOST_BEFORE) : place]
        if not before:
            return None
        among = (*before, self.nodeid) if len(self.in_process) > MOST_BEFORE else self.in_process

        def differs(start: int, end: int | None = None) -> bool:
            order = RerunOrder((*before[start:end], self.nodeid))
            return self._run(order, among=among).key != self.alone.key

        size, least = 1, 0
        while not differs(len(before) - size):
            if size == len(before):
                return None
            least, size = size, min(2 * size, len(before))
        try:
            while size - least > 1:
                middle = (size + least) // 2
                if differs(len(before) - middle):
                    size = middle
                else:
                    least = middle
        except OutOfTimeError:
            return RepeatCause(
                STATE, f"it runs differently after the {size} tests before it; time ran out before it was clear which"
            )
        start = len(before) - size
        culprit = before[start]
        after = culprit
        if size > 1 and not differs(start, start + 1):
            after += f" and the {size - 1} tests after that"
        remedy = "--hri-isolate keeps tests apart"
        return RepeatCause(
            f"state that {culprit} leaves", f"alone it repeats, and runs differently after {after}; {remedy}", culprit
        )

    # Present in one and not in the other

    def _files(self) -> RepeatCause | None:
        return self._left_files(self.alone)

    def _left_files(self, reference: RerunAnswer, *, everywhere: bool = False) -> RepeatCause | None:
        """A file that it reads, and without which it runs differently, but repeatably.

        Args:
            reference: how it runs with it.
            everywhere: whether to list more than the project's files that were written since the session began.
        """
        paths = dict.fromkeys(reading.path for reading in self._readings())
        for path in (path for path in paths if path in self.changed or (everywhere and _may_be_left(path))):
            hidden, again = (self._run(self._single(hidden=(path,))) for _ in range(2))
            if hidden.key == again.key != reference.key:
                left_by = self.changed.get(path, "")
                by = f", written while {left_by} ran" if left_by else ""
                return RepeatCause(
                    f"{FILE}: {self._place(path)}", f"it reads {path}{by}, and runs differently without it", left_by
                )
        return None

    def _worker(self) -> RepeatCause | None:
        if not self.was_in_worker or self._run(self._single(), variables=WORKER).key == self.alone.key:
            return None
        return RepeatCause(
            f"{ENVIRONMENT}: PYTEST_XDIST_WORKER",
            "alone it runs differently with the environment variables of an xdist worker",
        )


def _may_be_left(path: str) -> bool:
    """Whether it is a file, and none of the system's."""
    return bool(path) and not path.startswith(("/dev/", "/proc/", "/sys/"))


def _at(readings: Sequence[Reading]) -> str:
    """`it reads time.time at world.py:12, ...`."""
    named = [
        f"{reading.what}{f' of {reading.path}' if reading.path else ''} at {reading.place}" for reading in readings[:4]
    ]
    return f"it calls {', '.join(named)}{' and more' if len(readings) > len(named) else ''}"
