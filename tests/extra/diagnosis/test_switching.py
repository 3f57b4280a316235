"""The code under test with one decision reversed."""

from __future__ import annotations

import builtins
import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.extra.diagnosis.switching import (
    DECIDE,
    DecisionRecord,
    DecisionSwitch,
    SwitchedRun,
    SwitchSearch,
)
from pytest_hricdv.generate.concrete import ConcreteTest
from tests.execution.library_examples import LIBRARIES, failed_examples

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


def decision(line: int, number: int) -> DecisionSwitch:
    return DecisionSwitch(file="guard.py", line=line, number=number)


@pytest.mark.parametrize(
    ("wanted", "said", "result"),
    [
        (None, ["stop", "stop"], "near"),
        (decision(10, 2), [], "far"),  # three times, and the loop clears them
        (decision(10, 1), ["stop"], "near"),
        (decision(14, 1), ["stop", "stop"], "far"),
        (decision(99, 1), ["stop", "stop"], "near"),
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


def test_functions_made_in_functions_and_imports_to_come_ask_too(
    guard: ModuleType, switch: Callable[[DecisionSwitch | None], DecisionRecord]
) -> None:
    switch(decision(19, 1))
    seen: list[str] = []
    guard.made(seen)
    assert seen == ["two"]
    del sys.modules["guard_to_switch"]
    switch(decision(19, 1))
    importlib.import_module("guard_to_switch").made(seen)
    assert seen == ["two", "two"]


def passes(control: RunSummary, made: RunSummary) -> bool:
    return not made.violated


def test_the_most_suspicious_are_tried_first_in_each_test_and_within_the_budget() -> None:
    tried: list[tuple[str, int]] = []

    def run(test: ConcreteTest, wanted: DecisionSwitch | None) -> SwitchedRun:
        tried.append((test.id, 0 if wanted is None else wanted.line))
        lets_pass = wanted is not None and (wanted.line == 7 or (wanted.line, test.id) == (3, "t"))
        last = (decision(3, 1), decision(7, 4), decision(8, 1))
        return SwitchedRun(summary=RunSummary(violated=() if lets_pass else ("R1",)), last=last)

    scores = {("guard.py", 3): 0.2, ("guard.py", 7): 0.9}
    tests = [(TEST, passes), (replace(TEST, id="u"), passes)]
    search = SwitchSearch(run, 10)
    assert search.search(tests, scores) == [("guard.py", 7)]
    assert tried == [("t", 0), ("t", 7), ("t", 3), ("u", 0), ("u", 7), ("u", 3)]
    assert SwitchSearch(run, 3).search(tests, scores) == [("guard.py", 7), ("guard.py", 3)]
    assert SwitchSearch(run, 0).search(tests, scores) == []


@pytest.mark.parametrize("name", LIBRARIES)
def test_examples_of_a_library_whose_decisions_are_recorded_hold(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    record = DecisionRecord(None)
    monkeypatch.setattr(builtins, DECIDE, record.decide, raising=False)
    assert failed_examples(name, record.change("library.py"), monkeypatch) == 0
    assert record.times_s
