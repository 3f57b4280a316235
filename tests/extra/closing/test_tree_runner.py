"""Tests on several processes: trees, or each from the start; what is told is the same."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from pytest_hricdv.extra.closing.branching import Leaf
from pytest_hricdv.extra.closing.tree_runner import TreeRunner
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.run import Actions
from tests.extra.closing import toy

TESTS = [
    toy.concrete("ask", "look", "reach"),
    toy.concrete("ask", "look", "reach", seed=2),
    toy.concrete("ask", "look", "pull"),
    toy.concrete("sit"),
    toy.concrete("ask", "wait", "fail"),
    toy.concrete("ask", "wait", "say"),
]
TOLD = [*toy.texts([*TESTS[:4]]), "ValueError: tripped over the cable"]
TOLD += toy.texts(TESTS[5:])


def _text(leaf: Leaf[str]) -> str:
    return leaf.result or leaf.problem


def _with_process(leaf: Leaf[str]) -> str:
    return f"{os.getppid()} {os.getpid()} {_text(leaf)}"


def _told(found: Iterator[tuple[int, str]]) -> list[str]:
    return [text for _, text in sorted(found)]


@pytest.mark.parametrize("processes", [1, 2, 3])
@pytest.mark.parametrize("from_the_start", [False, True])
def test_each_test_is_told_of_once_however_it_is_run(processes: int, from_the_start: bool) -> None:
    runner = TreeRunner(toy.execute, _text, processes, 30.0)
    found = [*runner.run(TESTS, from_the_start=from_the_start)]
    assert len(found) == len(TESTS)
    assert _told(iter(found)) == TOLD


def test_without_forks_the_same_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "fork")
    runner = TreeRunner(toy.execute, _text, 2, 30.0)
    assert [*runner.run(TESTS)] == [*enumerate(TOLD)]


def test_from_the_start_each_test_has_a_process_of_this_one() -> None:
    runner = TreeRunner(toy.execute, _with_process, 2, 30.0)
    alone = _told(runner.run(TESTS, from_the_start=True))
    assert {text.split()[0] for text in alone} == {str(os.getpid())}
    assert len({text.split()[1] for text in alone}) == len(TESTS)
    together = _told(runner.run(TESTS))
    assert {text.split()[0] for text in together} > {str(os.getpid())}, "some are forks of forks"


def test_a_tree_that_dies_before_it_parts_is_an_error_of_its_tests_only() -> None:
    def dying(test: ConcreteTest, actions: Actions) -> str:
        if test.seed == 2:
            os._exit(3)
        return toy.execute(test, actions)

    tests = [toy.concrete("ask", "say", seed=2), toy.concrete("ask", "look", seed=2), TESTS[0]]
    runner = TreeRunner(dying, _text, 2, 30.0)
    assert _told(runner.run(tests)) == [*["its process: ended with status 3"] * 2, TOLD[0]]
