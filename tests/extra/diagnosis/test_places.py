"""Places: when a statement was executed weighs beside how often failing and passing tests execute it."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.coverage.code_map import SourceFile
from pytest_hricdv.extra.diagnosis.locations import weight_suspects
from pytest_hricdv.extra.diagnosis.spectrum import Suspect
from pytest_hricdv.extra.diagnosis.trace import ExecutedStatement, ViolationTrace

CODE = """\
LIMIT_S = 3.0
OTHER_S = 4.0


def wait(clock):
    clock.sleep(LIMIT_S)


def work(clock):
    clock.begin()
    wait(clock)
    clock.end()
"""
FILES = (SourceFile("code.py", Path("code.py"), (1, 2, 5, 6, 9, 10, 11, 12), (), (), CODE),)


def trace(
    *lines: int, stood: tuple[int, ...] = (), node: int = 0, often: dict[int, int] | None = None
) -> ViolationTrace:
    """Of a run that executed these lines, the last first; each once, or so often."""
    executed = [
        ExecutedStatement(
            file="code.py", line=line, node=node, step=len(lines) - number, time_s=0.0, times=(often or {}).get(line, 1)
        )
        for number, line in enumerate(lines)
    ]
    return ViolationTrace(until_s=1.0, executed=tuple(executed), stood=(tuple(("code.py", line) for line in stood),))


def ranked(suspicious: dict[int, float], *traces: ViolationTrace) -> list[int]:
    """Lines in the order of their suspiciousness."""
    suspects = [Suspect("code.py", line, score, 0) for line, score in suspicious.items()]
    return [suspect.line for suspect in weight_suspects(suspects, traces, FILES)]


def test_what_runs_after_the_violation_only_comes_last() -> None:
    assert ranked({12: 1.0, 10: 0.4}, trace(10)) == [10, 12]


def test_what_is_far_more_suspicious_comes_first_though_it_ran_before() -> None:
    assert ranked({10: 1.0, 6: 0.4}, trace(6, 11, 10)) == [10, 6]


def test_a_branch_that_is_taken_after_the_violation_does_not_count() -> None:
    branching = Suspect("code.py", 11, 1.0, 0, own=0.5, branches=((12, 1.0), (-9, 0.4)))
    plain = Suspect("code.py", 6, 0.6, 0)
    before = ViolationTrace(until_s=1.0, executed=trace(11, 6).executed, branches=(("code.py", 11, 12),))
    after = ViolationTrace(until_s=1.0, executed=trace(11, 6).executed, branches=(("code.py", 11, 0),))
    assert [
        [suspect.line for suspect in weight_suspects([branching, plain], [run], FILES)] for run in (before, after)
    ] == [
        [11, 6],
        [6, 11],
    ]


def test_a_wait_comes_after_what_led_to_it() -> None:
    assert ranked(dict.fromkeys((6, 10, 9), 1.0), trace(6, 10, 9, stood=(6, 11))) == [10, 6, 9]


def test_a_node_that_polls_does_not_hide_the_others() -> None:
    polls = trace(6, 5, 12, stood=(6,), node=1)
    works = trace(10, 9)
    both = ViolationTrace(until_s=1.0, executed=(*polls.executed, *works.executed), stood=())
    assert ranked(dict.fromkeys((6, 5, 12, 10, 9), 1.0), both)[:3] == [6, 5, 10]


def test_what_ran_often_before_without_harm_comes_after_what_ran_once() -> None:
    assert ranked({10: 1.0, 6: 1.0}, trace(6, 10, often={6: 5})) == [10, 6]
    assert ranked({10: 1.0, 6: 1.0}, trace(6, 10, often={6: 5, 10: 4})) == [6, 10]
