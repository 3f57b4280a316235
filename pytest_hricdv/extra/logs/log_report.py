"""The report of checked logs: the same records, and so the same page, as of tests."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.metadata import version

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.reachability import skip_exploration
from pytest_hricdv.coverage.records import ReportedCode
from pytest_hricdv.execution.outcome import TestOutcome
from pytest_hricdv.extra.logs.feature import UNKNOWN
from pytest_hricdv.extra.logs.fleet import is_known
from pytest_hricdv.extra.logs.judging import JudgedRun
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.results.derivation import NO_CLOSURE, declare_suite, derive
from pytest_hricdv.results.generation import Diversity, GenerationResult, LastNewPlan
from pytest_hricdv.results.model import (
    SCHEMA,
    ConcreteParameters,
    GateResult,
    Report,
    RerunOptions,
    TestResult,
    Timeline,
)
from pytest_hricdv.results.report_builder import requirement_texts
from pytest_hricdv.session.run_context import RunContext

SUITE = "logs"
NO_CODE = "logs do not show which code ran"


@dataclass
class LogReport:
    """Collects the runs of logs for a report.

    Args:
        context: of the project.
        requirements: that logs are judged by.
    """

    context: RunContext
    requirements: Sequence[Requirement]
    tests: list[TestResult] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    def add(self, judged: JudgedRun, cross: Mapping[str, tuple[Bin, ...]]) -> None:
        """Add a run with its hits of cross products."""
        known, results = self.context.known_violations, {each.requirement: each.result for each in judged.verdicts}
        failed = [name for name, result in results.items() if result.verdict == "Failed"]
        new = [name for name in failed if not is_known(name, judged, known)]
        outcome: TestOutcome = "failed" if new else "known-violation" if failed else "passed"
        name = judged.run.name
        test = TestResult(
            nodeid=name,
            suite=SUITE,
            id=f"{re.sub(r'[^A-Za-z0-9_-]+', '-', name).strip('-')[:60]}-{sha256(name.encode()).hexdigest()[:8]}",
            target=name,
            name=name,
            beliefs=(),
            abstract=(),
            concrete=ConcreteParameters(actions=(), run={}),
            seed=0,
            plans={},
            outcome=outcome,
            wall_s=None,
            sim_s=round(judged.run.end_s, 3),
            skipped_s=0.0,
            fidelity="",
            end_reason="the log ends",
            outcomes=(),
            requirements=results,
            code=None,
            timeline=self._timeline(judged),
            failure=f"violated: {', '.join(new)}" if new else "",
            unmeasured=NO_CODE,
            action_times_s=(),
            cross=cross,
        )
        self.tests.append(
            UNKNOWN.put(test, {each.requirement: each.unknown for each in judged.verdicts if each.unknown})
        )

    def _timeline(self, judged: JudgedRun) -> Timeline:
        triggers = {
            each.requirement: " ".join(
                f"{trigger.begin_s:.3f}-{trigger.end_s:.3f}{_MARKS[trigger.outcome]}"
                for part in each.stretches
                for trigger in part.history[:MAX_DRAWN]
            )
            for each in judged.verdicts
        }
        return Timeline(
            end_s=round(judged.run.end_s, 3),
            messages=judged.picture.messages(),
            signals=judged.picture.signals(),
            triggers={name: text for name, text in triggers.items() if text},
        )

    def make(self, gates: Sequence[str]) -> Report:
        """The report; with what fails it besides violations."""
        context, testbench = self.context, self.context.collection.testbench
        code = ReportedCode(
            packages=testbench.code, sha256="", waivers=(), map=(), measured=False, reason=NO_CODE, files=()
        )
        report = Report(
            schema=SCHEMA,
            version=version("pytest-hricdv"),
            testbench=testbench.name,
            selected=0,
            reported=0,
            not_run=0,
            not_run_tests=(),
            wall_s=0.0,
            workers=1,
            known_violations=context.known_violations,
            known_when={name: str(condition) for name, condition in context.known_when.items()},
            known_until={},
            strict=context.options.strict,
            rerun_options=RerunOptions(suite="", options=()),
            requirements=requirement_texts(self.requirements),
            units=dict(testbench.units),
            state="",
            code_under_test=code,
            models={},
            cross_products=(products := skip_exploration(testbench.cross)).products,
            exploration=products.exploration,
            suites=(declare_suite(SUITE, 0, len(self.tests), _NOT_GENERATED, {}),),
            closure=NO_CLOSURE,
            tests=tuple(self.tests),
            gates=GateResult(failed=tuple(gates), improved=()),
            problems=tuple(self.problems),
        )
        return derive(report)


_MARKS = {"passed": "", "failed": "!", "pending": "?"}
MAX_DRAWN = 300
"""Triggers of a requirement in the picture of a run."""

_NOT_GENERATED = GenerationResult(
    wall_s=0.0,
    cached=False,
    bdi_runs=0,
    iterations=0,
    converged_at=None,
    q_delta=(),
    distinct_texts=0,
    reward="",
    diagnosis=Diversity(
        distinct_subsets=0,
        belief_entropy_bits=0.0,
        belief_entropy_most_bits=0.0,
        plans_executed={},
        last_new_plan=LastNewPlan(iteration=None, test=0),
    ),
    notes=(),
)
