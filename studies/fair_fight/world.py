"""Runs one concrete test of a code base without pytest, and raises what it violates: what a property test needs."""

from __future__ import annotations

import dataclasses
import importlib
import os
import sys
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import choose
from pytest_hricdv.execution.case import CaseResult, RunSettings, feature_criteria
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import load_requirements
from pytest_hricdv.session.testbench_search import on_installed_engine
from pytest_hricdv.testbench import Testbench
from studies.fair_fight import CODE_BASES, CodeBase, meter

KNOWN = "FIGHT_KNOWN"
"""Environment variable: kinds that are known already and raise nothing, separated by `|`."""

STALL_S = 600.0


@dataclass(frozen=True)
class World:
    """A testbench with its requirements and its measurement.

    Args:
        base: the code base.
        settings: of its runs.
    """

    base: CodeBase
    settings: RunSettings

    @classmethod
    def here(cls, name: str, *, measured: bool = True) -> World:
        """That of the code base in the current folder."""
        base = next(each for each in CODE_BASES if each.name == name)
        if sys.path[:1] != [os.getcwd()]:
            sys.path.insert(0, os.getcwd())
        testbench: Testbench = importlib.import_module("conftest").pytest_hricdv_testbench(None)
        testbench = testbench.choose(fidelity=base.fidelity) if base.fidelity else testbench
        testbench = on_installed_engine(testbench)
        # Tools that trace the world make it slow, which is no fault of the code.
        patient = dataclasses.replace(testbench.time, stall_timeout_s=STALL_S)
        testbench = dataclasses.replace(testbench, time=patient)
        requirements = load_requirements(testbench.requirements, testbench.vocabulary())
        settings = RunSettings(testbench, (*requirements, *feature_criteria(testbench)))
        if measured:
            code = map_code(testbench.code, Path.cwd())
            settings = settings.with_measurement(choose(code, contexts_by_test=False))
        return cls(base, settings)

    @property
    def testbench(self) -> Testbench:
        """The testbench."""
        return self.settings.testbench

    def run(self, test: ConcreteTest) -> CaseResult:
        """Run a test, in the journal."""
        return meter.execute(self.settings, test, "fight")

    def check(self, test: ConcreteTest) -> None:
        """Run a test. Raises an AssertionError whose class is new for each kind of violation, unless all are known."""
        known = os.environ.get(KNOWN, "").split("|")
        for kind in meter.kinds(self.run(test)):
            if kind not in known:
                raise type(f"Violated_{kind}", (AssertionError,), {})(kind)
