"""`UnusedFeature` finds what no run of a session used: code that nothing from outside reached, and unread parameters.

The first fails the session, since its tests say nothing about this code. The second is a warning. The facts come from
the `Influence` and `ParameterLog` of each run (`execution.influence`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pytest_hricdv.results.section import Section, TestSection
from pytest_hricdv.session.feature import Feature, FeatureSession

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

UNREACHED: TestSection[str] = TestSection("unreached", str, "")
"""If nothing from people, sensors or the world reached the code in the test's run: digests of its waits up to each
simulated second, of four digits each, to compare with other runs."""

UNREAD: TestSection[tuple[str, ...]] = TestSection("unread", tuple[str, ...], ())
"""Declared parameters of the run that nothing read in a test."""

NEVER_READ: Section[tuple[str, ...]] = Section("never_read", tuple[str, ...], ())
"""Declared parameters of the run that nothing read in any test of a complete session."""

SECTIONS, TEST_SECTIONS = (NEVER_READ,), (UNREACHED, UNREAD)


class UnusedFeature(Feature[None]):
    """Reports influences and parameters that no run of a session used."""

    name = "unused"

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """See `Feature`."""
        result = UNREACHED.put(result, run.unreached_waits) if run.unreached_waits else result
        return UNREAD.put(result, run.unread) if run.unread else result

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """See `Feature`."""
        session.problems += complain_of_unreached_code(results)
        session.warnings += [] if stopped else warn_of_unbegun_actions(results)
        return results

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """See `Feature`."""
        unread = [UNREAD.of(result) for result in report.tests if result.timeline is not None]
        if not (session.is_whole and unread and all(unread)):
            return report
        never = tuple(name for name in unread[0] if all(name in others for others in unread))
        session.warnings += [
            f"nothing read the parameter {name} in any of {len(unread)} runs, so its values test nothing: read "
            f'run.test.run["{name}"] in the testbench\'s run, or do not declare it'
            for name in never
        ]
        return NEVER_READ.put(report, never)


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


def warn_of_unbegun_actions(results: Sequence[TestResult]) -> Iterator[str]:
    """A sentence, where tests have actions and none began in any of several runs.

    A testbench may do them without `run.actions()`, so it is not a fault.
    """
    runs = [result for result in results if result.timeline is not None and result.abstract]
    if len(runs) > 1 and not any(result.action_times_s for result in runs):
        yield (
            f"no action began in any of {len(runs)} runs: unless the testbench's run does them without run.actions(), "
            "these tests are all the same, and say nothing about people"
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
