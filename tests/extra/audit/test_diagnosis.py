"""Causes are found by experiments: on simulated code, of which the cause is known."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.audit.diagnosis import CauseSearch, RepeatCause
from pytest_hricdv.extra.audit.process import RerunAnswer, RerunOrder
from pytest_hricdv.extra.audit.sources import CLOCK, RANDOM, Reading

ASKED = "asked"

Code = Callable[[RerunOrder, str, int, Mapping[str, str]], object]
"""What a run comes to: of an order, the hash seed, the process, and variables."""


@dataclass
class SimulatedProcesses:
    """What processes would answer, if the code under test were this."""

    code: Code
    readings: tuple[Reading, ...] = ()
    ran: list[RerunOrder] = field(default_factory=list)

    def run(
        self,
        order: RerunOrder,
        hash_seed: str,
        *,
        copy: int = 0,
        variables: Mapping[str, str] | None = None,
        among: Sequence[str] = (),
    ) -> RerunAnswer:
        assert not among or set(order.nodeids) <= set(among)
        self.ran.append(order)
        came_to = self.code(order, hash_seed, copy, variables or {})
        return RerunAnswer(problem=repr(came_to), readings=self.readings if order.watched else ())


def cause(
    processes: SimulatedProcesses,
    *,
    in_process: Sequence[str] = (ASKED,),
    session_seed: str = "",
    was_in_worker: bool = False,
    changed: Mapping[str, str] | None = None,
    seconds: float = 60.0,
) -> RepeatCause:
    """What is found of a test that came otherwise in the session."""
    alone = processes.run(RerunOrder((ASKED,)), "1")
    return CauseSearch(
        processes,  # type: ignore[arg-type]
        ASKED,
        (None, "in the session"),
        alone,
        hash_seed="1",
        session_seed=session_seed,
        in_process=in_process,
        changed=changed or {},
        was_in_worker=was_in_worker,
        until_s=time.monotonic() + seconds,
    ).cause()


def names(number: int) -> list[str]:
    """Of tests before the one that is asked about, and itself."""
    return [*(f"t{place}" for place in range(number)), ASKED]


@given(st.integers(1, 900).flatmap(lambda size: st.tuples(st.just(size), st.integers(0, size - 1))))
def test_the_one_test_that_leaves_state_is_found_in_few_runs(case: tuple[int, int]) -> None:
    size, culprit = case
    processes = SimulatedProcesses(lambda order, *_: f"t{culprit}" in order.nodeids)
    found = cause(processes, in_process=names(size))
    assert found.left_by == f"t{culprit}"
    assert found.name == f"state that t{culprit} leaves"
    assert len(processes.ran) <= 8 + 2 * math.ceil(math.log2(size + 1))


def test_state_that_takes_two_tests_is_said_to() -> None:
    processes = SimulatedProcesses(lambda order, *_: {"t2", "t5"} <= {*order.nodeids})
    found = cause(processes, in_process=names(8))
    assert found.left_by == "t2"
    assert "after t2 and the 5 tests after that" in found.detail


@pytest.mark.parametrize("session_seed", ["", "0"])
def test_hash_order(session_seed: str) -> None:
    found = cause(SimulatedProcesses(lambda order, seed, *_: int(seed) % 2), session_seed=session_seed)
    assert found.name == "hash order"


def test_a_source_that_stands_still_in_two_runs_that_agree() -> None:
    number = count()
    processes = SimulatedProcesses(
        lambda order, *_: 0 if CLOCK in order.still else next(number),
        (Reading(RANDOM, "os.urandom", "a.py:1"), Reading(CLOCK, "time.time", "b.py:2")),
    )
    found = cause(processes)
    assert found.name == "wall clock"
    assert "time.time at b.py:2" in found.detail
    assert "a.py" not in found.detail


def test_chance_that_nothing_explains_is_said_with_what_was_read() -> None:
    number = count()
    processes = SimulatedProcesses(lambda *_: next(number), (Reading("threads", "_thread.start", "c.py:3"),))
    found = cause(processes)
    assert found.name == "threads"
    assert "c.py:3" in found.detail


def test_a_file_without_which_it_runs_otherwise() -> None:
    processes = SimulatedProcesses(
        lambda order, *_: "/p/left.txt" in order.hidden,
        (Reading("files", "open", "d.py:4", "/p/other.txt"), Reading("files", "open", "d.py:5", "/p/left.txt")),
    )
    found = cause(processes, changed={"/p/left.txt": "t1", "/p/other.txt": ""})
    assert (found.name, found.left_by) == ("file left behind: left.txt", "t1")


def test_a_counter_in_a_file_anywhere_and_a_device_of_the_system() -> None:
    number = count()
    readings = (Reading("files", "open", "d.py:4", "/dev/urandom"), Reading("files", "open", "d.py:5", "/var/count"))
    counting = SimulatedProcesses(lambda order, *_: 0 if "/var/count" in order.hidden else next(number), readings)
    assert cause(counting).name == "file left behind: count"
    drawing = SimulatedProcesses(lambda order, *_: 0 if "/dev/urandom" in order.hidden else next(number), readings)
    assert cause(drawing).name == "files"
