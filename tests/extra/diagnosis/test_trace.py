"""A traced run: what it executed up to a time, the last first, and where each of its nodes stood then."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import greenlet
import pytest

from pytest_hricdv.coverage.code_map import CodeMap, SourceFile
from pytest_hricdv.extra.diagnosis.trace import Tracer, ViolationTrace

CODE = """\
def inner(number):
    result = number
    wait()
    return result
def outer():
    for number in (1, 2):
        inner(
            number)
    return 1
"""


class Clock:
    """Stands for the code under test, as far as tracing asks it."""

    now_s = 0.0
    raised: BaseException | None = None


@pytest.fixture
def traced(tmp_path: Path) -> Callable[[float], ViolationTrace]:
    """The code has run in a node that waited twice, for a second each."""
    path = tmp_path / "code.py"
    file = SourceFile("code.py", path, (1, 2, 3, 4, 5, 6, 7, 9), (), (), CODE)
    tracing, clock, home = Tracer(CodeMap((), (file,), "")), Clock(), greenlet.getcurrent()
    tracing.begin(clock)  # type: ignore[arg-type]

    def wait() -> None:
        home.switch()
        clock.now_s += 1.0
        if clock.now_s == 2.0:  # what the code does after this is done at the same time
            tracing.signal(2.0, "moves", True)
            tracing.message(2.0, "state", {})

    names: dict[str, Callable[[], None]] = {"wait": wait}
    exec(compile(CODE, str(path), "exec"), names)
    node = greenlet.greenlet(tracing.measure("", names["outer"]))
    while not node.dead:
        node.switch()
    tracing.settle()
    return tracing.until


@pytest.mark.parametrize(
    ("time_s", "executed", "stood"),
    [
        (0.5, [(3, 1), (2, 1), (7, 2), (6, 1)], ((("code.py", 3), ("code.py", 7)),)),
        (1.5, [(3, 2), (2, 2), (7, 4), (6, 2), (4, 1)], ((("code.py", 3), ("code.py", 7)),)),
        (9.0, [(9, 1), (6, 3), (4, 2), (3, 2), (2, 2), (7, 4)], ((),)),
    ],
)
def test_a_trace_ends_at_a_time(
    traced: Callable[[float], ViolationTrace],
    time_s: float,
    executed: list[tuple[int, int]],
    stood: tuple[tuple[tuple[str, int], ...], ...],
) -> None:
    trace = traced(time_s)
    assert [statement.line for statement in trace.executed] == [line for line, _ in executed]
    assert [statement.times for statement in trace.executed if statement.line != 7] == [
        times for line, times in executed if line != 7
    ]  # the line 7 counts once or twice, as its argument is on a line of its own
    assert trace.stood == stood


@pytest.mark.parametrize(("names", "is_whole"), [(None, False), ({"state"}, False), ({"moves"}, False), ({"x"}, True)])
def test_a_trace_ends_at_the_event_that_violates_what_reads_it(
    traced: Callable[..., ViolationTrace], names: set[str] | None, is_whole: bool
) -> None:
    lines = [statement.line for statement in traced(2.0, names).executed]
    assert lines == ([9, 6, 4, 3, 2, 7] if is_whole else [3, 2, 7, 6, 4])


def test_what_is_wrong_with_a_whole_run_has_all_that_was_executed(traced: Callable[..., ViolationTrace]) -> None:
    whole = traced(1.999, None, to_end=True)  # the end of a run, rounded down
    assert [statement.line for statement in whole.executed] == [9, 6, 4, 3, 2, 7]
    assert not whole.is_said


def test_the_statement_that_raised_is_the_innermost_of_the_code_under_test(tmp_path: Path) -> None:
    path = tmp_path / "code.py"
    file = SourceFile("code.py", path, (1, 2, 3, 4, 5, 6, 7, 9), (), (), CODE)
    tracing, code = Tracer(CodeMap((), (file,), "")), Clock()
    tracing.begin(code)  # type: ignore[arg-type]

    def wait() -> None:
        raise SystemExit(0)

    names: dict[str, Callable[[], None]] = {"wait": wait}
    exec(compile(CODE, str(path), "exec"), names)
    with pytest.raises(SystemExit) as raised:
        names["outer"]()
    code.raised = raised.value
    assert tracing.until(0.0, None, to_end=True).raised == ("code.py", 3)
    assert tracing.until(0.0).raised is None
