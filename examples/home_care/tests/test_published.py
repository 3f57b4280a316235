"""The published tests as suites, and the published results."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from people.ranges import COMMANDS, PUBLISHED_S, WholeSeconds
from studies.comparison import sampled, suite_text, unheard_shares
from studies.published import (
    Counts,
    PublishedError,
    PublishedTest,
    counted,
    first_orders,
    lines,
    main,
    read,
    suites,
    summary,
)
from studies.results import UNHEARD, Run, agreement, published_result, result, runs_of

from pytest_hricdv.generate.suite_files import parse_tests
from studies.page import Comparison, unchecked


def test_all_known_tests_run_with_their_steps_as_lines() -> None:
    tests = read()
    assert len(tests) == 75
    for name, text, notes in suites(tests):
        assert not notes
        parsed = parse_tests(text, file=name, suite=name, commands=COMMANDS)
        assert [test.lines for test in parsed] == [
            test.steps for test in tests if test.method == name[-len(test.method) :]
        ]
        assert len({test.id for test in parsed}) == 25


def test_each_order_of_the_published_tests_is_a_command() -> None:
    assert {step for test in read() for step in test.steps} <= set(PUBLISHED_S)


def test_runs_are_counted_by_their_verdicts() -> None:
    counts = counted(["PPPF84:1011", "NNNN24:0000", "FNFF71:1010", "NNPP30:0000"])
    assert counts == Counts(4, 3, ((1, 1, 1), (1, 0, 2), (2, 1, 0), (1, 2, 0)), 84 + 71 + 30, 1)


def test_the_counts_of_the_known_half_add_up() -> None:
    for test in read():
        assert test.counts is not None
        assert test.counts.runs == 41
        assert all(sum(row) == test.counts.started for row in test.counts.verdicts)
    coverage = [published_result([t for t in read() if t.method == m]).coverage for m in ("bdi", "mc", "pr")]
    assert coverage == sorted(coverage, reverse=True)


def test_a_summary_is_read_back_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "tests.json"
    path.write_text(json.dumps(summary(read())), encoding="utf-8")
    assert read(path) == read()


@pytest.mark.parametrize(
    ("step", "line"),
    [
        ("fridge", "fridge"),
        ("Open Door", "opendoor"),
        ("open_door", "opendoor"),
        ("time-out", "rest"),
        ("ended", "ended"),
        ("dance", "whatever"),
    ],
)
def test_steps_are_lines_as_they_are_but_for_those_that_are_said(step: str, line: str) -> None:
    said, notes = lines(PublishedTest("mc", 2, (step,)))
    assert said == [line]
    assert bool(notes) == (line in ("rest", "whatever"))


def test_a_test_without_steps_is_one_in_which_nothing_is_ordered() -> None:
    said, (note,) = lines(PublishedTest("mc", 2, ()))
    assert said == ["rest"]
    assert "no steps" in note


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"methods": []}',
        '{"bdi": [3]}',
        '{"bdi": [{"steps": "fridge"}]}',
        '{"bdi": [{"steps": [3]}]}',
        '{"bdi": [{"n": "first", "steps": ["fridge"]}]}',
        '{"bdi": [{"n": 1, "steps": ["fridge"], "runs": ["whatever"]}]}',
        '{"bdi": [{"n": 1, "steps": ["fridge"], "counts": {}}]}',
    ],
)
def test_a_file_without_such_tests_is_an_error_of_one_line(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tests.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(PublishedError, match="expected"):
        read(path)
    assert main(["--write", str(tmp_path), str(path)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_the_first_order_is_unheard_where_nothing_is_carried_out() -> None:
    runs = Counts(10, 8, ((0, 0, 8),) * 4, 400, 2)
    tests = [
        PublishedTest("pr", 1, ("clean", "chase"), runs),
        PublishedTest("pr", 3, ("chase", "clean"), runs),
        PublishedTest("pr", 5, ("clean", "feed"), runs),
        PublishedTest("pr", 7, ("chase",), runs),
    ]
    assert first_orders(tests) == {"pr": (8, 2, 0.25)}


def test_tests_without_published_runs_have_the_unheard_first_orders_of_those_that_are_known() -> None:
    shares = unheard_shares([PublishedTest("pr", 2, ("clean", "chase")), PublishedTest("other", 2, ("clean",))])
    assert shares == {"pr": first_orders(read())["pr"][2], "other": 0.0}
    own = Counts(10, 8, ((0, 0, 8),) * 4, 400, 2)
    assert unheard_shares([PublishedTest("pr", 2, ("clean", "chase"), own)]) == {"pr": 0.25}


def test_as_many_copies_of_a_test_have_an_unheard_order_as_are_to() -> None:
    tests = [PublishedTest("pr", number, ("clean",)) for number in range(50)]
    text = suite_text(tests, 4, {"pr": 0.25})
    assert text.count("# name:") == 200
    assert text.count(UNHEARD) == 50
    assert suite_text(tests, 4, {}).count(UNHEARD) == 0


def test_a_verdict_agrees_with_as_many_published_runs_as_have_it() -> None:
    counts = Counts(10, 10, ((7, 2, 1),) * 4, 700, 0)
    test = PublishedTest("bdi", 1, ("feed",), counts)
    passed, failed = (Run("bdi", 1, (verdict,) * 4, 80.0) for verdict in ("Passed", "Failed"))
    assert agreement([test], [passed, passed, failed], 0) == (70.0, 70.0)
    assert agreement([test], [passed, failed, failed], 0) == (20.0, 70.0)
    assert result([passed, failed]).verdicts[0] == (1, 1, 0)


def test_a1_is_unchecked_where_no_food_is_heard_of() -> None:
    steps = [("fridge",), ("feed", "sink"), ("sink", "clean"), ("clean", "feed")]
    tests = [PublishedTest("pr", number, held) for number, held in enumerate(steps)]
    assert unchecked(tests, 0.0) == 25.0
    assert unchecked(tests, 0.4) == 35.0


def test_the_page_says_whether_a1_is_checked_where_food_was_ordered_and_heard() -> None:
    feed, sink = PublishedTest("pr", 1, ("feed", "sink")), PublishedTest("pr", 2, ("sink",))
    checked, unchecked_ = ("Passed",) * 4, ("NC",) * 4
    runs = [Run("pr", 1, checked, 80.0), Run("pr", 1, unchecked_, 80.0, True), Run("pr", 2, checked, 80.0)]
    text = Comparison([feed, sink], [feed, sink], 1, {"as it is": runs[1:], "as it was": runs}, {}, "").text()
    assert "In 1 of 2 runs as it is, and in 2 of 3 runs as it was, A1 was checked if and only if" in text


def test_which_runs_had_an_unheard_order_is_read_off_their_lines() -> None:
    held = {name: {"verdict": "NC"} for name in ("A1", "A2", "A3", "A4")}
    tests: list[dict[str, object]] = [
        {"name": "published pr 3", "requirements": held, "code": {"percent": 71.0}, "abstract": lines_}
        for lines_ in ([UNHEARD, "feed"], ["feed", UNHEARD])
    ]
    assert [run.is_unheard for run in runs_of({"tests": tests})] == [True, False]


def test_a_sample_has_as_many_tests_of_each_method_and_all_if_there_are_no_more() -> None:
    tests = read()
    assert [test.method for test in sampled(tests, 5)] == ["bdi"] * 5 + ["mc"] * 5 + ["pr"] * 5
    assert sampled(tests, 0) == sampled(tests, 99) == tests


def test_the_page_has_each_column_and_says_which_command_made_it() -> None:
    known = read()
    tests = sampled(known, 2)
    runs = [Run(test.method, test.number, ("Passed", "Failed", "Passed", "NC"), 80.0) for test in tests]
    text = Comparison(tests, known, 1, {"as it is": runs, "as it was": runs}, {"bdi": 0.15}, "").text()
    assert "python -m studies.comparison --copies 1 --sample 2`" in text
    for line in text.splitlines():
        if line.startswith("| A1 |"):
            assert line.count("|") == 5, "as it is, as it was, at most"
    widths = [{line.count("|") for line in block.splitlines()} for block in text.split("\n\n") if block.startswith("|")]
    assert widths
    assert all(len(width) == 1 for width in widths)


def test_waits_are_whole_seconds_each_equally_likely() -> None:
    from random import Random

    rng, waits = Random(0), WholeSeconds(90, 92)
    drawn = [waits.sample(rng) for _ in range(300)]
    assert set(drawn) == {90.0, 91.0, 92.0}
    assert all(60 < drawn.count(value) < 140 for value in set(drawn))
    assert waits.contains(91.0)
    assert not waits.contains(91.5)
