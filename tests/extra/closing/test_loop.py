"""The loop with a runner that needs no simulation: generations, order of merging, budget, interruption, errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from random import Random

import pytest

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.loop import (
    GENERATION,
    RECENT,
    Loop,
    LoopError,
    OnlineTests,
    hit_rate,
    share_tests,
)
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.extra.closing.suite import smallest_suite
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest, identify
from pytest_hricdv.generate.rng import make_rng, pick

COMMANDS = ("ask", "take", "wait", "leave")
WANTED = tuple(("said", one, two) for one in COMMANDS for two in COMMANDS)


class AnyTwo:
    """A strategy that proposes two commands at random, aimed at that pair."""

    def __init__(self, name: str = "any two") -> None:
        self.name = name

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        return [self._proposal((pick(rng, COMMANDS), pick(rng, COMMANDS))) for _ in range(count)]

    def _proposal(self, lines: tuple[str, str]) -> Proposal:
        return Proposal(AbstractDraft("two", (), lines), self.name, (("said", *lines),))


class Nothing:
    """A strategy that never knows a test."""

    name = "nothing"

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        return []


def observed(test: AbstractTest) -> RunObservation:
    """What a run yields: the pair that was said; the seed decides how long it takes."""
    return RunObservation(test.to_data(), points=(("said", *test.lines),), sim_s=1.0 + test.seed % 7)


def in_order(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
    """Runs tests one by one."""
    return ((number, observed(test)) for number, test in enumerate(tests))


def backwards(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
    """The last test first, as another number of processes might."""
    return reversed([*in_order(tests, online)])


def loop(wanted: Iterable[Point] = WANTED, runs: int = 400, seed: int = 0) -> Loop:
    """A loop with a strategy that needs luck."""
    return Loop(Archive(wanted), (Nothing(), AnyTwo()), in_order, seed, Budget(runs))


def test_it_ends_when_nothing_is_open() -> None:
    closing = loop()
    assert closing.run() == "closed"
    assert not closing.archive.open
    assert closing.budget.used < 400


def test_what_it_finds_depends_on_the_seed_and_not_on_the_order_in_which_runs_end() -> None:
    found = []
    for runner, seed in ((in_order, 0), (backwards, 0), (in_order, 1)):
        closing = loop(seed=seed)
        closing.runner = runner
        closing.run()
        found.append([entry.test for entry in closing.archive.entries])
    assert found[0] == found[1] != found[2]


def test_a_strategy_that_hits_gets_the_tests_of_one_that_does_so_no_more() -> None:
    archive, ask = Archive(WANTED), ("ask", "ask")
    run = [("early", ask)] * (RECENT + 1) + [("late", ("ask", "take")), ("late", ("ask", "wait"))]
    tests = identify("closure", 0, [AbstractDraft("two", (), lines) for _, lines in run])
    for (strategy, lines), test in zip(run, tests, strict=True):
        archive.add(observed(test), strategy, (("said", *lines),))
    assert archive.entries[0].new
    assert hit_rate(archive, "early", "said") == 0.5 / (RECENT + 1)
    assert hit_rate(archive, "late", "said") == 2.5 / 3
    assert hit_rate(archive, "late", "another kind") == 0.5 / 3
    assert share_tests(archive, ["early", "late"], 1000, make_rng("shares"))["early"] < 100


def test_the_budget_of_runs_is_kept_to_the_run() -> None:
    closing = loop((*WANTED, ("never",)), runs=2 * GENERATION + 3)
    assert closing.run() == "runs"
    assert len(closing.archive.entries) == closing.budget.used == 2 * GENERATION + 3


def test_seconds_end_it_between_two_generations() -> None:
    times = iter(range(100))
    closing = loop((("never",),))
    closing.budget = Budget(400, seconds=3, clock=lambda: float(next(times)))
    assert closing.run() == "seconds"
    assert len(closing.archive.entries) == 2 * GENERATION


def test_it_ends_when_no_way_knows_a_test() -> None:
    closing = loop()
    closing.strategies = (Nothing(),)
    assert closing.run() == "nothing to try"


def test_ctrl_c_keeps_what_was_reached() -> None:
    def interrupted(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
        yield from list(in_order(tests, online))[1:4]
        raise KeyboardInterrupt

    closing = loop()
    closing.runner = interrupted
    assert closing.run() == "interrupted"
    assert [entry.number for entry in closing.archive.entries] == [0, 1, 2]
    assert smallest_suite(closing.archive)


def test_a_way_that_fails_is_left_out_and_the_others_go_on() -> None:
    class Failing(AnyTwo):
        def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
            if len(archive.entries) >= GENERATION:
                return [super().propose(archive, count, rng)[:0][0]]
            return super().propose(archive, count, rng)

    closing = Loop(Archive(WANTED), (Failing("one"), AnyTwo("two")), in_order, 0, Budget(40))
    assert closing.run() in ("closed", "runs")
    (fault,) = closing.faults
    assert fault.startswith("the strategy 'one' failed, and is left out from there on: IndexError: ")
    assert "closing/test_loop.py:" in fault
    assert {entry.strategy for entry in closing.archive.entries[GENERATION:]} == {"two"}


def test_an_error_of_the_loop_itself_keeps_what_was_reached() -> None:
    def breaking(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
        if closing.archive.entries:
            raise ZeroDivisionError("nobody thought of this")
        yield from in_order(tests, online)

    closing = loop((("never",),))
    closing.runner = breaking
    assert closing.run() == "error"
    assert len(closing.archive.entries) == GENERATION
    assert smallest_suite(closing.archive)
    assert "ended by an error of its own: ZeroDivisionError: nobody thought of this" in closing.faults[0]


def test_what_cannot_run_anything_is_an_error() -> None:
    def broken(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
        raise ZeroDivisionError

    closing = loop()
    closing.runner = broken
    with pytest.raises(ZeroDivisionError):
        closing.run()


def test_where_every_run_errs_the_first_error_is_raised_and_where_some_do_it_goes_on() -> None:
    def failing(every: int) -> Loop:
        def run(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
            for number, test in enumerate(tests):
                broken = RunObservation(test.to_data(), error=f"KeyError: {number}")
                yield number, broken if number % every == 0 else observed(test)

        closing = loop()
        closing.runner = run
        return closing

    with pytest.raises(LoopError, match="KeyError: 0"):
        failing(every=1).run()
    assert failing(every=2).run() == "closed"


def test_what_given_tests_hit_needs_no_further_test() -> None:
    archive = Archive(WANTED)
    archive.add(RunObservation(AbstractTest("g", "other", "two", (), ("ask", "ask")).to_data(), (WANTED[0],)))
    closing = Loop(archive, (AnyTwo(),), in_order, 0, Budget(400))
    assert closing.run() == "closed"
    assert {entry.observation.points[0] for entry in smallest_suite(archive)} == set(WANTED[1:])
