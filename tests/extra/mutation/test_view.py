"""What a report says of mutants: in the terminal, on the page, and for other tools."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.mutation import view
from pytest_hricdv.extra.mutation.records import MUTATION
from pytest_hricdv.report import html, terminal
from tests.report import sample, sample_sections
from tests.report.parsed import Page

REPORT = sample.typed(sample.data(tests=2) | {"mutation": sample_sections.MUTATION})


def test_the_summary_has_score_oracles_and_survivors_in_lines_that_fit() -> None:
    lines = [line.text for line in terminal.summary(REPORT, Path("out"), 80)]
    assert max(map(len, lines)) <= 80
    start = lines.index("mutants: 25.0 % killed (1 of 4), 5 runs in 61.5 s")
    assert lines[start + 1 : start + 16] == [
        "  killed by  mutants  only by it",
        "  R1               1           0",
        "  exception        1           0",
        "  1 survived: a record changed, and nothing failed: an oracle is missing",
        "    controller/states.py:13  message dropped: robot.bus.publish(State(name))",
        "      rl-x: at 3.2 s `state(Reset)` is missing",
        "  1 unchanged: no record changed: a stimulus is missing, or it is equivalent",
        "    controller/states.py:14  message dropped: robot.bus.publish(State(name))",
        "  1 no coverage: no test executes the statement",
        "    controller/states.py:15  message dropped: robot.bus.publish(State(name))",
        "  1 not run: time ran out before all of its tests had run",
        "    controller/states.py:16  message dropped: robot.bus.publish(State(name))",
        "  2 that were not killed were tried on 1 test of a suite, and more execute them",
        "  1 test left out: failing or unmeasured without a bug: rl-leg1-left-out",
        "  1 mutant not tried: time ran out",
    ]


def test_the_page_has_each_mutant_once_with_what_killed_it() -> None:
    page = Page(html.page(REPORT)[0])
    words = " ".join(page.words.split())
    assert "25.0 % killed (1 of 4)" in words
    assert [words.count(f"controller/states.py:{line} message dropped") for line in range(12, 17)] == [1] * 5
    assert "becomes pass" in words
    assert "R1, exception rl-x KeyError: <script>" in words
    assert "rl-x: at 3.2 s state(Reset) is missing" in words


@pytest.mark.parametrize(
    ("before", "after", "change"),
    [
        ("robot.publish(State(name))", "pass", ("robot.publish(State(name))", "pass")),
        (
            "while bus.wait(patience_s) is not None:",
            "while bus.wait(patience_s * 2) is not None:",
            ("…wait(patience_s) is…", "…wait(patience_s * 2) is…"),
        ),
        ("return True", "return False", ("return True", "return False")),
        ("a, b, c, d = 1, 2", "a, b, c, d = 1, 3", ("…1, 2", "…1, 3")),
        ("go()", "go()\n    go()", ("go()", "go() / go()")),
        ("stop(now)", "", ("stop(now)", "")),
    ],
)
def test_a_fault_is_shown_in_a_line_by_what_it_changes(before: str, after: str, change: tuple[str, str]) -> None:
    result = MUTATION.of(REPORT)
    assert result is not None
    mutant = replace(result.mutants[0], before=before, after=after)
    assert view.change(mutant) == change


def test_a_report_without_mutants_says_nothing_of_them() -> None:
    report = sample.report()
    assert "utant" not in Page(html.page(report)[0]).words
    assert not [line for line in terminal.summary(report, Path("out"), 80) if "mutant" in line.text]
