"""Records of schedules in `report.json`: schedules under which tests fail, time budgets, and when threads ran.

`post_session` makes a `ScheduleResult` with its `RaceRecord`s and a `BudgetRecord` per function or loop; `scheduler`
makes the `NodeLane`s of a test with a schedule. `view` shows all of them.
"""

from __future__ import annotations

from typing import Literal, TypeVar

from msgspec.structs import replace

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord, ReplayName, TestId
from pytest_hricdv._base.schedule_record import FailureKind, ScheduleData
from pytest_hricdv.results.section import FileNames, Section, TestSection

ScheduleSearchEnd = Literal["done", "nothing to order", "interrupted"]
"""Why the search ended. `nothing to order`: no test ran two nodes, threads or callbacks of the code."""

OTHERWISE = "they do not pass in a process of their own, as they did in the session"
"""Why tests are left out of the search, as the end of a sentence."""


class RaceRecord(PlainRecord, frozen=True, kw_only=True):
    """A schedule under which a test fails that passes under the usual one.

    Args:
        requirement: the requirement that is violated; empty for a fault.
        fault: what else is wrong, a sentence.
        test: id of the test, which passes under the usual schedule.
        failure_kind: see `FailureKind`.
        schedule: the schedule, with the fewest decisions.
        words: what happens under it, a sentence.
        least_s: the shortest delay with which the test fails (s).
        is_counted: whether it fails the session; a late one does if `Timing(slowest_s=...)` is declared.
        found_after: the number of runs until it was found.
        id: the id of the test with this schedule.
        replay: the replay file of this test.
    """

    requirement: str
    fault: str = ""
    test: TestId
    failure_kind: FailureKind
    schedule: ScheduleData | None = None
    words: str
    least_s: NotNegative
    is_counted: bool
    found_after: Count
    id: TestId | None = None
    replay: ReplayName | None = None


class NodeLane(PlainRecord, frozen=True, kw_only=True):
    """When a thread of the code ran around the decisions of a schedule.

    Args:
        node: its name.
        switches: when another thread stopped and this one resumed (s of simulated time), and the statement there.
        held: from when to when it was held up (s), and before which statement.
    """

    node: str
    switches: tuple[tuple[NotNegative, str], ...] = ()
    held: tuple[tuple[NotNegative, NotNegative, str], ...] = ()


class BudgetRecord(PlainRecord, frozen=True, kw_only=True):
    """How slow a function or the body of a loop may be, each time, before a requirement fails.

    Args:
        place: the place of its first statement.
        name: the function's name.
        budget_s: the longest delay with which all tests pass (s); with a millisecond more, one fails.
        requirement: the requirement that it violates then; empty for a fault, or where none fails.
        test: the test that violates it; None where none does up to `budget_s`.
        other: place and name of another one that is as slow at the same time.
        replay: the replay of this test, a millisecond slower than `budget_s`.
    """

    place: str
    name: str
    budget_s: NotNegative
    requirement: str = ""
    test: TestId | None = None
    other: str = ""
    replay: ReplayName | None = None


class ScheduleResult(PlainRecord, frozen=True, kw_only=True):
    """The result of a search for schedules.

    Args:
        runs: number of runs with schedules that were made.
        tests: the tests whose runs were noted.
        slowest_s: the longest time for which a node was held up (s).
        races: the first of each kind.
        pairs: number of pairs of statements of different nodes on the same data that came right after each other in
            some run.
        both: number of these that came in either order.
        open: pairs that came in one order only, `first before second`; the first of them.
        left_out: tests whose run in a process of its own is not that of the session.
        lost: runs with schedules that came to no end.
        end_reason: why it ended.
    """

    runs: Count
    tests: Count
    left_out: Count = 0
    lost: Count = 0
    slowest_s: NotNegative
    races: tuple[RaceRecord, ...] = ()
    pairs: Count = 0
    both: Count = 0
    open: Names = ()
    end_reason: ScheduleSearchEnd = "done"


Kept = TypeVar("Kept", RaceRecord, BudgetRecord)


def _rename(result: ScheduleResult | None, names: FileNames) -> ScheduleResult | None:
    if result is None:
        return None
    return replace(result, races=_rename_replays(result.races, names))


def _rename_replays(records: tuple[Kept, ...], names: FileNames) -> tuple[Kept, ...]:
    return tuple(replace(record, replay=names.replay(record.replay)) for record in records)


SCHEDULES: Section[ScheduleResult | None] = Section("schedules", ScheduleResult | None, None, rename=_rename)
"""Of a session that searched for schedules."""

BUDGETS: Section[tuple[BudgetRecord, ...]] = Section("budgets", tuple[BudgetRecord, ...], (), rename=_rename_replays)
"""Of a session that measured them, the smallest first."""

THREADS: TestSection[int] = TestSection("threads", int, 0)
"""Of a test in whose run the code had more than one thread, or node of ROS 2: how many."""

FAILURE_KIND: TestSection[FailureKind] = TestSection("failure_kind", FailureKind, "")
"""Of a failing test that a search for schedules has made."""

LANES: TestSection[tuple[NodeLane, ...]] = TestSection("lanes", tuple[NodeLane, ...], ())
"""Of a test with a schedule."""

SECTIONS, TEST_SECTIONS = (SCHEDULES, BUDGETS), (THREADS, FAILURE_KIND, LANES)
