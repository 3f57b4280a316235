"""`LogReport`: the report of checked logs, a suite with the same records, and so the same page, as one of tests.

`hricdv check` makes it. With `--against`, `Occurrences` compare what occurred in logs and in tests.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.metadata import version
from typing import Any

from msgspec.structs import replace

from pytest_hricdv._base.message import list_names
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.reachability import skip_exploration
from pytest_hricdv.execution.outcome import TestOutcome
from pytest_hricdv.extra.logs.feature import UNKNOWN
from pytest_hricdv.extra.logs.judging import JudgedRun
from pytest_hricdv.generate.suite import Suite
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.results.derivation import derive
from pytest_hricdv.results.model import ConcreteParameters, GateResult, Report, RerunOptions, TestResult
from pytest_hricdv.results.report_builder import GeneratedSuite, SessionInfo, declare_report
from pytest_hricdv.session.run_context import RunContext

SHOWN = 8
"""Maximum number of requirements, of bins and of actions that the terminal names."""


@dataclass(frozen=True)
class Occurrences:
    """What occurred in runs: requirements that were triggered, bins that were hit, and actions of people."""

    requirements: frozenset[str]
    bins: Mapping[str, frozenset[Bin]]
    actions: frozenset[str]

    @classmethod
    def of(cls, report: Report, requirements: Collection[str], actions: Collection[str] | None = None) -> Occurrences:
        """What occurred in the runs of a report.

        Args:
            report: the report of logs, or of tests.
            requirements: the requirements that are of interest.
            actions: actions of the runs; None: the lines of the tests.
        """
        runs = [run for test in report.tests for run in test.runs]
        return cls(
            frozenset(
                name
                for run in runs
                for name in requirements
                if name in run.requirements and run.requirements[name].triggers
            ),
            {
                name: frozenset(hit for run in runs for hit in (run.cross or {}).get(name, ()))
                for name in report.cross_products
            },
            frozenset(line for run in runs for line in run.abstract) if actions is None else frozenset(actions),
        )

    def without(self, other: Occurrences) -> Occurrences:
        """What did not occur in other runs."""
        bins = {name: hits - other.bins.get(name, frozenset()) for name, hits in self.bins.items()}
        return Occurrences(
            self.requirements - other.requirements,
            {name: hits for name, hits in bins.items() if hits},
            self.actions - other.actions,
        )

    @property
    def data(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "requirements": sorted(self.requirements, key=natural),
            "bins": {name: sorted(bins) for name, bins in self.bins.items()},
            "actions": sorted(self.actions, key=natural),
        }

    def lines(self, title: str) -> Iterator[str]:
        """For the terminal: a line for each kind."""
        data = self.data
        kinds = {"requirements": data["requirements"], "actions": data["actions"]}
        kinds |= {f"bins of {name}": [*map(" x ".join, bins)] for name, bins in data["bins"].items()}
        if not any(kinds.values()):
            yield f"  {title}: nothing"
        for kind, names in kinds.items():
            if names:
                yield f"  {title}: {len(names)} {kind}: {list_names(names, SHOWN)}"


SUITE = "logs"
NO_CODE = "logs do not show which code ran"


@dataclass
class LogReport:
    """Collects the runs of logs.

    Args:
        requirements: the requirements that logs are judged by.
    """

    context: RunContext
    requirements: Sequence[Requirement]
    tests: list[TestResult] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    commands: set[str] = field(default_factory=set)
    faults: list[str] = field(default_factory=list)

    def add(self, judged: JudgedRun) -> None:
        """Add a run."""
        self.commands |= judged.commands
        known, failed = (
            self.context.violation_exemptions,
            [v for v in judged.verdicts.values() if v.verdict == "Failed"],
        )
        new = [verdict.requirement for verdict in failed if verdict.requirement not in known or verdict.outside]
        outcome: TestOutcome = "failed" if new else "known-violation" if failed else "passed"
        name, end_s = judged.run.name, round(judged.run.end_s, 3)
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
            sim_s=end_s,
            skipped_s=0.0,
            fidelity="",
            end_reason="the log ends",
            outcomes=(),
            requirements={name: verdict.result for name, verdict in judged.verdicts.items()},
            code=None,
            timeline=None if judged.picture is None else judged.picture.timeline(judged.verdicts.values()),
            failure=f"violated: {', '.join(new)}" if new else "",
            unmeasured=NO_CODE,
            action_times_s=(),
            cross=self._cross(judged),
        )
        self.tests.append(UNKNOWN.put(test, judged.unknown))

    def _cross(self, judged: JudgedRun) -> dict[str, tuple[Bin, ...]]:
        """The bins of cross products, completed with the verdicts."""
        verdicts = {name: verdict.verdict for name, verdict in judged.verdicts.items()}
        bins = {}
        for name, found in judged.hits.items():
            product = self.context.collection.testbench.cross[name]
            hits = [tuple(hit[key] for key in product.coordinates if key in hit) for hit in map(dict, found)]
            checked = product.check(sorted(hits), verdicts)
            self.faults += [f"{judged.run.name}: {name}: {fault}" for fault in checked.faults]
            bins[name] = tuple(dict.fromkeys(checked.bins))
        return bins

    def make(self) -> Report:
        """The report. Its gates fail if no log checks a requirement that has to be checked."""
        options, testbench = self.context.options, self.context.collection.testbench
        session = SessionInfo(
            testbench=testbench,
            requirements=tuple(self.requirements),
            suites=(GeneratedSuite(Suite(SUITE, 0, ()), 0.0, cached=False),),
            code=CodeMap(tuple(testbench.code), (), "", nothing=NO_CODE),
            unmeasured="",
            known_violations={} if options.strict else options.known_violations,
            allowed_untriggered=options.gates.allowed_untriggered,
            until={},
            strict=options.strict,
            version=version("pytest-hricdv"),
            workers=1,
            rerun=RerunOptions(suite="", options=()),
            models={},
            reachability=skip_exploration(testbench.cross),
            sizes={SUITE: len(self.tests)},
        )
        report = derive(replace(declare_report(session, {}), tests=tuple(self.tests), problems=tuple(self.problems)))
        unchecked = [
            f"{name} was checked in no log"
            for name, tally in report.suites[0].requirements.items()
            if not (tally.passed or tally.failed or name in report.allowed_untriggered)
        ]
        return replace(report, gates=GateResult(failed=(*unchecked, *self.faults), improved=()))


def summary_lines(report: Report) -> Iterator[str]:
    """The table of requirements over all logs, and coverage of cross products, for the terminal."""
    words, (suite,) = ("Passed", "Failed", "NC", "unknown"), report.suites
    yield f"\n  {'':<8}{''.join(f'{word:>9}' for word in words)} triggers"
    for name, tally in suite.requirements.items():
        unknown = sum(name in UNKNOWN.of(test) and not test.violates(name) for test in report.tests)
        counts = (tally.passed, tally.failed, tally.nc - unknown, unknown, tally.triggers)
        yield f"  {name:<8}{''.join(f'{count:>9}' for count in counts)}"
    for name, product in suite.cross.products.items():
        if product.hits:
            yield f"  {name}: {product.hit} of {product.bins - product.impossible - product.illegal} bins in the logs"
