"""What a run prints: complete, true to the report, and never wider than the terminal."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.report.formatting import Line, width, wrap_line
from pytest_hricdv.report.terminal import summary
from tests.report import sample, sample_sections

WHERE = Path("hri-report")


def _lines(data: dict[str, Any], columns: int = 80) -> tuple[Line, ...]:
    return summary(sample.typed(data), WHERE, columns)


def _text(data: dict[str, Any], columns: int = 80) -> str:
    return "\n".join(line.text for line in _lines(data, columns))


def _line(data: dict[str, Any], start: str) -> Line:
    return next(line for line in _lines(data, 100) if line.text.strip().startswith(start))


def test_summary_shows_verdicts_coverage_learning_and_time() -> None:
    report = sample.data(tests=134)
    counts = report["suites"][0]["requirements"]["R2"]
    row = _line(report, "R2")
    assert row.text.split()[-5:-1] == [str(counts[key]) for key in ("passed", "failed", "nc", "triggers")]
    assert row.style == "plain"
    assert "suite rl, seed 0: 134 tests" in _text(report)
    assert "of 320 reachable, 1 waived" in _line(report, "statements").text
    assert "95.8 % (46 of 48)" in _line(report, "plans of human").text
    assert "71.4 % (20 of 28 bins), 4 impossible" in _line(report, "cross product").text
    learned = _text(report).split("Q-learning")[1].replace("\n", " ")
    told = "converged after 130 of 130 iterations (812 model runs, 97 distinct tests), 3.10 s"
    assert told in " ".join(learned.split())
    assert "134/134 tests reported" in _text(report)
    assert "with 2 workers" in _line(report, "simulated").text
    assert "times real time" in _line(report, "simulated").text
    assert _lines(report)[-1].text == f"FAILED  117 passed, 3 failed, 14 known to fail    {WHERE / 'index.html'}"


def test_known_violations_are_marked_with_their_reason_and_others_are_bad() -> None:
    report = sample.data(tests=134)
    assert " known" in _line(report, "requirement").text
    assert _line(report, "R3").style == "warn"
    assert _line(report, "R3 is known to fail").text.endswith("no crush prevention")
    report["strict"] = True
    assert " known" not in _line(report, "requirement").text
    assert _line(report, "R3").style == "bad"


def test_requirements_of_a_group_stand_below_its_name_and_those_of_none_come_first() -> None:
    report = sample.data(tests=20)
    rows = [
        line.text.split()[0] for line in _lines(report) if line.text.startswith("  R") and "known to" not in line.text
    ]
    assert rows == ["R1", "R2", "R3", "R4"]
    for name, group in (("R1", "speed"), ("R2", "paper"), ("R4", "speed")):
        report["requirements"][name]["group"] = group
    shown = [line.text.split()[0] for line in _lines(report)[2:8]]
    assert shown == ["R3", "speed", "R1", "R4", "paper", "R2"]


def test_what_is_not_covered_is_listed_without_the_waived() -> None:
    assert _line(sample.data(), "controller/journal.py").text.split(maxsplit=1)[1] == "61, 70"
    lines = _lines(sample.data(), 100)
    (above,) = [number for number, line in enumerate(lines) if line.text.strip().startswith("controller/journal.py")]
    assert lines[above + 1].text.strip() == "branches 69->exit"


@pytest.mark.parametrize("columns", [60, 80])
def test_names_that_tell_rows_apart_are_whole(columns: int) -> None:
    report = sample.data(tests=3)
    names = [f"the_hand_over_is_refused_while_a_person_{number}" for number in ("waits", "walks")]
    (suite, *_) = report["suites"]
    for name in names:
        report["requirements"][name] = report["requirements"]["R1"]
        suite["requirements"][name] = suite["requirements"]["R1"]
    suite["plans"] = {f"assistant_of_the_person_{name}": suite["plans"]["human"] for name in ("left", "right")}
    test = "tests/hri/test_table_assembly.py::test_table_assembly[by-hand-leg1-not_bored-089d384f]"
    report.update(not_run_tests=[test], selected=4, not_run=1)
    lines = [line.text for line in _lines(report, columns) if not line.text.endswith("index.html")]
    assert all(width(line) <= columns for line in lines)
    for name in (*names, "plans of assistant_of_the_person_left", "plans of assistant_of_the_person_right"):
        assert any(line.strip().startswith(name) for line in lines), name
    assert any(line.endswith("089d384f]") for line in lines)


def test_a_sentence_goes_on_below_itself_and_a_title_that_would_say_nothing_is_left_out() -> None:
    report = sample.data(tests=3) | {"closing": sample_sections.CLOSING}
    lines = [line.text for line in _lines(report, 50) if not line.text.endswith("index.html")]
    assert not [line for line in lines if line.endswith("...")]
    assert [line.split()[:2] for line in lines if line.startswith("  R1 ")] == [["R1", "0"]]
    sentence = "  open: it was never aimed at, not by any run"
    assert wrap_line(sentence, 30) == ["  open: it was never aimed", "    at, not by any run"]
    assert wrap_line("short", 30) == ["short"]


def test_a_failed_session_is_about_what_failed() -> None:
    report = sample.data(tests=3)
    (suite, *_) = report["suites"]
    for number in range(10, 30):
        report["requirements"][f"R{number}"] = report["requirements"]["R1"]
        suite["requirements"][f"R{number}"] = suite["requirements"]["R1"] | {"passed": 3, "failed": 0, "nc": 0}
    suite["requirements"]["R2"] |= {"failed": 1}
    lines = [line.text for line in summary(sample.typed(report), WHERE, 80, brief=True)]
    rows = [line.split()[0] for line in lines if line.startswith("  R") and "known" not in line.split()]
    assert "R2" in rows
    assert not {f"R{number}" for number in range(10, 30)} & {*rows}
    assert lines[0].startswith("requirements  22 of 24 passed")
    assert len(lines) <= 15
    assert "R10" in _text(report)


def test_messages_that_hide_behind_another_one_are_said_in_a_few_lines_too() -> None:
    report = sample.data(tests=20)
    report["suites"][0]["requirements"]["R2"]["masked_messages"] = {"state": 3}
    lines = [line.text for line in summary(sample.typed(report), WHERE, 80, brief=True)]
    assert "  R2 ignored 3 'state' messages: only the last of an instant counts" in lines


def test_nothing_of_a_name_can_colour_the_terminal() -> None:
    report = sample.data(tests=1)
    report["suites"][0]["plans"] = {"\x1b[31mred\u202e": report["suites"][0]["plans"].popitem()[1]}
    assert "\\x1b[31mred\\u202e" in _text(report)


NAMES = st.text(st.characters(exclude_categories=[]), max_size=60)


@given(
    name=NAMES,
    file=NAMES,
    reason=NAMES,
    number=st.integers(0, 10**7),
    wall_s=st.floats(0, 1e7),
    lines=st.lists(st.integers(1, 5000), max_size=80),
    columns=st.integers(20, 140),
)
def test_every_line_fits(
    name: str, file: str, reason: str, number: int, wall_s: float, lines: list[int], columns: int
) -> None:
    report = sample.data(tests=2)
    report.update(wall_s=wall_s, selected=number, known_violations={"R3": reason}, not_run_tests=[name, file])
    report["suites"][0]["requirements"]["R3"] |= {"passed": number, "failed": 1, "nc": number, "triggers": number}
    plans = {"covered": [], "missing": [file] * 20, "total": number, "declared": [], "reached": {}}
    report["suites"][0]["plans"] = {name: plans}
    report["code_under_test"]["files"][0].update(file=file, missing_lines=lines)
    for line in (line for line in _lines(report, columns) if not line.text.endswith("index.html")):
        assert width(line.text) <= columns
        assert "\n" not in line.text
