"""`CampaignPlan`: the tests of a campaign, its project, and the number of seeds of each test.

The command `run` makes it with `make_plan`, which lets `planning_process` collect the tests; `Store` keeps it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path

import msgspec

from pytest_hricdv._base.input_file import from_json
from pytest_hricdv._base.message import InputError
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.execution.separate_process import ProcessError, start_process
from pytest_hricdv.extra.campaign import planning_process
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import variant
from pytest_hricdv.results.model import Report, SuiteResult
from pytest_hricdv.session.run_process import RunRequest

FOLLOWS_TESTS = "it follows the last test of a session, and a campaign only runs tests"

_OPTION = re.compile(r"--hri-[a-z-]+")

RunKey = tuple[int, int]
"""Number of the abstract test, and of the concretization."""


class CampaignError(InputError):
    """A campaign cannot begin, or continue; the message says why, and what to do."""


class PlannedTest(msgspec.Struct, frozen=True):
    """An abstract test: its suite, the id of its pytest item, and all else as `AbstractTest.to_data` gives it."""

    suite: str
    nodeid: str
    data: dict[str, object]


class CampaignBasis(msgspec.Struct, frozen=True):
    """The tests and settings that pytest finds.

    Args:
        root: the folder that it was started in.
        tests: the tests, in the order of collection.
        project: its files, and those of the code under test, name -> hash.
        declared: the report before the first result.
        rootdir: the project's folder, relative to `root`.
        left_out: what follows the last test of a session, and no campaign.
    """

    arguments: tuple[str, ...]
    root: str
    tests: tuple[PlannedTest, ...]
    project: Mapping[str, str]
    versions: Mapping[str, str]
    declared: msgspec.Raw
    rootdir: str = "."
    left_out: tuple[str, ...] = ()


class CampaignPlan(msgspec.Struct, frozen=True, dict=True):
    """The plan of a campaign.

    Args:
        planned: tests and settings that pytest found. concretizations: number of concrete tests for each abstract one.
    """

    planned: CampaignBasis
    concretizations: int

    @property
    def runs(self) -> int:
        """The number of runs."""
        return len(self.planned.tests) * self.concretizations

    def run_keys(self) -> Iterator[RunKey]:
        """The keys of all runs: all tests with the first seed, then the next seed, so that early results are fair."""
        return ((test, k) for k in range(self.concretizations) for test in range(len(self.planned.tests)))

    @cached_property
    def tests(self) -> tuple[AbstractTest, ...]:
        """The abstract tests."""
        return tuple(AbstractTest.from_data(test.data) for test in self.planned.tests)

    def request(self, key: RunKey) -> RunRequest:
        """The request to run the item that pytest would run, with this key."""
        planned, first = self.planned.tests[key[0]], self.tests[key[0]]
        test = variant(first, key[1])
        # From the right: a folder may have the test's name.
        head, bracket, rest = planned.nodeid.rpartition(first.id)
        nodeid = f"{head}{test.id}{rest}" if bracket else planned.nodeid
        return RunRequest(key, planned.suite, self._seeds[planned.suite], nodeid, test.to_data())

    @cached_property
    def _seeds(self) -> dict[str, int]:
        return {suite.name: suite.seed for suite in self.initial_report.suites}

    def name(self, key: RunKey) -> str:
        """The id of a run's test."""
        return variant(self.tests[key[0]], key[1]).id

    @cached_property
    def initial_report(self) -> Report:
        """The report before the first result; how long generation took is left out, as it depends on pytest's cache."""
        report = from_json(bytes(self.planned.declared).decode(), Report)
        options = tuple(
            option for option in report.rerun_options.options if not option.startswith("--hri-concretizations")
        )
        options = (*options, f"--hri-concretizations={self.concretizations}")
        rerun = msgspec.structs.replace(report.rerun_options, options=options)
        return msgspec.structs.replace(report, rerun_options=rerun, suites=tuple(map(self._resize, report.suites)))

    def _resize(self, suite: SuiteResult) -> SuiteResult:
        tests = sum(test.suite == suite.name for test in self.planned.tests)
        generation = msgspec.structs.replace(suite.generation, wall_s=0.0, cached=False)
        return msgspec.structs.replace(suite, size=self.concretizations * tests, generation=generation)

    def to_json(self) -> bytes:
        """The plan in the form that the store keeps."""
        return msgspec.json.encode(self)

    @classmethod
    def from_json(cls, text: bytes) -> CampaignPlan:
        """The plan that `to_json` wrote. Raises msgspec.DecodeError."""
        return msgspec.json.decode(text, type=cls)

    def difference(self, now: CampaignPlan) -> str:
        """The differences from another plan, on one line; empty if one report may contain runs of both."""
        if self.planned.arguments != now.planned.arguments:
            return f"it is of 'pytest {' '.join(self.planned.arguments)}', not of '{' '.join(now.planned.arguments)}'"
        changed = differences(self.planned.project, now.planned.project)
        if changed:
            return changed
        if self.planned.tests != now.planned.tests:
            return f"its {len(self.planned.tests)} abstract tests are others than the {len(now.planned.tests)} of now"
        return ""


def make_plan(arguments: tuple[str, ...], concretizations: int, root: Path) -> CampaignPlan:
    """Let pytest collect the tests of a campaign.

    Args:
        arguments: the arguments of pytest: the suite, its seed and so on.
        concretizations: number of concrete tests for each abstract one.
        root: the project's folder.

    Raises:
        CampaignError: pytest refuses, or finds no test.
    """
    try:
        with start_process(planning_process.__name__, root) as process:
            process.send(planning_process.PlanningJob(arguments))
            (line,) = process.answer()
    except ProcessError as error:
        raise CampaignError(f"the tests cannot be planned: {error}") from None
    planned = msgspec.json.decode(line, type=CampaignBasis)
    if not planned.tests:
        raise CampaignError(f"{' '.join(arguments)}: no tests: there is nothing to run")
    options = {argument.partition("=")[0] for argument in arguments}
    if refused := sorted(options & {*_OPTION.findall(" ".join(planned.left_out))}):
        raise CampaignError(f"{', '.join(refused)}: {FOLLOWS_TESTS}; give it to pytest instead, with fewer seeds")
    return CampaignPlan(planned, concretizations)
