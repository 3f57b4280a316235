"""The verification plan in a session."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.extra.verification_plan.records import PlanFeature
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext


class VerificationPlanFeature(Feature[Path]):
    """Says how far the goals of a verification plan are."""

    name = "verification_plan"
    options = (
        Value("plan", "FILE", "verification plan (TOML): report which of its goals are met, and what the others lack"),
    )

    def read(self, reader: OptionReader) -> Path | None:
        """The file of the plan."""
        return reader.file("plan")

    def check(self, context: RunContext) -> None:
        """Whether the plan can be read, and names what there is."""
        self._plan(context)

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """The plan, with how far it is."""
        if self.settings(session.options) is None:
            return report
        from pytest_hricdv.extra.verification_plan.evaluation import evaluated
        from pytest_hricdv.extra.verification_plan.records import PLAN

        return PLAN.put(report, evaluated(self._plan(session.context), report))

    def _plan(self, context: RunContext) -> tuple[PlanFeature, ...]:
        path = self.settings(context.options)
        if path is None:
            return ()
        from pytest_hricdv.extra.verification_plan.file import PlanError, Subjects, load_plan

        testbench = context.collection.testbench
        requirements = [requirement.id for requirement in context.requirements]
        try:
            return load_plan(path, Subjects(requirements, testbench.cross, testbench.model.covered))
        except PlanError as error:
            raise usage_error(f"--hri-plan: {error}") from None


FEATURE = VerificationPlanFeature()
