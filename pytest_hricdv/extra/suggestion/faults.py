"""The seeded faults that rank suggestions: those of the part `mutation`, each with the tests that reach it."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping, Sequence

from pytest_hricdv.coverage.closure import PointIndex
from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.execution.case import HriCase
from pytest_hricdv.extra.suggestion.recordings import Fault
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.results.derivation import coverage_of
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.run_context import RunContext

TESTS = 4
"""A fault is tried on at most so many tests. Chosen: the first reaches its place with the least beside, the others
together reach the most; with four, two of which have to differ, a fault costs about three runs."""


def can_be_made() -> bool:
    """Whether the library is there that makes them."""
    return importlib.util.find_spec("mutmut") is not None


Trials = dict[Fault, list[tuple[ConcreteTest, str]]]
"""Fault -> the tests to try it on, each with the hash of its record without the fault."""


def trials(
    context: RunContext, results: Sequence[TestResult], chosen: Mapping[str, HriCase], most: int
) -> tuple[Trials, int]:
    """Faults with the tests to try them on, and how many faults no test reaches.

    Args:
        context: of the session.
        results: of the tests that may be used, which were measured.
        chosen: node id -> test.
        most: so many faults at most, drawn with the seed of the session.
    """
    from pytest_hricdv.extra.mutation.mutants import all_mutants, sample
    from pytest_hricdv.extra.mutation.mutating import Candidate, TrialOrder

    code, cross = context.code, context.collection.testbench.cross
    index = PointIndex(code.statements, code.branches, {name: product.forbidden for name, product in cross.items()})
    candidates = []
    for result in results:
        bits = Bits.of(result.code)
        if bits is not None:
            points = index.points(coverage_of(result).runs)
            candidates.append(Candidate(result.id, "", bits.statements, points, result.sim_s))
    order, paths = TrialOrder(candidates, TESTS), {file.name: str(file.path) for file in code.files}
    by_id = {result.id: (chosen[result.nodeid].concrete, result.record_sha256 or "") for result in results}
    made: Trials = {}
    unreached = 0
    for mutant in sample(all_mutants(code), context.options.seed, most):
        tests = [by_id[name] for name in order.tests(mutant.statement)]
        unreached += not tests
        if tests:
            change = f"{mutant.before.splitlines()[0]} -> {(mutant.after or 'nothing').splitlines()[0]}"
            place = f"{mutant.file}:{mutant.line} {mutant.operator}: {change}"
            made[Fault(mutant.id, paths[mutant.file], mutant.text, place)] = tests
    return made, unreached
