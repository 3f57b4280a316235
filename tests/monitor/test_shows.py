"""What else a violation tells: signals that a requirement shows beside those that it reads."""

from __future__ import annotations

from dataclasses import replace

from tests.monitor.vocabulary import Update, judge, requirement


def test_a_violation_tells_the_largest_value_of_what_it_shows_while_it_lasts() -> None:
    watched = replace(requirement("always(p -> x >= 1)"), shows=("y",))
    updates: list[Update] = [(0.0, "p", True), (0.0, "x", 2.0), (0.0, "y", 9.0)]
    updates += [(1.0, "y", 0.0), (2.0, "x", 0.0), (2.5, "y", -3.0), (3.0, "y", 2.0), (4.0, "x", 1.0), (4.0, "y", 8.0)]
    updates += [(5.0, "x", 0.0), (6.0, "p", False)]
    violations = judge(watched, updates, 7.0).violations
    assert [dict(violation.values) for violation in violations] == [
        {"p": True, "x": 0.0, "y": -3.0},
        {"p": True, "x": 0.0, "y": 8.0},
    ]


def test_a_requirement_is_judged_without_what_it_would_show() -> None:
    watched = replace(requirement("always(p -> x >= 1)"), shows=("y",))
    verdict = judge(watched, [(0.0, "p", True), (0.0, "x", 0.0)], 1.0)
    assert dict(verdict.violations[0].values) == {"p": True, "x": 0.0}


def test_a_missed_deadline_tells_what_it_shows_at_that_time() -> None:
    watched = replace(requirement("always(rise(p) -> eventually[0:1](q))"), shows=("y",))
    updates: list[Update] = [(0.0, "p", False), (0.0, "q", False), (0.0, "y", 5.0), (1.0, "p", True), (1.5, "y", 2.0)]
    assert judge(watched, updates, 4.0).violations[0].values["y"] == 2.0
