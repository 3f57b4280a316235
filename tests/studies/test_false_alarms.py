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
from studies.false_alarms.tables import context
from studies.grid import cells
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


def test_runs_that_pass_and_violations_that_are_known_are_no_alarms() -> None:
    assert alarms(_report()) == []
    known = _report(outcome="known-violation", **_violating("R3"))
    assert alarms(known) == []
    judged = found_in("rl", 0, known).requirements["R3"]
    assert (judged.known_violations, judged.margin, judged.test) == (1, -7.0, known.tests[0].id)


def test_other_violations_faults_of_a_run_and_gates_are_alarms() -> None:
    name = _report().tests[0].id
    assert alarms(_report(outcome="failed", **_violating("R2"))) == [("R2", name)]
    assert alarms(_report(outcome="failed", **_violating("R3", outside=True))) == [("R3", name)]
    assert alarms(_report(outcome="failed", errors=("it hung", "it leaked"))) == [(RUN, name), (RUN, name)]
    assert alarms(_report(outcome="error", failure="Traceback\nValueError: x\n")) == [(RUN, name)]
    assert alarms(_report(outcome="not-run")) == [(RUN, name)]
    gates = GateResult(failed=("R5 was not checked",), improved=())
    assert alarms(replace(_report(), gates=gates)) == [(SESSION, "rl")]


def test_the_page_counts_runs_with_an_alarm_once_and_lists_alarms() -> None:
    bad = found_in("rl", 1, _report(outcome="failed", errors=("a | b", "c"), **_violating("R2")))
    made = context([found_in("rl", 0, _report()), bad])
    assert (made["runs"], made["alarmed"], made["seeds"]) == (6, 1, [0, 1])
    assert made["suites"].splitlines()[-1] == "| rl | 2 | 6 | 3 |"
    assert f"| the run | {bad.alarms[0].where} | 1 | a \\| b |" in made["alarms"].splitlines()
    (row,) = [line for line in made["requirements"].splitlines() if line.startswith("| R2 |")]
    assert row.endswith(f"| 0 | 1 | -7 in {bad.alarms[0].where} |")


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


def test_without_a_report_of_the_present_code_there_are_no_figures(tmp_path: Path) -> None:
    with pytest.raises(session.SessionError, match="no session is of the present code"):
        false_alarms.run(cells(("rl",), (0,)), tmp_path, again=True)
