"""Races: minimal schedules under which a test fails, and the kind of each failure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from pytest_hricdv._base.message import list_names
from pytest_hricdv.extra.schedules.schedule_run import RunTest, ScheduleRun, unpack_steps
from pytest_hricdv.extra.schedules.scheduler import HeldNode
from pytest_hricdv.extra.schedules.search import ScheduleCandidate
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.schedule import ScheduleDecision

JUST_S = 1e-6
"""A delay that is shorter by this (s) than a hold does not change the order. As fine as virtual time is."""

HALVINGS = 12
"""Of a delay, until it is known to a five-thousandth of itself."""

RaceKind = Literal["wrong-order", "late"]


@dataclass(frozen=True)
class ScheduleRace:
    """A schedule under which a test fails.

    Args:
        test: with the fewest decisions.
        ran: its run.
        kind: `wrong-order` if it fails because of the order of two threads or tasks, `late` if a delay does it that
            changes no order.
        least_s: the least delay that does it (s), where it is late.
        runs: that it took to find out.
    """

    test: ConcreteTest
    ran: ScheduleRun
    kind: RaceKind
    least_s: float
    runs: int


@dataclass
class RaceExamination:
    """Takes decisions away while the test fails, and tells order from delay.

    Args:
        run: runs tests.
        fails: whether a run fails in the same way.
        is_moved: a parameter of the test was moved, so that it may fail without any decision.
    """

    run: RunTest
    fails: Callable[[ScheduleRun], bool]
    is_moved: bool
    runs: int = 0
    last: ScheduleRun | None = None

    def examine(self, test: ConcreteTest, ran: ScheduleRun) -> ScheduleRace:
        """What is left of a schedule under which a test fails."""
        test, ran = self._least(test, ran)
        late = self._late(test, ran) if test.schedule else None
        kind: RaceKind = "wrong-order"
        least_s = sum(held.for_s for held in ran.held)
        if late is not None:
            test, ran, least_s, before = self._shortest(*late)
            kind = "wrong-order" if before is None or is_other_order(before, ran) else "late"
        return ScheduleRace(_name_nodes(test, ran), ran, kind, least_s, self.runs)

    def _tries(self, test: ConcreteTest) -> ScheduleRun | None:
        """The run, if it fails in the same way."""
        self.runs += 1
        self.last = self.run(test)
        return self.last if self.last is not None and self.fails(self.last) else None

    def _least(self, test: ConcreteTest, ran: ScheduleRun) -> tuple[ConcreteTest, ScheduleRun]:
        """Without decisions that it does not need: those that come last are tried first."""
        place = len(test.schedule) - 1
        while place >= 0 and (len(test.schedule) > 1 or self.is_moved):
            fewer = replace(test, schedule=(*test.schedule[:place], *test.schedule[place + 1 :]))
            if (shorter := self._tries(fewer)) is not None:
                test, ran = fewer, shorter
            place -= 1
        return test, ran

    def _late(self, test: ConcreteTest, ran: ScheduleRun) -> tuple[ConcreteTest, ScheduleRun] | None:
        """The same delays without the other order, if the test fails then, too: each a little shorter than the hold."""
        if any(decision.kind == "order" for decision in test.schedule) or all(
            held.for_s <= JUST_S for held in ran.held
        ):
            return None  # a delay of no time is nothing but an order
        delays = tuple(_delay(decision, ran.held) for decision in test.schedule)
        delayed = replace(test, schedule=delays)
        again = self._tries(delayed)
        return None if again is None else (delayed, again)

    def _shortest(
        self, test: ConcreteTest, ran: ScheduleRun
    ) -> tuple[ConcreteTest, ScheduleRun, float, ScheduleRun | None]:
        """With the shortest delays that still make it fail, all in one proportion; and the run that just passes.

        That is None where it fails without any delay, once each node has let others run.
        """
        whole, just_passes = test.schedule, None
        passes, fails = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (passes + fails) / 2
            shorter = _scale(test, whole, middle)
            again = self._tries(shorter)
            if again is None:
                passes, just_passes = middle, self.last
            else:
                fails, test, ran = middle, shorter, again
        if just_passes is None and self._tries(_scale(test, whole, 0.0)) is None:
            just_passes = self.last
        return test, ran, sum(decision.delay_s for decision in test.schedule), just_passes


def _name_nodes(test: ConcreteTest, ran: ScheduleRun) -> ConcreteTest:
    """The test whose decisions say which node they held up, for readers."""
    nodes = {(held.kind, held.place): held.node for held in ran.held}
    schedule = (replace(entry, node=nodes.get((entry.kind, entry.place), "")) for entry in test.schedule)
    return replace(test, schedule=tuple(schedule))


def _scale(test: ConcreteTest, schedule: Sequence[ScheduleDecision], share: float) -> ConcreteTest:
    return replace(test, schedule=tuple(replace(entry, delay_s=entry.delay_s * share) for entry in schedule))


def is_other_order(before: ScheduleRun, ran: ScheduleRun) -> bool:
    """Whether two threads have changed places where two runs part: each executes there later what it did before.

    A delay that only misses a deadline leaves the order as it is, or lets a thread take another branch. One that lets
    two tasks of a loop change places is the least that does. Two messages may have changed places as well.
    """
    usual, other = ([(topic, 0) for topic in run.arrivals] for run in (before, ran))
    return _have_swapped(usual, other) or _have_swapped(unpack_steps(before.steps), unpack_steps(ran.steps))


def _have_swapped(usual: Sequence[tuple[object, int]], other: Sequence[tuple[object, int]]) -> bool:
    for place, ((thread, point), (first, at)) in enumerate(zip(usual, other, strict=False)):
        if (thread, point) != (first, at):
            return thread != first and _next(other[place:], thread) == point and _next(usual[place:], first) == at
    return False


def _next(steps: Sequence[tuple[object, int]], wanted: object) -> int | None:
    return next((point for thread, point in steps if thread == wanted), None)


def _delay(decision: ScheduleDecision, held: Sequence[HeldNode]) -> ScheduleDecision:
    """The same delay, which ends just before the other node runs."""
    if decision.kind == "delivery":
        return decision
    for_s = next((entry.for_s for entry in held if entry.place == decision.place), decision.delay_s)
    return replace(decision, kind="delay", delay_s=max(0.0, for_s - JUST_S))


def words(candidate: ScheduleCandidate, race: ScheduleRace) -> str:
    """`arm is held up before arm.py:32 for 0.013 s while watch executes guard.py:14, guard.py:15`."""
    parts = [*_moves(candidate.test, race.test)]
    for held in race.ran.held:
        if held.kind == "delivery":
            parts.append(f"{held.place} of {held.node} at {held.time_s:.6g} s arrives {held.for_s:.6g} s later")
            continue
        before = (
            f"between reading and writing in {held.place[:-1]}" if held.place.endswith("=") else f"before {held.place}"
        )
        between = dict.fromkeys(place.rstrip("=") for place, _ in held.between)
        others = ", ".join(dict.fromkeys(node for _, node in held.between))
        during = f" while {others} executes {list_names([*between])}" if between else ""
        parts.append(f"{held.node} waits {before} for {held.for_s:.6g} s{during}")
    parts += [wait for wait in race.ran.waits if wait not in candidate.usual.waits]
    orders = [decision for decision in race.test.schedule if decision.kind == "order"]
    parts += [f"at choice {entry.occurrence} number {entry.choice + 1} of what is ready goes first" for entry in orders]
    return "; ".join(parts)


def _moves(usual: ConcreteTest, test: ConcreteTest) -> Iterator[str]:
    """`pause_s of action 2, stop, is 1.25 instead of 1.5`."""
    for number, (action, before) in enumerate(zip(test.actions, usual.actions, strict=True), 1):
        for name, value in action.parameters.items():
            if value != (usually := before.parameters[name]):
                yield f"{name} of action {number}, {action.command}, is {value:.6g} instead of {usually:.6g}"
