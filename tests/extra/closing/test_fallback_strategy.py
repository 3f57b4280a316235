"""Where no strategy knows a test: those that were not run yet, then those that do not do the same each time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.loop import Loop, OnlineTests
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.strategy import Archive
from pytest_hricdv.generate.abstract import AbstractTest
from tests.extra.closing import handover

POOL = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
NOTHING = (("bin", "nowhere", "0"),)


def observed(test: AbstractTest, record: str) -> RunObservation:
    """A run without a point."""
    return RunObservation(test.to_data(), record_sha256=record)


def loop(runs: int, record: str) -> tuple[Loop, list[tuple[str, ...]]]:
    """A loop of the fallback alone, for a point that nothing hits; and the lines of the tests that it runs."""
    ran: list[tuple[str, ...]] = []

    def runner(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterator[tuple[int, RunObservation]]:
        for number, test in enumerate(tests):
            ran.append(test.lines)
            yield number, observed(test, record.format(len(ran)))

    return Loop(Archive(NOTHING), (), runner, 1, Budget(runs), fallback=FallbackStrategy(POOL)), ran


def test_all_tests_are_run_once_before_any_is_run_again_and_all_as_often() -> None:
    size = len(POOL.tests)
    whole, ran = loop(3 * size, "record {}")
    assert whole.run() == "runs"
    assert set(ran[:size]) == {test.lines for test in POOL.tests}
    times = Counter(ran)
    assert max(times.values()) - min(times.values()) <= 2, "a generation is chosen at once"


def test_tests_that_do_the_same_each_time_are_run_twice_only() -> None:
    whole, ran = loop(10 * len(POOL.tests), "the same")
    assert whole.run() == "nothing to try"
    assert set(Counter(ran).values()) <= {2, 3}, "a generation is chosen at once"
