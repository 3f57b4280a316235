"""`RaceExamination`: shortens the schedule under which a test fails, and tells a wrong order from a mere delay.

`RaceHunt` makes one for each failing schedule; it returns a `ScheduleRace`, which `words` describes in a sentence.
"""

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
"""How much shorter than a hold (s) a delay must be to change no order: the resolution of virtual time."""

HALVINGS = 12
"""Bisections of a delay, which find it to 1/4096 of its length."""

RaceKind = Literal["wrong-order", "late"]


@dataclass(frozen=True)
class ScheduleRace:
    """A schedule under which a test fails.

    Args:
        test: the test with a minimal schedule.
        kind: `wrong-order` if it fails because of the order of two threads or tasks, `late` if a delay suffices that
            changes no order.
        least_s: the shortest delay with which it fails (s); for `wrong-order`, the sum of the holds or delays.
        runs: number of runs that this took.
    """

    test: ConcreteTest
    ran: ScheduleRun
    kind: RaceKind
    least_s: float
    runs: int


@dataclass
class RaceExamination:
    """Removes decisions while the test still fails, and tells a wrong order from a delay.

    Args:
        fails: whether a run fails in the same way.
        is_moved: whether a parameter of the test was changed, so that it may fail without any decision.
    """

    run: RunTest
    fails: Callable[[ScheduleRun], bool]
    is_moved: bool
    runs: int = 0
    last: ScheduleRun | None = None

    def examine(self, test: ConcreteTest, ran: ScheduleRun) -> ScheduleRace:
        """The minimal schedule under which a test fails, and its kind."""
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
        """The test without unneeded decisions; the last ones are tried first."""
        place = len(test.schedule) - 1
        while place >= 0 and (len(test.schedule) > 1 or self.is_moved):
            fewer = replace(test, schedule=(*test.schedule[:place], *test.schedule[place + 1 :]))
            if (shorter := self._tries(fewer)) is not None:
                test, ran = fewer, shorter
            place -= 1
        return test, ran

    def _late(self, test: ConcreteTest, ran: ScheduleRun) -> tuple[ConcreteTest, ScheduleRun] | None:
        """The test with delays just too short to change the order, and its run, if it still fails; else None."""
        if any(decision.kind == "order" for decision in test.schedule) or all(
            held.for_s <= JUST_S for held in ran.held
        ):
            return None  # without a delay there is only an order
        delays = tuple(_delay(decision, ran.held) for decision in test.schedule)
        delayed = replace(test, schedule=delays)
        again = self._tries(delayed)
        return None if again is None else (delayed, again)

    def _shortest(
        self, test: ConcreteTest, ran: ScheduleRun
    ) -> tuple[ConcreteTest, ScheduleRun, float, ScheduleRun | None]:
        """The shortest delays, all scaled alike, with which the test still fails; and the run that just passes.

        The latter is None if the test fails even with delays of 0 s, at which each node lets the others run once.
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
    """The test, with the names of the nodes that its decisions held up, for readers."""
    nodes = {(held.kind, held.place): held.node for held in ran.held}
    schedule = (replace(entry, node=nodes.get((entry.kind, entry.place), "")) for entry in test.schedule)
    return replace(test, schedule=tuple(schedule))


def _scale(test: ConcreteTest, schedule: Sequence[ScheduleDecision], share: float) -> ConcreteTest:
    return replace(test, schedule=tuple(replace(entry, delay_s=entry.delay_s * share) for entry in schedule))


def is_other_order(before: ScheduleRun, ran: ScheduleRun) -> bool:
    """Whether two threads or messages are swapped where two runs diverge: each executes later what it did before.

    A delay that only misses a deadline keeps the order, or lets a thread take another branch.
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
    """The decision as a delay that ends just before the other node runs."""
    if decision.kind == "delivery":
        return decision
    for_s = next((entry.for_s for entry in held if entry.place == decision.place), decision.delay_s)
    return replace(decision, kind="delay", delay_s=max(0.0, for_s - JUST_S))


def words(candidate: ScheduleCandidate, race: ScheduleRace) -> str:
    """`arm waits before arm.py:32 for 0.013 s while watch executes guard.py:14, guard.py:15`."""
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
