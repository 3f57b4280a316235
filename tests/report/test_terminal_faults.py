"""Faults in the terminal: one that several tests have is one line."""

from __future__ import annotations

import msgspec

from pytest_hricdv.report import terminal
from tests.report import sample


def _lines(*faults: tuple[str, ...]) -> list[str]:
    report = sample.report(tests=len(faults))
    pairs = zip(report.tests, faults, strict=True)
    tests = tuple(msgspec.structs.replace(test, errors=own, id=f"t{n}") for n, (test, own) in enumerate(pairs))
    found = terminal.findings(msgspec.structs.replace(report, tests=tests))
    return [line.text for line in found if line.text.startswith("fault: ")]


def test_a_crash_of_several_tests_is_one_line_whenever_it_was() -> None:
    crash = "the code under test raised IndexError: index {} is out of bounds in node scanner at {} s"
    assert _lines((crash.format(480, 0.645),), (crash.format(481, 12.3),), (crash.format(480, 7),)) == [
        f"fault: {crash.format(480, 0.645)} (t0, and 2 more tests)"
    ]


def test_faults_that_differ_in_more_than_times_are_several_lines() -> None:
    first, second = "the bin leg 1 must not be hit", "the bin leg 2 must not be hit"
    assert _lines((first, second), (second,), ()) == [
        f"fault: {first} (t0)",
        f"fault: {second} (t0, and 1 more test)",
    ]
