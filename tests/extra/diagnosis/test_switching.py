"""The code under test with one decision reversed."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.diagnosis.cause_switches import passes_until
from pytest_hricdv.extra.diagnosis.locations import is_sure
from pytest_hricdv.extra.diagnosis.runs import RunEvent, RunSummary
from pytest_hricdv.extra.diagnosis.switching import (
    DECIDE,
    DecisionRecord,
    DecisionSwitch,
    SwitchedRun,
    SwitchResult,
    SwitchSearch,
)
from pytest_hricdv.generate.concrete import ConcreteTest

GUARD = '''"""A guard."""


class Guard:
    def __init__(self, said):
        self.said = said

    def watch(self, distances):
        for distance in distances:
            if distance < 1.0:
                self.said.append("stop")
            while len(self.said) > 2:
                self.said.clear()
        return "near" if self.said else "far"


def made(said):
    def announce(text, left_out=False):
        if not left_out:
            said.append(text)

    announce("one")
    announce("two")
'''
TEST = ConcreteTest("t", "suite", 0, (), {})


@pytest.fixture
def guard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    (tmp_path / "guard_to_switch.py").write_text(GUARD, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield importlib.import_module("guard_to_switch")
    del sys.modules["guard_to_switch"]


@pytest.fixture
def switch(guard: ModuleType) -> Iterator[Callable[[DecisionSwitch | None], DecisionRecord]]:
    with ExitStack() as stack:

        def made(wanted: DecisionSwitch | None) -> DecisionRecord:
            switch = DecisionRecord(wanted)
            assert guard.__file__ is not None
            files = [(Path(guard.__file__), GUARD, switch.change("guard.py"))]
            stack.enter_context(instrument(files, {DECIDE: switch.decide}))
            return switch

        yield made
    seen: list[str] = []
    assert (guard.Guard(seen).watch([0.5]), seen) == ("near", ["stop"])  # as it was


def decision(line: int, first: int, outcome: bool, until_s: float = 0.0) -> DecisionSwitch:
    return DecisionSwitch(file="guard.py", line=line, first=first, until_s=until_s, outcome=outcome)


@pytest.mark.parametrize(
    ("wanted", "said", "result"),
    [
        (None, ["stop", "stop"], "near"),
        (decision(10, 2, outcome=True), [], "far"),  # three times, and the loop clears them
        (decision(10, 1, outcome=False), ["stop"], "near"),
        (decision(10, 1, outcome=True), ["stop", "stop"], "near"),  # as it comes out anyway
        (decision(14, 1, outcome=False), ["stop", "stop"], "far"),
        (decision(99, 1, outcome=False), ["stop", "stop"], "near"),
    ],
)
def test_one_thing_is_done_otherwise(
    guard: ModuleType,
    switch: Callable[[DecisionSwitch | None], DecisionRecord],
    wanted: DecisionSwitch | None,
    said: list[str],
    result: str,
) -> None:
    switch(wanted)
    seen: list[str] = []
    assert guard.Guard(seen).watch([0.5, 2.0, 0.7]) == result
    assert seen == said


def test_a_decision_is_changed_for_a_while_and_once_at_each_instant(
    guard: ModuleType, switch: Callable[[DecisionSwitch | None], DecisionRecord]
) -> None:
    now_s = iter((0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0))
    made = switch(decision(10, 2, outcome=True, until_s=4.0))
    made.now_s = lambda: next(now_s)
    seen: list[str] = []
    guard.Guard(seen).watch([2.0, 2.0, 2.0, 2.0])  # lines 10 and 12 in turn, then 14
    assert seen == ["stop", "stop"]  # not the first time, nor twice at 1.0 s


def test_what_is_returned_or_assigned_is_a_decision_if_it_is_a_bool(
    switch: Callable[[DecisionSwitch | None], DecisionRecord],
) -> None:
    made = DecisionRecord(DecisionSwitch(file="a.py", line=2, first=1, until_s=0.0, outcome=False))
    tree = ast.parse("def near(gap):\n    return gap < 1.0\ndef name(gap):\n    said = str(gap)\n    return said\n")
    names: dict[str, Any] = {DECIDE: made.decide}
    exec(compile(ast.fix_missing_locations(made.change("a.py")(tree)), "a.py", "exec"), names)
    assert (names["near"](0.5), names["near"](0.5), names["name"](0.5)) == (False, True, "0.5")
    assert [made.sites[number] for number in made.times_s] == [("a.py", 2)]


def test_functions_made_in_functions_and_imports_to_come_ask_too(
    guard: ModuleType, switch: Callable[[DecisionSwitch | None], DecisionRecord]
) -> None:
    switch(decision(19, 1, outcome=False))
    seen: list[str] = []
    guard.made(seen)
    assert seen == ["two"]
    del sys.modules["guard_to_switch"]
    switch(decision(19, 1, outcome=False))
    importlib.import_module("guard_to_switch").made(seen)
    assert seen == ["two", "two"]


def test_a_decision_is_to_be_changed_from_when_it_mattered_then_the_last_time_alone(
    guard: ModuleType, switch: Callable[[DecisionSwitch | None], DecisionRecord]
) -> None:
    made, now_s = switch(None), iter(range(100))
    made.now_s = lambda: float(next(now_s))
    guard.Guard([]).watch([0.5, 2.0, 0.7])  # lines 10, 12, 10, 12, 10, 12, 14 at 0.0 to 6.0 s
    assert [*made.switches(1.0, 4.0, 9.0)] == [
        decision(10, 2, outcome=False, until_s=9.0),
        decision(10, 3, outcome=False, until_s=4.0),
        decision(12, 1, outcome=True, until_s=9.0),
        decision(12, 2, outcome=True, until_s=3.0),
    ]


def passes(control: RunSummary, made: RunSummary, until_s: float) -> bool:
    return not made.violated


def never(caller: tuple[str, int], called: tuple[str, int]) -> bool:
    return False


SCORES = {("guard.py", 3): 0.2, ("guard.py", 7): 0.9}
TESTS = [(TEST, passes), (replace(TEST, id="u"), passes)]


def test_the_most_suspicious_are_tried_first_in_each_test_and_within_the_budget() -> None:
    tried: list[tuple[str, int]] = []

    def run(test: ConcreteTest, wanted: DecisionSwitch | None) -> SwitchedRun:
        tried.append((test.id, 0 if wanted is None else wanted.line))
        lets_pass = wanted is not None and (wanted.line == 7 or (wanted.line, test.id) == (3, "t"))
        switches = (decision(3, 1, outcome=True), decision(7, 4, outcome=True), decision(8, 1, outcome=True))
        return SwitchedRun(summary=RunSummary(violated=() if lets_pass else ("R1",)), switches=switches)

    assert SwitchSearch(run, 10).search(TESTS, SCORES, never) == [SwitchResult(("guard.py", 7), 0, 0)]
    assert tried == [("t", 0), ("t", 7), ("t", 3), ("u", 0), ("u", 7), ("u", 3)]
    assert SwitchSearch(run, 3).search(TESTS, SCORES, never) == []  # no run is left for the second test
    assert SwitchSearch(run, 0).search(TESTS, SCORES, never) == []


def test_what_changes_least_comes_first_then_what_others_pass_on() -> None:
    said = RunEvent(time_s=1.0, stream="robot: said", value="", text="")
    switches = tuple(decision(line, 1, outcome=True) for line in (3, 7, 8))

    def run(test: ConcreteTest, wanted: DecisionSwitch | None) -> SwitchedRun:
        if wanted is None:
            return SwitchedRun(summary=RunSummary(violated=("R1",), events=(said,)), switches=switches)
        return SwitchedRun(summary=RunSummary(violated=(), events=() if wanted.line == 8 else (said,)))

    def calls(caller: tuple[str, int], called: tuple[str, int]) -> bool:
        return (caller[1], called[1]) == (7, 3)

    scores = {("guard.py", line): line / 10 for line in (3, 7, 8)}
    assert SwitchSearch(run, 20).search(TESTS[:1], scores, calls) == [
        SwitchResult(("guard.py", 3), 0, 1),
        SwitchResult(("guard.py", 7), 0, 0),
        SwitchResult(("guard.py", 8), 1, 0),  # the robot says nothing any more
    ]


def test_a_run_without_an_end_shows_nothing() -> None:
    assert SwitchSearch(lambda test, wanted: None, 4).search([(TEST, passes)], SCORES, never) == []


@pytest.mark.parametrize(
    ("switches", "is_shown"),
    [
        ([], False),
        ([(0, 0)], True),
        ([(4, 0)], False),  # the robot does less: it may only rest
        ([(4, 1), (4, 0)], True),  # the other one only passes on what it decides
        ([(0, 0), (0, 0), (0, 0)], False),
    ],
)
def test_a_decision_is_shown_if_it_is_one_of_few_or_others_pass_it_on(
    switches: list[tuple[int, int]], is_shown: bool
) -> None:
    found = [SwitchResult(("a.py", line), changes, callers) for line, (changes, callers) in enumerate(switches)]
    assert is_sure(found) == is_shown


@pytest.mark.parametrize(
    ("violated", "time_s", "until_s", "is_right"),
    [
        ((), None, 9.0, True),
        (("R1",), 5.0, 9.0, False),
        (("R1",), 20.0, 9.0, True),  # the next time, when nothing was reversed any more
        (("R1",), 4.6, 4.5, False),  # only a little later: the last decision alone
        (("R2",), 20.0, 9.0, False),  # another one instead
    ],
)
def test_a_run_passes_as_long_as_a_decision_was_reversed(
    violated: tuple[str, ...], time_s: float | None, until_s: float, is_right: bool
) -> None:
    control = RunSummary(violated=("R1",), checked=("R2",), times_s={"R1": 4.5})
    checked = tuple({"R1", "R2"} - {*violated})
    made = RunSummary(violated=violated, checked=checked, times_s=dict.fromkeys(violated, time_s or 0.0))
    assert passes_until({"R1"}, control, made, until_s) == is_right
