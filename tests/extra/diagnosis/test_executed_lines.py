"""Which lines a failing run executed when, as its test's page has it."""

from __future__ import annotations

from pytest_hricdv.extra.diagnosis.executed_lines import MAX_BURSTS, MAX_LINES, collect_executed_lines
from pytest_hricdv.extra.diagnosis.trace import TraceStep


def _steps(*steps: tuple[float, int, str, int]) -> list[TraceStep]:
    return [TraceStep(*step) for step in steps]


def test_what_a_node_executes_at_one_time_is_a_burst_that_is_written_once() -> None:
    again = [(0.0, 0, "a.py", 1), (0.0, 0, "a.py", 2), (0.0, 0, "b.py", 7)]
    lines = collect_executed_lines(_steps(*again, (0.5, 0, "a.py", 3), *((1.0, *step[1:]) for step in again)), None)
    assert lines.files == ("a.py", "b.py")
    assert lines.bursts == ("0:1 2 1:7", "0:3")
    assert lines.nodes == ("0 0 0.5 1 1 0",)
    assert (lines.from_s, lines.until_s) == (0.0, None)


def test_each_node_has_its_own_bursts() -> None:
    lines = collect_executed_lines(_steps((0.0, 0, "a.py", 1), (0.0, 1, "a.py", 9), (0.2, 1, "a.py", 9)), None)
    assert lines.nodes == ("0 0", "0 1 0.2 1")
    assert lines.bursts == ("0:1", "0:9")


def test_a_long_run_is_cut_to_what_leads_to_the_violation() -> None:
    steps = [TraceStep(float(second), 0, "a.py", second % 7 + 1) for second in range(3 * MAX_BURSTS)]
    lines = collect_executed_lines(steps, 9000.0)
    assert lines.until_s == 9010.0
    assert lines.from_s == 9010.0 - MAX_BURSTS + 1
    [node] = lines.nodes
    assert len(node.split()) == 2 * MAX_BURSTS
    assert collect_executed_lines(steps, None).until_s == 3 * MAX_BURSTS - 1
    assert collect_executed_lines(steps, 5.0).from_s == 0.0


def test_of_a_long_burst_its_last_lines_are_kept() -> None:
    lines = collect_executed_lines([TraceStep(0.0, 0, "a.py", number) for number in range(1, 1000)], None)
    assert lines.bursts == (f"0:{1000 - MAX_LINES} " + " ".join(map(str, range(1001 - MAX_LINES, 1000))),)


def test_a_run_of_nothing_has_no_lines() -> None:
    assert collect_executed_lines([], 1.0).nodes == ()
