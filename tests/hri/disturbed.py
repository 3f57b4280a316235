"""Runs with disturbances: tests whose lines may have chosen parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

from pytest_hricdv.coverage.code_map import CodeMap, map_code
from pytest_hricdv.coverage.measurement import Measurement, choose
from pytest_hricdv.execution.case import UNMEASURED, CaseResult, RunSettings, execute, feature_criteria
from pytest_hricdv.execution.judge import list_undeclared_violations
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize
from pytest_hricdv.monitor import Criterion
from tests.hri import bench

Line = str | tuple[str, Mapping[str, float]]
"""A command, or the name of a disturbance with its parameters."""

OWN_SIDE = {"rest_x_m": 0.78, "rest_y_m": 0.1, "rest_z_m": 0.46}
"""Where a waiting person's hand is in nobody's way."""


def concrete(lines: Sequence[Line], seed: int = 1, **run: float) -> ConcreteTest:
    """The test with these lines; nobody grips, no sensor is out, and the person's hand waits on its own side."""
    commands = [line if isinstance(line, str) else f"disturb {line[0]}" for line in lines]
    values: dict[int, Mapping[str, float]] = {0: {"outage_turn": 0.0} | run}
    for number, line in enumerate(lines, 1):
        if not isinstance(line, str):
            values[number] = {name: float(value) for name, value in line[1].items()}
        elif line == "tell leg":
            values[number] = {"voice_s": 4.0, **OWN_SIDE}
        elif line == "set_param pressure = 1":
            values[number] = {"pull_n": 8.0, "grip_s": 0.0}
    chosen = {number: each for number, each in values.items() if each}
    test = AbstractTest("disturbed", "tests", "a disturbance", (), tuple(commands), seed=seed, values=chosen)
    return concretize(test, bench.testbench().commands)


@cache
def criteria() -> tuple[Criterion, ...]:
    """All requirements, and the model."""
    return (*bench.requirements(), *feature_criteria(bench.testbench()))


def judged(test: ConcreteTest, measurement: Measurement = UNMEASURED) -> CaseResult:
    """Run one test, and judge it by requirements and model."""
    context = f"{test.id} {next(bench.RUNS)}"
    settings = RunSettings(bench.testbench(), criteria(), bench.known_when(), measurement)
    return execute(settings, test, context)


def unknown_violations(result: CaseResult) -> str:
    """The ids of the requirements that are violated, beyond what is known of them."""
    return " ".join(list_undeclared_violations(result, bench.known_when()))


@cache
def code() -> CodeMap:
    """The code under test."""
    return map_code(bench.testbench().code, bench.ROOT)


@cache
def measurement() -> Measurement:
    """One measurement for all runs in this process."""
    return choose(code(), contexts_by_test=False)


def executed(result: CaseResult) -> list[str]:
    """The statements that a measured run executed, as they stand in their files (first line, without comments)."""
    if result.code is None:
        return []
    covered = iter(bin(result.code.statements)[:1:-1].ljust(code().statements, "0"))
    found = []
    for file in code().files:
        text = file.text.splitlines()
        found += [text[line - 1].partition("  #")[0].strip() for line in file.statements if next(covered) == "1"]
    return found
