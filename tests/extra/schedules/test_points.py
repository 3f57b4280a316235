"""Points: what statements read and write, and code that stops at them and does the same."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.schedules.points import BETWEEN, HOOK, CodePoints, DataAccess, access_of
from pytest_hricdv.extra.schedules.scheduler import calculate_written
from tests.execution.library_examples import LIBRARIES, failed_examples


@pytest.mark.parametrize(
    ("text", "reads", "writes"),
    [
        ("self.stopped = True", "", ".stopped"),
        ("x = self.stopped", ".stopped", ""),
        ("self.count += 1", ".count", ".count"),
        ("self.queue.append(x)", ".append .queue", ".queue"),
        ("self.table[x] = 1", ".table", ".table"),
        ("del self.table[x]", ".table", ".table"),
        ("total += x", "total", "total"),
        ("x += 1", "", ""),
        ("if self.free: pass", ".free", ""),
        ("while not stop.is_set(): pass", ".is_set stop", "stop"),
        ("with self.lock: self.count = 1", ".lock", ".lock"),
        ("with x: self.count = 1", "", "a-lock"),
        ("for x in self.items: self.seen = x", ".items", ""),
        ("return self.free", ".free", ""),
    ],
)
def test_a_statement_reads_and_writes_shared_data(text: str, reads: str, writes: str) -> None:
    (statement,) = ast.parse(text).body
    assert access_of(statement, frozenset({"self", "x"})) == DataAccess(
        frozenset(reads.split()), frozenset(name.replace("-", " ") for name in writes.split())
    )


@pytest.mark.parametrize("header", ["for x in self.goals:", "while self.goals:"])
def test_each_iteration_reads_what_the_header_of_its_loop_reads(header: str) -> None:
    points = CodePoints()
    points.instrument("robot.py").visit(ast.parse(f"def go(self):\n    {header}\n        move()\n"))
    assert ".goals" in points.accesses["robot.py:3"].reads


FUNCTIONS = '''
class Counter:
    def __init__(self):
        """Text."""
        self.count, self.items = 0, [0]

    def work(self, numbers):
        for number in numbers:
            if number > 3:
                self.count += number
            elif number < -3:
                self.count = self.count - number
            else:
                self.items += [number]
                continue
            try:
                self.count += self.add(number)
                self.items[0] += 1
                with self:
                    self.count |= 1
            finally:
                self.count <<= 1
        return self.count, self.items, self.rest(numbers)

    def rest(self, numbers):
        if any(number in self.items for number in numbers):
            self.count = 0
        for item in sorted(self.items, key=lambda item: (self.count % 3, -item)):
            self.count += (lambda: [item + (lambda: self.count)() for item in self.items[:3]])()[-1] % 5
        return {number: [item for item in self.items if item > number] for number in numbers}, lambda: [*self.items]

    def add(self, number):
        self.count += number  # lost: the caller has read it before
        self.items[self.key()] -= self.key()
        self.itself.count ^= 2
        try:
            self.items[self.missing] += 1
        except AttributeError:
            self.count += len(locals())
        self.items[:1] += [number]
        return 1

    @property
    def itself(self):
        self.items[0] += 7  # once for each statement that asks for it
        return self

    def key(self):
        self.count += 1
        return self.count % len(self.items)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None
'''


def loaded(points: CodePoints | None, reached: list[str]) -> Callable[[list[int]], Any]:
    tree = ast.parse(FUNCTIONS)
    names: dict[str, Any] = {}
    if points is not None:
        tree = ast.fix_missing_locations(points.instrument("counter.py").visit(tree))

        def between(point: int, value: object, read: object = None, operation: str = "") -> object:
            written = calculate_written(point, value, read, operation)
            reached.append(points.places[point])
            return written

        names = {HOOK: lambda point: reached.append(points.places[point]), BETWEEN: between}
    exec(compile(tree, "counter.py", "exec"), names)
    return lambda numbers: names["Counter"]().work(numbers)


@given(st.lists(st.integers(-9, 9), max_size=8))
def test_code_that_stops_at_points_does_the_same(numbers: list[int]) -> None:
    reached: list[str] = []
    *results, (rest, _) = loaded(CodePoints(), reached)(numbers)
    *expected, (expected_rest, _) = loaded(None, [])(numbers)
    assert (results, rest) == (expected, expected_rest)
    assert reached.count("counter.py:9") == len(numbers)
    visited = len(numbers) * (1 + len(results[1]))  # elements of the outer comprehension, and of the inner ones
    (line,) = (number for number, text in enumerate(FUNCTIONS.splitlines(), 1) if "return {" in text)
    assert reached.count(f"counter.py:{line}") == 1 + visited
    assert reached.count("counter.py:10=") == sum(number > 3 for number in numbers)


def test_what_a_name_stands_for_once_and_for_all_is_no_data() -> None:
    text = """
import asyncio
from threading import Lock as L
free = 1
class Arm:
    async def move(self):
        await asyncio.sleep(free)
        L().acquire()
        help(self)
def help(arm):
    global free
    free = 2
"""
    points = CodePoints()
    points.instrument("arm.py").visit(ast.parse(text))
    assert [sorted(access.reads | access.writes) for access in points.accesses.values()] == [
        [".sleep", "free"],
        [".acquire"],
        [],
        ["free"],
    ]


@pytest.mark.parametrize("name", LIBRARIES)
def test_examples_of_a_library_with_points_hold(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    reached: set[int] = set()
    for hook, does in ((HOOK, reached.add), (BETWEEN, calculate_written)):
        monkeypatch.setattr(builtins, hook, does, raising=False)
    assert failed_examples(name, CodePoints().instrument("library.py").visit, monkeypatch) == 0
    assert len(reached) > 10
