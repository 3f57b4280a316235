"""Libraries that the code under test uses wait in virtual time, too, though they are not named as its code."""

from __future__ import annotations

import concurrent.futures
import time
from collections.abc import Callable

import msgspec
import pytest

from pytest_hricdv.runtime.kernel import Kernel
from pytest_hricdv.runtime.node_error import NodeError
from pytest_hricdv.runtime.virtual import VirtualModules
from pytest_hricdv.runtime.virtual.outside import guard_run
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError
from tests.runtime.virtual import library_programs

SEEN: dict[str, list[object]] = {
    "timeout_of_a_behaviour_tree": [("failed", True)],
    "timeout_of_a_state": [("late", 3.0), ("end", 5.0)],
    "retries_with_waits": [*[("try", 2.0 * n) for n in range(5)], ("gave up", 8.0)],
    "circuit_breaker": [("CircuitBreakerError", "CircuitBreakerError"), ("closed", 11.0)],
    "scheduler_of_python": [("a", 1.0), ("b", 2.0)],
    "jobs_in_the_background": [("job", 2), ("job", 4)],
    "sleeping_in_any_loop": [(True, 2.0), 3.0],
    "timeout_in_a_coroutine": [("late", 1.5)],
    "pool_with_a_timeout": [("late", 1.0), ("done", 4.0)],
    "threads_of_the_lowest_level": [("thread", 0.5), (True, 0.5)],
    "clocks_that_were_handed_over": [(2.0, 3.0, 2.0), (2.0, 2.0)],
    "factories_of_fields": [(2.0, 4.0), (4.0, 4.0, 4.0), 4.0],
    "moments_of_every_kind": [
        ("moment", "moment", "datetime", True),
        "- 2020-01-02 00:00:00\n- 2020-01-03\n",
        ("2000-01-01 00:01:00+00:00", "am", True),
    ],
    "values_of_each_thread": [(2, 0), (2, 1), (0, False)],
    "clocks_of_the_system": [61.0, ("00:01:01", 1, "Sat Jan  1 00:01:01 2000")],
    "lock_of_an_object_of_the_module": [0, 0, 0, 3.0],
    "log_that_another_thread_writes": [("moves", 0.5), ("rests", 1.0), 1.0],
}
"""What each program sees."""


def run_in_virtual_time(body: Callable[[Callable[[object], None]], None]) -> list[object]:
    """Run a node as a session does; returns what it said."""
    said: list[object] = []
    kernel = Kernel()
    kernel.virtual = frozenset(("time", "threading", "asyncio"))
    modules = VirtualModules([library_programs.__name__])
    kernel.code = modules.packages

    def robot() -> None:
        body(said.append)
        kernel.stop("over")

    kernel.spawn("robot", robot)
    with modules.install(), guard_run(kernel):
        assert kernel.run(1000.0) == "over"
    return said


@pytest.mark.parametrize("body", library_programs.PROGRAMS, ids=lambda body: body.__name__)
def test_what_a_library_waits_for_passes_in_virtual_time(body: Callable[..., None]) -> None:
    began_s = time.monotonic()
    for _ in range(2):  # what one run leaves is not in the next
        assert run_in_virtual_time(body) == SEEN[body.__name__]
    assert time.monotonic() - began_s < 30.0
    assert type(library_programs._Moment.now()) is library_programs._Moment
    assert library_programs._Moment.now().year > 2000  # outside of runs, all is real again


def test_a_factory_that_nothing_can_replace_is_refused_with_its_class(monkeypatch: pytest.MonkeyPatch) -> None:
    class Mark(msgspec.Struct):
        at_s: float = msgspec.field(default_factory=time.monotonic)

    Mark.__module__ = library_programs.__name__
    monkeypatch.setattr(library_programs, "Mark", Mark, raising=False)
    with pytest.raises(ProhibitedError, match=r"library_programs\.Mark: msgspec keeps time\.monotonic"):
        run_in_virtual_time(lambda say: say(Mark().at_s))


def test_a_pool_of_processes_is_refused_with_its_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library_programs, "Pool", concurrent.futures.ProcessPoolExecutor, raising=False)
    with pytest.raises(NodeError, match=r"test_libraries\.py:\d+: ProcessPoolExecutor in node robot"):
        run_in_virtual_time(lambda say: say(vars(library_programs)["Pool"](1)))
    assert vars(library_programs)["Pool"] is concurrent.futures.ProcessPoolExecutor
