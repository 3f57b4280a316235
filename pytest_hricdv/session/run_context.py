"""`RunContext`: how all runs of a process are judged, measured and recorded, from the options and the testbench.

`plugin` makes one per process from its `Collection`, and keeps it in `config.stash[CONTEXT]`. `TestRunner`, features
and the processes that run tests for them read it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import pytest

from pytest_hricdv._base.message import InputError
from pytest_hricdv.coverage.code_map import CodeMap, CoverageError, map_code
from pytest_hricdv.coverage.measurement import Measurement, NoMeasurement, choose
from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.coverage.source_files import CoverageSettings
from pytest_hricdv.execution.case import RunSettings, feature_criteria
from pytest_hricdv.execution.execution_feature import execution_features
from pytest_hricdv.monitor import (
    Criterion,
    FormulaSource,
    PastFormula,
    RequirementError,
    load_definitions,
    load_requirements,
    parse_condition,
)
from pytest_hricdv.results.model import RequirementText
from pytest_hricdv.results.report_builder import requirement_texts
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.following import IMPORTS
from pytest_hricdv.session.option import usage_error
from pytest_hricdv.session.replaying import Failures, Provenance
from pytest_hricdv.session.signals import Signals

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


class RunContext:
    """Builds each part of the context when it is first needed, and keeps it.

    Args:
        collection: the session's options, testbench and tests.
    """

    def __init__(self, collection: Collection) -> None:
        self.collection = collection
        self.options = collection.options
        self.stash = pytest.Stash()
        """Objects that optional features keep for this process."""
        self.signals = Signals()
        """Handles Ctrl-C and SIGTERM, in the controlling process only."""

    @cached_property
    def requirements(self) -> tuple[Criterion, ...]:
        """The criteria of runs: the testbench's requirements, and those of features such as the model as an oracle.

        Raises pytest.UsageError, located, when a text does not parse, or a correspondence names what does not exist.
        """
        testbench = self.collection.testbench
        try:
            requirements = load_requirements(testbench.requirements, testbench.vocabulary())
            criteria: tuple[Criterion, ...] = (*requirements, *feature_criteria(testbench))
        except (RequirementError, InputError, ValueError) as error:
            raise usage_error(str(error)) from None
        names = [criterion.id for criterion in criteria]
        for name in self.options.stop_at:
            if name not in names:
                raise usage_error(
                    f"--hri-break-on-violation={name}: no such requirement; there are: {', '.join(names)}"
                )
        return criteria

    @property
    def violation_exemptions(self) -> Mapping[str, str]:
        """Requirements with a known violation, with the reasons; none in a strict run."""
        exemptions = {} if self.options.strict else self.options.known_violations
        return {name: exemption.text for name, exemption in exemptions.items()}

    @cached_property
    def exemption_conditions(self) -> Mapping[str, PastFormula]:
        """Requirement -> condition under which its violation is known, where there is one; none in a strict run.

        Conditions may use the definitions of the requirements' file.

        Raises:
            pytest.UsageError: a condition that does not parse, or names what the testbench does not declare.
        """
        testbench, parsed = self.collection.testbench, {}
        try:
            vocabulary = load_definitions(testbench.requirements, testbench.vocabulary())
            for name, exemption in self.options.known_violations.items():
                if exemption.condition:
                    source = FormulaSource(exemption.condition, owner=f"known violation of {name}: condition")
                    parsed[name] = parse_condition(exemption.condition, vocabulary, source)
        except RequirementError as error:
            raise usage_error(str(error)) from None
        return {} if self.options.strict else parsed

    @property
    def texts(self) -> dict[str, RequirementText]:
        """Requirement -> its texts for people."""
        return requirement_texts(self.requirements)

    @cached_property
    def code(self) -> CodeMap:
        """The code under test and its waivers. Raises pytest.UsageError for missing code or a waiver without reason."""
        try:
            config = self.collection.config
            settings = CoverageSettings((Path.cwd(), config.rootpath), getattr(config.option, "cov_config", "") or "")
            code = map_code(self.collection.testbench.code, Path(config.rootpath), settings)
            return code.without_waivers() if self.options.no_waivers else code
        except CoverageError as error:
            raise usage_error(str(error)) from None

    @property
    def measurement(self) -> Measurement:
        """The measurement of the code under test; a debugger, which can attach at any time, disables it."""
        if not self.options.coverage:
            return NoMeasurement("switched off with --hri-no-cov")
        return NoMeasurement(self.debugger_reason) if self.debugger_reason else self._choice_of_measurement

    @property
    def debugger_reason(self) -> str:
        """The debugger that is attached to this process or was asked for, in words; empty if none."""
        return self._debugger_option() or debugger()

    def _debugger_option(self) -> str:
        if self.options.stop_at:
            return "--hri-break-on-violation was given: measuring would get in its way"
        namespace = self.collection.config.option
        asked = [name for name, use in (("--pdb", "usepdb"), ("--trace", "trace")) if getattr(namespace, use, False)]
        return f"{asked[0]} was given: measuring would get in its way" if asked else ""

    @cached_property
    def _choice_of_measurement(self) -> Measurement:
        by_test = getattr(self.collection.config.option, "cov_context", None) == "test"
        before = [
            name for feature in execution_features() for name in feature.before_imports(self.collection.testbench)
        ]
        imports = self.collection.config.stash.get(IMPORTS, None)
        return choose(self.code, contexts_by_test=by_test, before=tuple(before), imports=imports)

    @cached_property
    def provenance(self) -> Provenance:
        """The provenance of the runs of this process: what they depend on."""
        return Provenance.now(self.code, self.collection.testbench)

    @cached_property
    def failures(self) -> Failures:
        """Writes the replay files of failing tests."""
        return Failures(self.options.report, self.collection.config.invocation_params.dir)

    @cached_property
    def run_settings(self) -> RunSettings:
        """The settings of the session's runs, without measurement."""
        return RunSettings(self.collection.testbench, self.requirements, self.exemption_conditions)

    def show_nodeid(self, nodeid: str) -> str:
        """The node id relative to the folder where pytest was started."""
        config = self.collection.config
        path, colons, rest = nodeid.partition("::")
        return os.path.relpath(config.rootpath / path, config.invocation_params.dir) + colons + rest


CONTEXT = pytest.StashKey[RunContext]()
"""Key of the context in pytest's stash."""
