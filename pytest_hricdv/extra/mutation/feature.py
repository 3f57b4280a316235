"""Mutation testing in a session (`--hri-mutate`): `MutationFeature` has its options, and tries mutants after all tests.

`seed_faults` chooses seeded bugs for the feature `suggestion`.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from pytest_hricdv.extra.mutation.options import MutationOptions
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import Flag, OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.execution.faulty_import import SeededFault
    from pytest_hricdv.execution.hri_case import HriCase
    from pytest_hricdv.generate.concrete import ConcreteTest
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

KIND = "mutants"
"""The kind of `--hri-fail-under` for the percentage of mutants that the tests kill."""


class MutationFeature(Feature[MutationOptions]):
    """Seeds bugs in the code under test, one at a time, and runs tests to see which mutants they kill."""

    name = "mutation"
    kinds = (KIND,)
    switched_off = MappingProxyType({"hri_mutate": False})
    options = (
        Flag(
            "mutate",
            "after all tests, seed bugs in the code under test, one at a time, and run the tests that execute their "
            "statements, to see which of these mutants the tests kill",
        ),
        Value("mutate-tests", "N", "try a mutant on at most N tests of each suite, or on all (default 10)"),
        Value("mutate-faults", "N", "try only N of the mutants, drawn with the seed (default: all)"),
        Value("mutate-seconds", "S", "start no new mutant after S seconds (default: no limit)"),
        Flag("mutate-matrix", "try a mutant on more tests after one has killed it: which tests kill which mutants"),
    )

    def read(self, reader: OptionReader) -> MutationOptions:
        """Read the options. Raises pytest.UsageError for options that contradict each other."""
        text = reader.text("mutate_tests")
        if not (text.isascii() and text.isdigit()) and text not in ("", "all"):
            raise usage_error(f"{reader.setting('mutate_tests')}: expected a whole number, or all")
        options = MutationOptions(
            asked=reader.flag("mutate"),
            tests=None if text == "all" else reader.integer("mutate_tests", MutationOptions.tests, minimum=1),
            mutants=reader.integer("mutate_faults", None, minimum=1),
            seconds=reader.integer("mutate_seconds", None, minimum=1),
            matrix=reader.flag("mutate_matrix"),
        )
        if options.asked and reader.flag("no_cov"):
            raise usage_error("--hri-mutate and --hri-no-cov: which tests to try a mutant on is known from coverage")
        if options.asked and reader.command_line_value("shard") is not None:
            raise usage_error("--hri-mutate and --hri-shard: give one of them; mutants are tried on whole suites")
        lines = reader.config.getoption("hri_fail_under") or ()
        needed = [line for line in lines if line.partition("=")[0].strip() == KIND]
        if needed and not options.asked:
            raise usage_error(f"--hri-fail-under={needed[0]}: add --hri-mutate, or there are no mutants")
        return options

    def check(self, context: RunContext) -> None:
        """Check that this system can fork and has mutmut."""
        if not self.settings(context.options).asked:
            return
        if not hasattr(os, "fork"):
            raise usage_error("--hri-mutate: this system cannot fork processes; use Linux or macOS")
        if importlib.util.find_spec("mutmut") is None:
            raise usage_error("--hri-mutate needs mutmut: pip install pytest-hricdv[mutation]")

    def follow_up(self, context: RunContext) -> str:
        """The name of this work, if `--hri-mutate` is given."""
        return "mutation testing (--hri-mutate)" if self.settings(context.options).asked else ""

    def extend_report(self, session: FeatureSession, report: Report) -> Report:
        """Try the mutants, if `--hri-mutate` is given."""
        settings = self.settings(session.options)
        if session.interrupted or not settings.asked:
            return report
        from pytest_hricdv.extra.mutation.mutating import MutationError, MutationRun  # needs mutmut
        from pytest_hricdv.extra.mutation.records import MUTATION

        aggregation = session.aggregation
        processes = aggregation.workers if aggregation.is_distributed else os.cpu_count() or 1
        measured = {result.id for result in session.results if result.code is not None}
        mutating = MutationRun(
            session.context,
            settings,
            aggregation.chosen,
            processes,
            session.say,
            session.signals.let_through,
            [run for run in session.deciding_runs if run.test in measured],
        )
        try:
            result = mutating.mutate(session.results)
        except MutationError as error:
            session.problems.append(f"--hri-mutate: {error}")
            return report
        except KeyboardInterrupt:  # before the first mutant
            session.interrupted = True
            return report
        session.interrupted = result.end_reason == "interrupted"
        if result.end_reason == "lost":
            session.problems.append("--hri-mutate: not all mutants were tried: their process was lost")
        session.done.update(() if session.interrupted else [self.name])
        return MUTATION.put(report, result)


FEATURE = MutationFeature()


def seed_faults(
    context: RunContext, results: Sequence[TestResult], chosen: Mapping[str, HriCase], count: int, max_tests: int
) -> tuple[dict[SeededFault, list[tuple[ConcreteTest, str]]], int]:
    """Seed bugs for another feature; needs mutmut.

    Args:
        results: the results of tests whose coverage was measured.
        chosen: node id -> test.
        count: number of mutants, drawn with the seed of the session.
        max_tests: maximum number of tests for each.

    Returns:
        Mutant -> the tests that execute it, each with the hash of its record in the original code; and the number of
        mutants that no test executes.
    """
    from pytest_hricdv.execution.faulty_import import SeededFault
    from pytest_hricdv.extra.mutation.mutants import all_mutants, sample
    from pytest_hricdv.extra.mutation.mutating import TrialOrder, candidates_of

    order = TrialOrder([replace(test, suite="") for test in candidates_of(context, results)], max_tests)
    paths = {file.name: str(file.path) for file in context.code.files}
    tests = {result.id: (chosen[result.nodeid].concrete, result.record_sha256 or "") for result in results}
    trials: dict[SeededFault, list[tuple[ConcreteTest, str]]] = {}
    unreached = 0
    for mutant in sample(all_mutants(context.code), context.options.seed, count):
        names = order.tests(mutant.statement)
        unreached += not names
        if names:
            fault = SeededFault(mutant.id, paths[mutant.file], mutant.text)
            trials[fault] = [tests[name] for name in names]
    return trials, unreached
