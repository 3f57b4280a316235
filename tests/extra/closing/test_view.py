"""What a report says of its closing loop: in the terminal and on the page."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.closing.view import curves
from pytest_hricdv.report import html, terminal
from tests.json_schema import REPORT as SCHEMA
from tests.report import sample, sample_sections
from tests.report.parsed import Page

DATA = sample.data(("closure",), tests=2) | {"closing": sample_sections.CLOSING}
REPORT = sample.typed(DATA)


def test_the_sample_keeps_the_published_schema() -> None:
    SCHEMA.validate(DATA)


def test_the_summary_counts_points_by_kind_and_names_open_ones_in_at_most_ten_lines_that_fit() -> None:
    lines = [line.text for line in terminal.summary(REPORT, Path("out"), 120)]
    assert max(map(len, lines)) <= 120
    start = lines.index("closing: 400 runs, 30212 s simulated; ended: the budget of runs is used up")
    assert lines[start + 1 : start + 14] == [
        "  points            hit  impossible   open",
        "  statements          2           1      1",
        "  branches            0           0      1",
        "  bins                1           4     12",
        "  verdicts            0           0      1",
        "  1 run did not end",
        "  violated: R4 (joint_speed < 0.25) in Reset, released: 1 run (closure-x)",
        "  violated: the robot raised <b>KeyError</b>: 2 runs (closure-x)",
        "  kinds of violations: 1 known, see the report",
        "  open: R1 Passed: reading.gaze & reading.pressure; 120 tries, below 2.5 %",
        "  open: controller/states.py:13: line 12 (`if <script>:`) has to continue to it (closure-near); "
        "never aimed at",
        "  open: controller/states.py:12->exit: 1 try",
        "  open: handover: 100 x 1: leg 4 instead of 3 (closure-near); 104 tries, below 2.9 %",
    ]
    open_lines = [line for line in lines if line.startswith("  open:")]
    assert len(open_lines) == 10
    assert open_lines[-1] == "  open: 6 more: see the report"


def test_the_page_has_each_open_point_with_its_evidence_and_the_reasons_of_impossible_ones() -> None:
    words = " ".join(Page(html.page(REPORT)[0]).words.split())
    assert (
        "Closing: 400 runs, 30212 s simulated; ended: the budget of runs is used up. 2 tests of other suites" in words
    )
    assert "statements 2 1 1 branches 0 0 1 bins 1 4 12 verdicts 0 0 1" in words
    assert "disturbances 300 23212 s 1" in words
    assert (
        "line 12 ( if <script>: ) has to continue to it if it cannot be: controller/states.py:13: # unreachable: why"
        in words
    )
    assert "12 bins of handover" in words
    assert (
        "1 verdict of R1 Point Tries Closest run, and what it lacked R1 Passed 120 tries, below 2.5 % reading.gaze"
        in words
    )
    assert "below 100" not in words
    assert """if it cannot be: cross product handover: impossible={('001', '1'): "why"}""" in words
    assert "# id: closure-near # seed: 1 tell leg" in words
    assert "R4 violated Reset released 1 joint_speed < 0.25 closure-x" in words
    assert "fault violated - - 2 the robot raised <b>KeyError</b> closure-x Known violations 1 kind" in words
    assert "statements 1 waived a <b>guard</b> bins 4 model the model" in words


def test_curves_end_at_the_share_that_is_hit_and_begin_with_given_tests() -> None:
    found = curves(REPORT)
    assert found is not None
    assert found["kinds"]["statements"]["runs"] == [(0, 0.0), (1, 33.33), (200, 66.67), (400, 66.67)]
    assert found["kinds"]["statements"]["sim_s"][1] == (70.2, 33.33)
    assert found["kinds"]["bins"]["runs"][:2] == [(0, 0.0), (0, 7.69)]
    assert found["strategies"]["disturbances"]["runs"] == [(0, 0.0), (200, 1.0), (400, 1.0)]


NEAR = {
    "searched": 40,
    "closest_runs": [
        {"requirement": "R1", "margin": 4.0, "spread": 5.0, "test": "closure-x", "runs": 90, "searched": 2},
        {"requirement": "R2", "margin": 0.25, "spread": 50.0, "test": "closure-near", "runs": 300, "searched": 30},
        {"requirement": "R3", "margin": None, "spread": None, "test": "", "runs": 7, "searched": 8}
        | {"vacuous_alternatives": ["on(<b>late</b>)"]},
        {"requirement": "R4", "margin": -1.0, "spread": 2.0, "test": "closure-x", "runs": 9, "searched": 0},
    ],
    "estimated_undetected": {"kinds": 9, "once": 2, "runs": 400, "new": 0.005},
}


def with_near(**changed: object) -> dict[str, Any]:
    return DATA | {"closing": sample_sections.CLOSING | NEAR | changed}


def test_the_summary_says_what_came_nearest_and_what_a_further_run_would_find() -> None:
    SCHEMA.validate(with_near())
    lines = [line.text for line in terminal.summary(sample.typed(with_near()), Path("out"), 120)]
    assert "  40 runs of these searched for violations where margins were smallest" in lines
    assert "  a further run would find 0.005 more kinds of violations (2 of 9 came once)" in lines
    (nearest,) = [line for line in lines if line.startswith("  nearest to a violation: ")]
    assert re.fullmatch(r"  nearest to a violation: R2 by 0\.25\b.*, R1 by 4\b.*", nearest)  # R4 is violated
    none = with_near(estimated_undetected={"kinds": 0, "once": 0, "runs": 300, "new": 0.0})
    lines = [line.text for line in terminal.summary(sample.typed(none), Path("out"), 120)]
    assert "  no new violation in 300 runs: below 1.0 % of runs show another (95 %)" in lines
    again = with_near(estimated_undetected={"kinds": 3, "once": 0, "runs": 300, "new": 0.0})
    lines = [line.text for line in terminal.summary(sample.typed(again), Path("out"), 80)]
    assert "  all kinds of violations recurred: below 1.0 % of runs show another (95 %)" in lines
