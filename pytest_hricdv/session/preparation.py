"""Preparation: finds faults before the first test runs. Registered in the controlling process only."""

from __future__ import annotations

import importlib

import pytest

from pytest_hricdv.report import files, terminal
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.session import films
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.gate_check import GateCheck
from pytest_hricdv.session.running import Running
from pytest_hricdv.session.suites import export
from pytest_hricdv.testbench import TestbenchError


class Preparation:
    """Generates the suites, exports them, and checks all that a session needs, in the order of the time it takes."""

    def __init__(self, collection: Collection, running: Running, gate_check: GateCheck) -> None:
        self.collection = collection
        self.running = running
        self.options = collection.options
        self._gate_check = gate_check

    def pytest_report_header(self) -> str | list[str]:
        """One line with the number of tests, for which the suites are generated; for replays also what has changed."""
        if self.collection.replays:
            return self._replay_header()
        suites = self.collection.selected
        names = [each.suite.name for each in suites]
        tests = len(self.collection.cases)
        return terminal.header(names, self.options.seed, tests, self.collection.testbench.name)

    def _replay_header(self) -> list[str]:
        given = self.collection.replays.values()
        notes = [self.running.provenance.note(each) for each in given]
        return [terminal.replay_header(self.collection.testbench.name, len(given)), *(note for note in notes if note)]

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Checks testbench, files and report folder before any test runs; exports the suites."""
        self._gate_check.check({requirement.id for requirement in self.running.requirements})
        _ = self.running.code
        self._check_replays()
        if self.options.film:
            self._check_film()
        running = not self.collection.config.getoption("collectonly")
        if running:
            self._import_required()
        _ = self.collection.selected  # after the quick checks, because learning takes long
        if self.options.export is not None:
            export(self.collection.selected, self.options.export)
        if running:
            try:
                files.prepare(self.options.report)
            except ReportError as error:
                raise pytest.UsageError(str(error)) from None

    def _check_replays(self) -> None:
        """Refuse replay files of other code or versions, unless --hri-replay-anyway is given."""
        notes = [self.running.provenance.note(each) for each in self.collection.replays.values()]
        changed = [note for note in notes if note]
        if changed and not self.options.replay_anyway:
            told = "\n  ".join(changed)
            raise pytest.UsageError(f"--hri-replay: {told}\nadd --hri-replay-anyway to run it all the same")

    def _check_film(self) -> None:
        try:
            films.check(self.collection.testbench)
        except TestbenchError as error:
            raise pytest.UsageError(str(error)) from None

    def _import_required(self) -> None:
        for name in self.collection.testbench.requires:
            try:
                importlib.import_module(name)
            except ImportError as error:
                raise pytest.UsageError(f"the testbench requires {name}: {error}") from None
