"""Prepares a session before its first test: suites, checks, header, journal; and checks gates before and after.

`plugin` registers the pytest plugin `Preparation` in the controlling process, and gives it and `SessionReporter` one
`GateCheck`: it checks the gates' names before the first test, and judges the report at the end.
"""

from __future__ import annotations

import importlib
from collections.abc import Set
from functools import cached_property
from pathlib import Path

import pytest
from msgspec import structs

from pytest_hricdv._base.project_files import hashes, short_hash, versions
from pytest_hricdv.report import files, terminal
from pytest_hricdv.results.baseline import (
    Baseline,
    BaselineError,
    baseline_of,
    check_suites,
    read_baseline,
    write_baseline,
)
from pytest_hricdv.results.behaviour_diff import compare_behaviour, compare_with_session_before
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.gate_check import check_gates
from pytest_hricdv.results.model import SCHEMA, GateResult, Report
from pytest_hricdv.session.aggregation import Aggregation
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.feature import features
from pytest_hricdv.session.option import feature_options, usage_error
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.pytest_options import runs_tests
from pytest_hricdv.session.replaying import Provenance
from pytest_hricdv.session.resuming import ResultRestorer
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.suites import export
from pytest_hricdv.session.testbench_search import import_engine


def fingerprint(collection: Collection, provenance: Provenance) -> dict[str, str]:
    """Everything that a session's results depend on: name -> value or hash; `--hri-resume` compares it.

    It includes all files of the project, since the files that a testbench loads are known only after all tests.
    """
    code = {name: text[:16] for name, text in provenance.code.items()}
    suites = {
        f"suite {generated.suite.name}": short_hash(generated.suite.to_json().encode())
        for generated in collection.suites
    }
    replays = {file.name: short_hash(file.replay.to_json().encode()) for file in collection.replays.values()}
    project = files_and_versions(collection.config.rootpath)
    form = {"report.json": SCHEMA}
    return {**_options(collection.options), **form, **suites, **replays, **project, **code, **provenance.environment}


def files_and_versions(root: Path) -> dict[str, str]:
    """The hashes of the sources below a folder, and the versions of the installed packages, by name."""
    return hashes(root) | versions()


def _options(options: Options) -> dict[str, str]:
    """The options that results depend on, except those that change a suite."""
    known_violations = (
        f"{name} when {exemption.condition}" if exemption.condition else name
        for name, exemption in options.known_violations.items()
    )
    return {
        "--hri-suite": options.suites,
        "--hri-seed": str(options.seed),
        "--hri-concretizations": str(options.concretizations),
        "--hri-sampling": options.sampling,
        "--hri-fidelity": options.fidelity,
        "--hri-shard": str(options.shard or ""),
        "--hri-no-cov": "" if options.coverage else "set",
        "--hri-strict": "set" if options.strict else "",
        "known violations": ", ".join(sorted(known_violations)),
        **{name: value for feature in feature_options() for name, value in feature.fingerprint(options).items()},
    }


_PYTEST_HEADER = ("cachedir: ", "rootdir: ", "configfile: ", "testpaths: ", "plugins: ", "xdist: ")


class Preparation:
    """Hooks that generate and export the suites, and check what a session needs, the quick checks first."""

    def __init__(
        self, collection: Collection, context: RunContext, gate_check: GateCheck, aggregation: Aggregation
    ) -> None:
        self.collection = collection
        self.aggregation = aggregation
        self.context = context
        self.options = collection.options
        self._gate_check = gate_check
        self._replaces_header = False

    def pytest_report_header(self) -> list[str]:
        """A line with the number of tests, which generates the suites; for replays, also what has changed since."""
        return [
            *(self._replay_header() if self.collection.replays else self._header()),
            *self.aggregation.journaling.notes,
        ]

    def _header(self) -> list[str]:
        names = [generated.suite.name for generated in self.collection.suites]
        tests = len(self.collection.cases)  # generates them too, so that its errors come first
        named = self.collection.config.args_source == pytest.Config.ArgsSource.ARGS
        return [
            terminal.header(names, self.options.seed, None if named else tests, self.collection.testbench.name),
            *(line for feature in features() for line in feature.header(self.context)),
        ]

    def _replay_header(self) -> list[str]:
        files = self.collection.replays.values()
        notes = [self.context.provenance.note(file) for file in files]
        return [terminal.replay_header(self.collection.testbench.name, len(files)), *(note for note in notes if note)]

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Check testbench, files and report folder before any test runs; export the suites."""
        self._gate_check.check({requirement.id for requirement in self.context.requirements})
        _ = self.context.exemption_conditions
        _ = self.context.code
        self._check_replays()
        for feature in features():
            feature.check(self.context)
        running = runs_tests(self.collection.config)
        if running:
            self._shorten_header()
            self._import_required()
        _ = self.collection.suites  # after the quick checks, because learning takes long
        self._gate_check.check_suites()
        if self.options.export is not None:
            export(self.collection.suites, self.options.export)
        if running:
            try:
                files.prepare(self.options.report)
            except ReportError as error:
                raise usage_error(str(error)) from None
            self._begin_journal()

    def _shorten_header(self) -> None:
        """Switch off pytest's own header unless `-v` is given; `_write_header` writes the lines of plugins."""
        if not self.collection.config.pluginmanager.hasplugin("terminalreporter"):
            return
        option = self.collection.config.option
        self._replaces_header = self.collection.config.get_verbosity() == 0 and not option.no_header
        option.no_header |= self._replaces_header

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self) -> None:
        """Write the header."""
        self._write_header()

    @pytest.hookimpl(tryfirst=True, optionalhook=True)
    def pytest_xdist_setupnodes(self) -> None:
        """Write the header before xdist begins its line of workers, which it completes later."""
        self._write_header()

    def _write_header(self) -> None:
        """Write the header lines of plugins, without pytest's own, once."""
        config = self.collection.config
        reporter = config.pluginmanager.get_plugin("terminalreporter")
        if reporter is None or not self._replaces_header:
            return
        self._replaces_header = False
        headers = config.hook.pytest_report_header(config=config, start_path=config.invocation_params.dir)
        for lines in reversed(headers):
            for line in [lines] if isinstance(lines, str) else lines:
                if not line.startswith(_PYTEST_HEADER):
                    reporter.write_line(line)

    def _begin_journal(self) -> None:
        journaling = self.aggregation.journaling
        depends_on = fingerprint(self.collection, self.context.provenance)
        journaling.begin(depends_on, resume=self.options.resume)
        if journaling.resumed is not None:
            self.aggregation.resume(journaling.resumed)
            self.collection.done = journaling.resumed.complete_ids
            manager = self.collection.config.pluginmanager
            manager.register(ResultRestorer(self.collection, journaling.resumed.results), "hricdv-restoring")

    def _check_replays(self) -> None:
        """Refuse replay files from other code or versions unless --hri-replay-force is given."""
        notes = [self.context.provenance.note(file) for file in self.collection.replays.values()]
        changed = [note for note in notes if note]
        if changed and not self.options.replay_force:
            lines = "\n  ".join(changed)
            raise usage_error(f"--hri-replay: {lines}\nadd --hri-replay-force to run it anyway")

    def _import_required(self) -> None:
        for name in self.collection.testbench.simulation.requires:
            try:
                importlib.import_module(name)
            except ImportError as error:
                raise usage_error(f"the testbench requires {name}: {error}") from None
        import_engine(self.collection.testbench)


class GateCheck:
    """Checks the gates of a session."""

    def __init__(self, collection: Collection) -> None:
        self.options = collection.options
        self._collection = collection

    def check(self, requirements: Set[str]) -> None:
        """Check exemptions and baseline before any test runs.

        Raises:
            pytest.UsageError: an exemption names no requirement, or the baseline cannot be read.
        """
        allowed = {"known violation of": {*self.options.known_violations, *self.options.gates.known_violations}}
        allowed["NC is allowed for"] = set(self.options.gates.allowed_untriggered)
        for use, names in allowed.items():
            for name in sorted(names):
                if name not in requirements:
                    existing = ", ".join(sorted(requirements))
                    raise usage_error(f"{use} {name!r}: no such requirement; there are {existing}")
        _ = self._baseline

    def check_suites(self) -> None:
        """Check that the baseline is from the generated suites; replayed tests may be of any suite.

        Raises:
            pytest.UsageError: the baseline has none of the suites, or one with another seed.
        """
        if self._baseline is None or self.options.update_baseline or self._collection.replays:
            return
        seeds = {generated.suite.name: generated.suite.seed for generated in self._collection.suites}
        try:
            check_suites(self._baseline, seeds, str(self.options.baseline), behaviour=self.options.gates.fail_on_change)
        except BaselineError as error:
            raise usage_error(f"--hri-baseline: {error}") from None

    def compare(self, report: Report, *, whole: bool) -> Report:
        """Add the changes of behaviour since the baseline to a report, unless the baseline is being updated.

        Without a baseline, tests are compared with the previous session, whose report is kept.

        Args:
            whole: whether all tests of the suites were selected.
        """
        if self.options.update_baseline:
            return report
        if self._baseline is None:
            before = files.read_superseded(self.options.report)
            changes = None if before is None else compare_with_session_before(report, before, whole=whole)
            return report if changes is None else structs.replace(report, changes=changes)
        return structs.replace(report, changes=compare_behaviour(report, self._baseline, whole=whole))

    @cached_property
    def _baseline(self) -> Baseline | None:
        path = self.options.baseline
        if path is None or (self.options.update_baseline and not path.exists()):
            return None
        try:
            return read_baseline(path, self._collection.testbench.name)
        except BaselineError as error:
            raise usage_error(f"--hri-baseline: {error}") from None

    def judge(self, report: Report, *, whole: bool) -> GateResult:
        """Check the report of a completed session against gates and baseline, or update the baseline.

        Args:
            whole: whether all tests of the suites were selected.
        """
        options = self.options
        if not options.update_baseline:
            return check_gates(report, options.gates, self._baseline, options.today, whole=whole)
        checked = check_gates(report, options.gates, None, options.today, whole=whole)
        problem = self._update(report, whole=whole)
        return structs.replace(checked, failed=(*checked.failed, problem)) if problem else checked

    def _update(self, report: Report, *, whole: bool) -> str:
        """Write the baseline. Returns why it was not written; empty if it was."""
        path = self.options.baseline
        assert path is not None, "read_options has checked it"
        if not whole or report.not_run:
            return f"{path} was not updated: only {report.reported} of its tests ran; run the whole suites"
        try:
            write_baseline(baseline_of(report, self._baseline), path)
        except BaselineError as error:
            return f"--hri-update-baseline: {error}"
        return ""
