"""A run is a function of its concrete test and the code: alone, after others, in another process, on two workers."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import Measurement, choose
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.results.codec import encode
from tests.hri import bench
from tests.hri.user import HOST, pytest_run

RELEASED_AND_DISCARDED = bench.concrete([*bench.leg("111"), *bench.leg("011")], seed=7)
BORED = bench.concrete(["tell leg", "receivesignal", "bored", *bench.leg("101")], seed=8)
SILENT = ["tell leg", "receivesignal"]


@dataclass(frozen=True)
class Facts:
    """What equal runs have in common."""

    sha256: str
    verdicts: str
    statements: int
    branches: int | None
    legs: tuple[str, ...]
    sim_s: float


@cache
def measurement() -> Measurement:
    """One measurement for all runs in this process, as in a session of the plugin."""
    return choose(map_code(bench.testbench().code, bench.ROOT), contexts_by_test=False)


def facts(test: ConcreteTest) -> Facts:
    """Run a test, measured where that is possible."""
    result = bench.run(test, measurement())
    statements, branches = (0, None) if result.code is None else (result.code.statements, result.code.branches)
    return Facts(
        result.record.sha256,
        json.dumps([encode(verdict.result) for verdict in result.verdicts]),
        statements,
        branches,
        result.outcome.outcomes,
        result.sim_s,
    )


PRINT_FACTS = """
import json, sys
from dataclasses import astuple
from pytest_hricdv.generate.concrete import ConcreteTest
from tests.hri.test_determinism import facts
print(json.dumps(astuple(facts(ConcreteTest.from_json(sys.stdin.read())))))
"""


@pytest.mark.slow
def test_a_run_is_the_same_alone_after_another_one_and_in_a_fresh_process() -> None:
    alone = facts(RELEASED_AND_DISCARDED)
    other = facts(BORED)
    assert other.sha256 != alone.sha256
    assert facts(RELEASED_AND_DISCARDED) == alone
    assert facts(BORED) == other
    done = subprocess.run(
        [sys.executable, "-c", PRINT_FACTS],
        input=RELEASED_AND_DISCARDED.to_json(),
        cwd=bench.ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    sha256, verdicts, statements, branches, legs, sim_s = json.loads(done.stdout)
    assert (sha256, verdicts, tuple(legs), sim_s) == (alone.sha256, alone.verdicts, alone.legs, alone.sim_s)
    if alone.statements:  # unmeasured under a debugger
        assert (statements, branches) == (alone.statements, alone.branches)


def test_another_seed_gives_another_run_of_the_same_commands() -> None:
    records = {bench.run(bench.concrete(bench.leg(), seed=seed)).record.sha256 for seed in (1, 2, 3)}
    assert len(records) == 3


@pytest.mark.slow
def test_results_are_equal_without_workers_on_two_workers_and_for_a_single_test(tmp_path: Path) -> None:
    suite = tmp_path / "three.txt"
    suite.write_text("\n\n".join("\n".join(lines) for lines in (bench.leg("111"), bench.leg("011"), SILENT)))
    selected = (HOST, f"--hri-suite={suite}")
    plain = pytest_run(tmp_path, *selected)
    assert [test["outcome"] for test in plain.tests.values()] == ["passed"] * 3, plain.output
    on_two = pytest_run(tmp_path, *selected, "-n", "2")
    assert on_two.tests == plain.tests, on_two.output
    name = list(plain.tests)[1]
    alone = pytest_run(tmp_path, name, f"--hri-suite={suite}")
    assert alone.tests == {name: plain.tests[name]}
