"""What counts as a false alarm, and what the page says of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from pytest_hricdv.monitor import Violation
from pytest_hricdv.report.files import write
from pytest_hricdv.results.model import GateResult, Report, TestResult
from studies import session
from studies.false_alarms import __main__ as false_alarms
from studies.false_alarms.alarms import RUN, SESSION, found_in
from tests.report import sample


def _report(**changes: Any) -> Report:
    """Three tests that pass, the first changed; R3 is known to fail."""
    report = sample.typed(sample.data(("rl",), 3))
    quiet = [_passed(test) for test in report.tests]
    tests = (replace(quiet[0], **changes), *quiet[1:])
    return replace(report, tests=tests, known_violations={"R3": "known"}, gates=None)


def _passed(test: TestResult) -> TestResult:
    verdicts = {name: replace(each, verdict="Passed", violations=()) for name, each in test.requirements.items()}
    return replace(test, outcome="passed", failure="", errors=(), requirements=verdicts)


def _violating(name: str, *, outside: bool = False) -> dict[str, Any]:
    """Changes of a test that violates a requirement."""
    verdicts = dict(_report().tests[0].requirements)
    violation = Violation(trigger_s=1.0, time_s=2.0, values={"x": 3.0}, margin=-7.0, outside=outside)
    verdicts[name] = replace(verdicts[name], verdict="Failed", violations=(violation,), margin=-7.0)
    return {"requirements": verdicts}


def alarms(report: Report) -> list[tuple[str, str]]:
    return [(alarm.oracle, alarm.where) for alarm in found_in("rl", 0, report).alarms]


def test_other_violations_faults_of_a_run_and_gates_are_alarms() -> None:
    name = _report().tests[0].id
    assert alarms(_report(outcome="failed", **_violating("R2"))) == [("R2", name)]
    assert alarms(_report(outcome="failed", **_violating("R3", outside=True))) == [("R3", name)]
    assert alarms(_report(outcome="failed", errors=("it hung", "it leaked"))) == [(RUN, name), (RUN, name)]
    assert alarms(_report(outcome="error", failure="Traceback\nValueError: x\n")) == [(RUN, name)]
    assert alarms(_report(outcome="not-run")) == [(RUN, name)]
    gates = GateResult(failed=("R5 was not checked",), improved=())
    assert alarms(replace(_report(), gates=gates)) == [(SESSION, "rl")]


def test_the_command_prints_figures_and_writes_only_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(folder: Path, arguments: list[str]) -> None:
        write(_report(), folder)

    monkeypatch.setattr(session, "run", run)
    command = ["x", "--suites=rl", "--seeds=0-1", f"--report={tmp_path / 'reports'}", f"--docs={tmp_path}"]
    monkeypatch.setattr("sys.argv", command)
    false_alarms.main()
    assert "**0 of 6 runs have a false alarm**" in capsys.readouterr().out
    assert not (tmp_path / "studies" / "false-alarms.md").exists()
    monkeypatch.setattr("sys.argv", [*command, "--again", "--write"])
    false_alarms.main()
    assert (tmp_path / "studies" / "false-alarms.md").read_text(encoding="utf-8").startswith("# Study: false alarms\n")
