"""ROS 2 in a session: what is to be known of the graph of a run comes into its result."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.session.feature import Feature

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext


class Ros2Feature(Feature[None]):
    """Has no options."""

    name = "ros2"

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """With the notes of the run."""
        if not run.notes:
            return result
        from pytest_hricdv.extra.ros2.records import NOTES

        return NOTES.put(result, run.notes)


FEATURE = Ros2Feature()
