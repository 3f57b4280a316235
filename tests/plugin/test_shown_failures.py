"""Many failures in the terminal: causes first, an example in full, a line for each test."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from pytest_hricdv.session.terminal_summary import example_lines
from tests.plugin.project import A_WORKER, change, report

SUITE = ("--hri-suite=bright.txt", "--hri-strict")
TITLE = "24 tests fail for 1 cause"
SECTION = "human-robot interaction"


@pytest.fixture
def bright(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project, where 24 of 28 tests fail, and causes are looked for."""
    failing = ("enter hall\nset_lamp level = 100\n" + "enter hall\n" * number for number in range(24))
    passing = ("enter hall\n" * number for number in range(1, 5))
    (lamps.path / "bright.txt").write_text("\n".join([*failing, *passing]), encoding="utf-8")
    change(lamps.path, "pytest.ini", "hri_diagnose = 0\n", "")
    return lamps


def between(lines: list[str], first: str, last: str) -> list[str]:
    """The lines from the section with one title up to that with another."""
    start, end = (next(number for number, line in enumerate(lines) if f" {title} " in line) for title in (first, last))
    return lines[start + 1 : end]


TEXT = [
    "R3 failed at 108.8 s by 0.001252 m",
    "",
    "R3 Failed: The robot shall not close its hand when the human hand is too close",
    "  triggered at 108.8 s, violated at 108.8 s: hand_closing = True, hand_distance = 0.04875 m (margin -0.001252 m)",
    "  --> R3 is violated",
    '  pytest "tests/hri/test_table_assembly.py::test_table_assembly[by-hand-leg3-bored-291d1aac]" --hri-suite=by-hand',
]


@pytest.mark.parametrize("columns", [40, 60, 80])
def test_the_lines_of_an_example_fit_and_commands_are_whole(columns: int) -> None:
    lines = list(example_lines(TEXT, columns))
    assert [line.style for line in example_lines(TEXT, None)] == ["bad", "plain", "bad", "plain", "bad", "dim"]
    assert all(len(line.text) <= columns for line in lines if line.style != "dim")
    assert lines[-1].text == TEXT[-1]
    assert " ".join(" ".join(line.text.split()) for line in lines[:-2]).split() == " ".join(TEXT[:-2]).split()


@pytest.mark.slow
@pytest.mark.parametrize("columns", [60, 80, 120])
def test_a_suite_with_twenty_failures_of_one_cause_is_read_on_a_screen(
    bright: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.delenv("BUILD_NUMBER", raising=False)
    result = bright.runpytest_inprocess(*SUITE)
    result.assert_outcomes(failed=24, passed=4, deselected=1)
    assert len(result.outlines) <= 35
    causes = between(result.outlines, TITLE, SECTION)
    assert causes[0].startswith("cause 1 (")
    assert all(len(line) <= columns for line in causes if "--hri-replay" not in line)
    assert "what the human did around then" not in result.stdout.str()
    assert not any(line.startswith("FAILED test_lamps.py") for line in result.outlines)
    assert result.outlines[-2].startswith("FAILED  4 passed, 24 failed")
    assert "24 failed, 4 passed" in result.outlines[-1]


@pytest.mark.slow
def test_with_tb_line_and_rf_each_failure_has_one_line(bright: pytest.Pytester) -> None:
    result = bright.runpytest_inprocess(*SUITE, "--tb=line", "-rf")
    lines = between(result.outlines, "FAILURES", SECTION)
    assert len(lines) == 24
    assert all("R2 failed at " in line for line in lines)
    assert sum(line.startswith("FAILED test_lamps.py") for line in result.outlines) == 24


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), A_WORKER], ids=["plain", "worker"])
def test_services_and_junit_read_causes(
    bright: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
) -> None:
    monkeypatch.setenv("CI", "true")
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(bright.path / "summary.md"))
    monkeypatch.setenv("GITHUB_WORKSPACE", str(bright.path.parent))
    result = bright.runpytest_inprocess(*SUITE, "--junitxml=junit.xml", *options)
    summary = [line for line in result.outlines if line.startswith("FAILED test_lamps.py")]
    assert len(summary) == 24
    assert all(line.endswith("by 20 % (cause 1)") for line in summary)
    annotations = [line for line in result.outlines if line.startswith("::error")]
    (cause,) = report(bright.path)["causes"]
    assert not cause["locations"][0]["likely"]
    title = f"hri%3A cause 1 ({cause['id']})%3A"
    assert annotations[0].startswith(f"::error file={bright.path.name}/test_lamps.py,line=4,title={title}")
    assert len([line for line in annotations if "gate failed" not in line]) == 1
    assert "### 24 tests fail for 1 cause" in (bright.path / "summary.md").read_text(encoding="utf-8")
    root = ET.parse(bright.path / "junit.xml").getroot()
    failures = list(root.iter("failure"))
    assert len(failures) == 24
    assert all(failure.attrib["message"].endswith("by 20 % (cause 1)") for failure in failures)
    assert all((failure.text or "").startswith(failure.attrib["message"]) for failure in failures)
    assert len([entry for entry in root.iter("property") if entry.attrib["name"] == "hri.cause"]) == 24


def test_errors_of_the_code_keep_their_tracebacks(lamps: pytest.Pytester) -> None:
    error = "raise (ValueError if level == 100 else KeyError)(level)"
    change(lamps.path, "lamps/guide.py", "        lamp.set(level)\n", f"        {error}\n")
    text = lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-strict", "--hri-diagnose=0").stdout.str()
    assert text.count(">           raise (ValueError if level == 100 else KeyError)(level)") == 2
    assert "4 tests failed" in text
