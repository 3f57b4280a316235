"""Runs of the table assembly for tests: the real testbench, controller and world, without pytest around them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path

import conftest
from pytest_hricdv.coverage.measurement import Measurement
from pytest_hricdv.execution.case import UNMEASURED, CaseResult, RunSettings, execute
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import METHODS
from pytest_hricdv.monitor import PastFormula, Requirement, load_requirements, parse_condition
from pytest_hricdv.monitor.verdict import Violation
from pytest_hricdv.results.gates import KNOWN, parse_exemptions
from pytest_hricdv.testbench import Testbench

ROOT = Path(conftest.__file__).parent
RUNS = count(1)
"""Numbers the runs of this process: each has its own share of a measurement."""

LONGEST_S = conftest.LIMIT_S + 10.0 + 10.0
"""Limit of a run, a deadline that is open then, and one more that a reading in that time opens."""


@cache
def testbench() -> Testbench:
    """The testbench of this repository's conftest."""
    return conftest.pytest_hricdv_testbench(None)  # type: ignore[arg-type]


@cache
def requirements() -> tuple[Requirement, ...]:
    """The requirements of the table."""
    return load_requirements(testbench().requirements, testbench().vocabulary())


def leg(pose: str = "111") -> list[str]:
    """The commands of a person who asks for one leg; `pose` as in the beliefs: gaze, pressure, location."""
    gaze, pressure, location = tuple(pose)
    return [
        "tell leg",
        "receivesignal",
        f"set_param location = {location}",
        f"set_param pressure = {pressure}",
        f"set_param gaze = {gaze}",
        "tell humanReady",
    ]


def concrete(lines: Sequence[str], seed: int = 1, **forced: float) -> ConcreteTest:
    """A concrete test of these commands; `forced` parameters have the given value in each command that has them.

    Nobody grips the robot's fingers, and no sensor is out, unless forced.
    """
    test = concretize(AbstractTest("test", "tests", "a test", (), tuple(lines), seed=seed), testbench().commands)
    return forcing(test, {"grip_s": 0.0, "outage_turn": 0.0} | forced)


def forcing(test: ConcreteTest, forced: Mapping[str, float]) -> ConcreteTest:
    """The test with other values of some parameters."""

    def changed(parameters: Mapping[str, float]) -> dict[str, float]:
        return {name: forced.get(name, value) for name, value in parameters.items()}

    actions = tuple(replace(action, parameters=changed(action.parameters)) for action in test.actions)
    return replace(test, actions=actions, run=changed(test.run))


@cache
def known_when() -> dict[str, PastFormula]:
    """Requirement -> condition under which its violation is known, of this repository's ini file."""
    ini = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["pytest"]["ini_options"]
    known = parse_exemptions(ini["hri_known_violations"], KNOWN)
    return {name: parse_condition(each.condition, testbench().vocabulary()) for name, each in known.items()}


def run(test: ConcreteTest, measurement: Measurement = UNMEASURED, engine: str = "") -> CaseResult:
    """Run one test, as the plugin does; on the first physics engine that is installed if none is named."""
    context = f"{test.id} {next(RUNS)}"
    table = testbench().choose(engine=engine)
    return execute(RunSettings(table, requirements(), known_when(), measurement), test, context)


def suite(name: str, seed: int = 0) -> Iterator[ConcreteTest]:
    """The concrete tests of a method's suite."""
    bench = testbench()
    context = GenerationContext(
        model=bench.model,
        space=bench.beliefs,
        commands=tuple(bench.concretization.commands),
        seed=seed,
        by_hand=bench.suites.by_hand,
    )
    for test in METHODS[name].generate(context).tests:
        yield concretize(test, bench.concretization)


def number(violation: Violation, name: str) -> float:
    """The value that a violation shows of a number."""
    value = violation.values[name]
    assert not isinstance(value, str)
    return value


def times(result: CaseResult, topic: str, **fields: object) -> list[float]:
    """When messages of a topic with these fields came."""
    return [
        message.time_s
        for message in result.record.messages
        if message.topic == topic and fields.items() <= dict(message.fields).items()
    ]
