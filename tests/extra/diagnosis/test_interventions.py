"""The code under test with one decision switched, or one call left out."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.diagnosis.interventions import (
    DECIDE,
    MAKES,
    Intervention,
    InterventionRun,
    SwitchSearch,
    _Switch,
)
from pytest_hricdv.extra.diagnosis.runs import RunSummary
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
    def announce(text):
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
def switch(guard: ModuleType) -> Iterator[Callable[[Intervention | None], _Switch]]:
    with ExitStack() as stack:

        def made(wanted: Intervention | None) -> _Switch:
            switch = _Switch(wanted)
            assert guard.__file__ is not None
            files = [(Path(guard.__file__), GUARD, switch.change("guard.py"))]
            stack.enter_context(instrument(files, {DECIDE: switch.decide, MAKES: switch.makes}))
            return switch

        yield made
    seen: list[str] = []
    assert (guard.Guard(seen).watch([0.5]), seen) == ("near", ["stop"])  # as it was


def decision(line: int, number: int | None) -> Intervention:
    return Intervention(file="guard.py", line=line, kind="decision", number=number)


def call(line: int, number: int | None) -> Intervention:
    return Intervention(file="guard.py", line=line, kind="call", number=number)


@pytest.mark.parametrize(
    ("wanted", "said", "result"),
    [
        (None, ["stop", "stop"], "near"),
        (decision(10, 2), [], "far"),  # three times, and the loop clears them
        (decision(10, 1), ["stop"], "near"),
        (decision(10, None), ["stop"], "near"),
        (call(11, None), [], "far"),
        (call(11, 2), ["stop"], "near"),
        (decision(14, 1), ["stop", "stop"], "far"),
        (decision(99, 1), ["stop", "stop"], "near"),
    ],
)
def test_one_thing_is_done_otherwise(
    guard: ModuleType,
    switch: Callable[[Intervention | None], _Switch],
    wanted: Intervention | None,
    said: list[str],
    result: str,
) -> None:
    switch(wanted)
    seen: list[str] = []
    assert guard.Guard(seen).watch([0.5, 2.0, 0.7]) == result
    assert seen == said


def test_functions_made_in_functions_and_imports_to_come_ask_too(
    guard: ModuleType, switch: Callable[[Intervention | None], _Switch]
) -> None:
    switch(call(21, 1))
    seen: list[str] = []
    guard.made(seen)
    assert seen == ["two"]
    del sys.modules["guard_to_switch"]
    switch(call(21, 1))
    importlib.import_module("guard_to_switch").made(seen)
    assert seen == ["two", "two"]


def test_it_is_counted_until_the_violation(guard: ModuleType, switch: Callable[[Intervention | None], _Switch]) -> None:
    made, now_s = switch(None), iter(range(100))
    made.now_s = lambda: float(next(now_s))
    guard.Guard([]).watch([0.5, 2.0, 0.7])  # lines 10, 11, 12, 10, 12, 10, 11, 12
    assert [*made.until(3.0)] == [decision(10, 2), call(11, 1), decision(12, 1)]
    assert [*made.until(None)] == [decision(10, 3), call(11, 2), decision(12, 3), decision(14, 1)]


def test_the_most_suspicious_are_tried_first_and_within_the_budget() -> None:
    tried: list[Intervention | None] = []

    def run(test: ConcreteTest, intervention: Intervention | None) -> InterventionRun:
        tried.append(intervention)
        violated = () if intervention == decision(7, None) else ("R1",)
        return InterventionRun(
            summary=RunSummary(violated=violated), times=(decision(3, 1), decision(7, 4), decision(8, 1))
        )

    scores = {("guard.py", 3): 0.2, ("guard.py", 7): 0.9}
    search = SwitchSearch(run, 4)
    assert search.search(TEST, scores, lambda control, made: not made.violated) == [decision(7, None)]
    assert tried == [None, decision(7, 4), decision(7, None), decision(3, 1)]
    assert search.used == 4


def test_a_run_without_an_end_shows_nothing() -> None:
    assert SwitchSearch(lambda test, intervention: None, 4).search(TEST, {}, lambda control, made: True) == []
