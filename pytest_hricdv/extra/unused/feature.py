"""What no run of a session used: fails a session in which nothing reached the code under test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pytest_hricdv.results.section import TestSection
from pytest_hricdv.session.feature import Feature, FeatureSession

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext

UNREACHED: TestSection[str] = TestSection("unreached", str, "")
"""Of a test in whose run nothing that people, sensors or the world did reached the code: four digits for each
simulated second, by when the code had waited until then."""

TEST_SECTIONS = (UNREACHED,)


class UnusedFeature(Feature[None]):
    """Looks at what all runs of a session have in common."""

    name = "unused"

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """See `Feature`."""
        return UNREACHED.put(result, run.unreached_waits) if run.unreached_waits else result

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """See `Feature`."""
        session.problems += complain_of_unreached_code(results)
        return results


FEATURE = UnusedFeature()


def complain_of_unreached_code(results: Sequence[TestResult]) -> Iterator[str]:
    """A sentence, where nothing reached the code in any run, though people did different things in them.

    In a run, the code has to wait at the same times and to execute the same as in each longer one, up to its end. Where
    it does not, something reached it on a way that cannot be observed, such as a variable of a module.
    """
    runs = [result for result in results if result.timeline is not None]
    differ = len({result.abstract for result in runs}) > 1 and any(result.action_times_s for result in runs)
    if not differ or not all(map(UNREACHED.of, runs)) or not _differs_by_length_only(runs):
        return
    yield (
        f"nothing that people, sensors or the world did reached the code under test in any of {len(runs)} runs: it "
        "received no message of theirs, nobody woke it, and it shares no object with them, so these tests say nothing "
        "about it. It may connect to a bus of its own: hand it run.bus.port(...), or what it reads, when the "
        "testbench's run creates it (docs/troubleshooting.md)"
    )


def _differs_by_length_only(runs: Sequence[TestResult]) -> bool:
    """Whether the code did the same in each run as in each one that is not shorter, up to its end."""
    covered, waits = 0, ""
    for result in sorted(runs, key=lambda result: result.sim_s):
        if not UNREACHED.of(result).startswith(waits):
            return False
        waits = UNREACHED.of(result)
        if result.code is None:
            continue
        statements, branches = result.code.bits
        bits = int(statements, 16) << 1_000_000 | int(branches or "0x0", 16)
        if covered & ~bits:
            return False
        covered = bits
    return True
