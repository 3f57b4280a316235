"""Runs tests beside the suite: unmeasured, in the controlling process, after the last test of the session."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping
from dataclasses import dataclass, replace

from pytest_hricdv.case import CaseResult, HriCase, execute
from pytest_hricdv.coverage.measurement import NoMeasurement
from pytest_hricdv.generate.abstract import slug
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.results.building import build_result
from pytest_hricdv.search.replay import Origin
from pytest_hricdv.session.replaying import Failures, Provenance
from pytest_hricdv.testbench import Testbench

UNMEASURED = NoMeasurement("not a test of the suite")


@dataclass(frozen=True)
class Rerunning:
    """Runs tests that no suite has, and keeps the ones worth it as replay files.

    Args:
        testbench: of the session.
        requirements: of the testbench.
        provenance: what runs depend on in this process.
        failures: keeps files.
        seeds: suite -> the seed that it was generated from.
    """

    testbench: Testbench
    requirements: tuple[Requirement, ...]
    provenance: Provenance
    failures: Failures
    seeds: Mapping[str, int]

    def run(self, test: ConcreteTest) -> CaseResult | None:
        """Run a test; None where the run came to no end. What it prints goes nowhere."""
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                return execute(self.testbench, self.requirements, test, UNMEASURED, "rerun")
        except Exception:
            return None

    def keep(self, case: HriCase, result: CaseResult, nodeid: str, origin: Origin) -> tuple[HriCase, str | None]:
        """Keep a test made from `case` with its result; returns it, and the name of its replay file if it has one."""
        test = replace(
            case.abstract,
            id=result.test.id,
            target=f"{origin.requirement} {origin.how}",
            beliefs=(),
            plans={},
            lines=tuple(action.command for action in result.test.actions),
        )
        made = HriCase(case.suite, test, case.ranges, fixed=result.test)
        path, bracket, _ = nodeid.partition(f"[{case.abstract.id}")
        new_nodeid = f"{path}[{test.id}]" if bracket else nodeid
        built = build_result(made, new_nodeid, result, requirements=self.requirements)
        return made, self.failures.keep(self.provenance.replay(made, built, self.seeds[case.suite], origin))


def named(test: ConcreteTest, what: str) -> ConcreteTest:
    """The test with a new id, made from what it is and from its content, so that equal tests have equal ids."""
    actions = [[action.command, sorted(action.parameters.items())] for action in test.actions]
    content = digest("made", test.suite, test.seed, actions, sorted(test.run.items()))
    return replace(test, id=f"{slug(test.suite)}-{slug(what)}-{content[:8]}")
