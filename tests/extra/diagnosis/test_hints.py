"""Hints: a repair is one if all failing tests that are run with it pass, and no other changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import pytest

from pytest_hricdv.extra.diagnosis.hints import FailingTest, Hint, PassingTest, Repairing
from pytest_hricdv.extra.diagnosis.locating import raised, words_of
from pytest_hricdv.extra.diagnosis.repairs import Repair
from pytest_hricdv.extra.diagnosis.runs import Event, Ran
from pytest_hricdv.extra.diagnosis.spectrum import Suspect
from pytest_hricdv.generate.concrete import ConcreteTest

Looked = Callable[..., tuple[list[tuple[str, int, int]], list[str]]]

GOOD, BAD = Ran(violated=(), checked=("R1", "R2")), Ran(violated=("R1",), checked=("R2",))


def concrete(name: str) -> ConcreteTest:
    """A test."""
    return ConcreteTest(name, "suite", 1, (), {})


def repair(name: str, line: int = 3) -> Repair:
    """A repair with this text."""
    return Repair("robot.py", line, "act", "left out", f"without `{name}`", name)


FAILING = [FailingTest(concrete(name), ["R1"], ["R1"]) for name in ("f1", "f2", "f3")]
PASSING = [PassingTest(concrete(name), ["R1", "R2"], []) for name in ("p1", "p2")]


@dataclass
class Runs:
    """Runs of tests with repairs: by both, or by the repair; failing where nothing is said."""

    results: Mapping[str, Ran | None]
    made: list[str] = field(default_factory=list)

    def run(self, repaired: Repair, test: ConcreteTest) -> Ran | None:
        self.made.append(f"{repaired.text} {test.id}")
        return self.results.get(self.made[-1], self.results.get(repaired.text, BAD))


@pytest.fixture
def hints() -> Looked:
    """Repairs and what came of each; and the runs that were made."""

    def looked_for(
        results: Mapping[str, Ran | None], *names: str, budget: int = 99
    ) -> tuple[list[tuple[str, int, int]], list[str]]:
        runs = Runs(results)
        repairing = Repairing(runs.run, budget)
        hints = repairing.hints(map(repair, names, map(ord, names)), FAILING, lambda repair: PASSING)
        assert repairing.used == len(runs.made) <= budget
        return [(hint.repair.text, hint.mended, hint.unchanged) for hint in hints], runs.made

    return looked_for


def test_a_repair_that_mends_all_and_changes_nothing_is_a_hint(hints: Looked) -> None:
    assert hints({"b": GOOD}, "a", "b") == ([("b", 3, 2)], ["a f1", "b f1", "b p1", "b f2", "b p2", "b f3"])


@pytest.mark.parametrize(
    ("results", "runs"),
    [
        ({"a": GOOD, "a p1": BAD}, ["a f1", "a p1"]),
        ({"a": GOOD, "a f2": BAD}, ["a f1", "a p1", "a f2"]),
        ({"a": Ran(violated=(), checked=("R2",))}, ["a f1"]),  # R1 is not checked any more
        ({"a": GOOD, "a p1": Ran(violated=(), checked=("R1",))}, ["a f1", "a p1"]),
        ({"a": Ran(violated=("R2",), checked=("R1",))}, ["a f1"]),  # another requirement fails instead
        ({"a": None}, ["a f1"]),
    ],
)
def test_what_does_not_is_none(hints: Looked, results: Mapping[str, Ran], runs: list[str]) -> None:
    assert hints(results, "a") == ([], runs)


def test_the_budget_and_the_number_of_hints_end_it(hints: Looked) -> None:
    assert hints({"b": GOOD}, "a", "b", budget=3) == ([("b", 1, 1)], ["a f1", "b f1", "b p1"])
    found, _ = hints({"a": GOOD, "b": GOOD, "c": GOOD}, "a", "b", "c")
    assert [text for text, *_ in found] == ["a", "b"]


def test_a_statement_has_one_hint() -> None:
    repairing = Repairing(Runs({"a": GOOD, "b": GOOD, "c": GOOD}).run, 99)
    made = repairing.hints([repair("a"), repair("b"), repair("c", line=4)], FAILING, lambda repair: PASSING)
    assert [hint.repair.text for hint in made] == ["a", "c"]


def happened(*texts: str, violated: tuple[str, ...] = (), at_s: float = 99.0) -> Ran:
    """A run in which this happens, one after the other."""
    events = [Event(time_s=number, stream=text, value="", text=text) for number, text in enumerate(texts)]
    times_s = dict.fromkeys(violated, at_s)
    return Ran(violated=violated, checked=("R1", "R2"), events=tuple(events), times_s=times_s)


def test_what_mends_by_doing_nothing_is_no_hint_and_what_changes_least_comes_first() -> None:
    failing = FailingTest(concrete("f"), ["R1"], ["R1"], "f", happened(*"vwxyz", violated=("R1",), at_s=4.5))
    runs = Runs({"a": happened(), "b": happened(*"vwx"), "c": happened(*"vwxyz"), "d": happened(*"vwxyz"), "e": GOOD})
    repairing = Repairing(runs.run, 99)
    repairs = [repair(name, line) for line, name in enumerate("abcde")]
    hints = repairing.hints(repairs, [failing], lambda repair: PASSING)
    assert [(hint.repair.text, hint.kept) for hint in hints] == [("c", 1.0), ("d", 1.0)]
    assert runs.made == ["a f", "b f", "b p1", "b p2", "c f", "c p1", "c p2", "d f", "d p1", "d p2"]


def test_a_statement_keeps_the_hint_that_changes_least() -> None:
    failing = FailingTest(concrete("f"), ["R1"], ["R1"], "f", happened(*"vwxyz", violated=("R1",)))
    runs = Runs({"a": happened(*"vwx"), "b": happened(*"vwxy"), "c": happened(*"vwx")})
    hints = Repairing(runs.run, 99).hints(map(repair, "abc"), [failing], lambda repair: [])
    assert [(hint.repair.text, hint.kept) for hint in hints] == [("b", 0.8)]


@pytest.mark.parametrize(
    ("results", "budget", "mended", "runs"),
    [
        ({"a": GOOD}, 99, ["f1", "f2", "f3"], 3),
        ({"a": GOOD}, 2, ["f1", "f2"], 2),
        ({"a": GOOD, "a f2": BAD}, 99, [], 2),
        ({"a": GOOD}, 0, [], 0),
    ],
)
def test_a_repair_mends_another_cause_if_it_mends_all_tests_that_are_tried(
    results: Mapping[str, Ran], budget: int, mended: list[str], runs: int
) -> None:
    repairing = Repairing(Runs(results).run, budget)
    assert [test.test.id for test in repairing.mended(repair("a"), FAILING)] == mended
    assert repairing.used == runs


def test_a_hint_in_words() -> None:
    where = "without `b` in act (robot.py:3)"
    assert words_of(Hint(repair("b"), 3, 2), 3) == f"{where}, 3 of 3 failing tests pass, none of 2 others changes"
    assert words_of(Hint(repair("b"), 2, 0), 9) == f"{where}, 2 of 2 tried failing tests pass, no other was run"


def test_a_place_that_can_be_repaired_comes_first_if_more_than_one_test_says_so() -> None:
    ranked = [Suspect("robot.py", line, 0.5, 0) for line in (1, 2, 3)]
    assert [suspect.line for suspect in raised(ranked, [Hint(repair("b"), 1, 1)])] == [3, 1, 2]
    assert [suspect.line for suspect in raised(ranked, [Hint(repair("b"), 1, 0)])] == [1, 2, 3]
