"""Virtual time: order, exactness, waking, worlds, failures."""

from __future__ import annotations

import decimal
import math
from collections.abc import Callable, Iterator
from contextvars import ContextVar, copy_context
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.runtime import Kernel, KernelError


@given(st.lists(st.lists(st.integers(0, 3000), max_size=6), min_size=1, max_size=5))
def test_nodes_resume_in_the_order_of_their_due_times(naps_ms: list[list[int]]) -> None:
    kernel = Kernel()
    log: list[tuple[float, int, int]] = []

    def body(number: int, naps: list[int]) -> None:
        for count, nap in enumerate(naps):
            kernel.sleep(nap / 1000)
            log.append((kernel.now_s, number, count))

    for number, naps in enumerate(naps_ms):
        kernel.spawn(str(number), partial(body, number, naps))
    kernel.run(limit_s=1000.0)
    assert [entry[0] for entry in log] == sorted(entry[0] for entry in log)
    for number, naps in enumerate(naps_ms):
        expected = [sum(naps[: count + 1]) / 1000 for count in range(len(naps))]
        assert [time for time, who, _ in log if who == number] == expected


def test_a_node_woken_before_its_timeout_is_not_resumed_again_by_it() -> None:
    kernel = Kernel()
    log: list[tuple[float, bool]] = []

    def sleeper() -> None:
        log.append((kernel.now_s, kernel.block(timeout_s=5.0)))
        woken_at = kernel.now_s
        log.append((woken_at, kernel.block(timeout_s=10.0)))
        log.append((kernel.now_s, False))

    node = kernel.spawn("sleeper", sleeper)

    def waker() -> None:
        kernel.sleep(2.0)
        kernel.wake(node)
        kernel.wake(node)

    kernel.spawn("waker", waker)
    kernel.run(limit_s=100.0)
    assert log == [(0.0, True), (2.0, False), (12.0, False)]


def test_the_limit_ends_a_run_and_a_later_run_continues_from_there() -> None:
    kernel = Kernel()
    ticks: list[float] = []

    def ticker() -> None:
        while True:
            ticks.append(kernel.now_s)
            kernel.sleep(1.0)

    kernel.spawn("ticker", ticker)
    assert kernel.run(limit_s=2.5) == "limit"
    assert ticks == [0.0, 1.0, 2.0]
    assert kernel.now_s == 2.5
    assert kernel.run(limit_s=3.0) == "limit"
    assert ticks == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
def test_an_invalid_duration_is_refused(duration: float) -> None:
    kernel = Kernel()
    kernel.spawn("robot", lambda: kernel.sleep(duration))
    with pytest.raises(KernelError, match="cannot wait for"):
        kernel.run(limit_s=10.0)


def test_blocking_outside_of_a_node_is_refused() -> None:
    with pytest.raises(KernelError, match="only a node may block"):
        Kernel().sleep(1.0)


def test_nodes_that_wake_each_other_endlessly_are_stopped() -> None:
    kernel = Kernel(max_resumes_at_one_instant=1000)

    def spin() -> None:
        while True:
            kernel.sleep(0.0)

    kernel.spawn("spinner", spin)
    with pytest.raises(KernelError, match=r"spinner at 0\.000 s"):
        kernel.run(limit_s=1.0)


class Bell:
    """A world in which a bell rings at given times (us); everything in between is skipped."""

    def __init__(self, kernel: Kernel, rings_us: list[int]) -> None:
        self.kernel = kernel
        self.rings_us = rings_us
        self.heard: list[float] = []
        self.steps: list[int] = []

    def advance(self, target_us: int) -> int:
        while self.rings_us and self.rings_us[0] <= self.kernel.now_us:
            self.rings_us.pop(0)
        reached = min([target_us, *self.rings_us[:1]])
        self.steps.append(reached)
        return reached

    def observe(self) -> None:
        if self.rings_us and self.rings_us[0] == self.kernel.now_us:
            self.heard.append(self.kernel.now_s)
            self.kernel.wake(self.kernel._nodes[0])


def test_the_world_advances_between_waits_and_can_wake_nodes() -> None:
    kernel = Kernel()
    log: list[tuple[float, bool]] = []

    def listener() -> None:
        for _ in range(3):
            woken = kernel.block(timeout_s=2.0)
            log.append((kernel.now_s, woken))

    kernel.spawn("listener", listener)
    kernel.world = Bell(kernel, [500_000, 3_000_000])
    assert kernel.run(limit_s=6.0) == "limit"
    assert log == [(0.5, True), (2.5, False), (3.0, True)]
    assert kernel.now_s == 6.0


def test_a_world_that_does_not_move_is_refused() -> None:
    class Stuck:
        def advance(self, target_us: int) -> int:
            return 0

        def observe(self) -> None: ...

    kernel = Kernel()
    kernel.world = Stuck()
    with pytest.raises(
        KernelError,
        match=r"test_kernel.py:\d+: Stuck.advance, at 0 us .*, returned 0 us; expected",
    ):
        kernel.run(limit_s=1.0)


@pytest.mark.parametrize(
    ("reached", "shown"),
    [(None, "None"), (0.5, "0.5"), ("20000", "'20000'"), (True, "True"), (math.nan, "nan"), ([20000], "[20000]")],
)
def test_a_world_that_returns_no_time_is_named_with_its_line(reached: object, shown: str) -> None:
    class Lift:
        def advance(self, target_us: int) -> int:
            return reached  # type: ignore[return-value]

        def observe(self) -> None:
            pass

    kernel = Kernel()
    kernel.world = Lift()
    kernel.spawn("robot", lambda: kernel.sleep(1.0))
    with pytest.raises(KernelError) as raised:
        kernel.run(2.0)
    line = Lift.advance.__code__.co_firstlineno
    assert str(raised.value).startswith(
        f"{__file__}:{line}: Lift.advance returned {shown}; expected the time that the "
    )


def test_nodes_begin_with_the_context_variables_of_the_program_and_change_their_own() -> None:
    speed: ContextVar[str] = ContextVar("speed")
    seen: list[object] = []

    def robot() -> None:
        seen.extend((speed.get(), decimal.getcontext().prec))
        speed.set("fast")
        decimal.getcontext().prec = 3

    def program() -> None:
        speed.set("slow")
        decimal.getcontext().prec = 7
        for _ in range(2):
            kernel = Kernel()
            kernel.spawn("robot", robot)
            kernel.run(1.0)

    copy_context().run(program)
    assert seen == ["slow", 7, "slow", 7]


async def _coroutine(log: list[str]) -> None:
    log.append("never")


def _generator(log: list[str]) -> Iterator[None]:
    log.append("never")
    yield


@pytest.mark.parametrize("body", [_coroutine, _generator])
def test_a_body_or_a_world_that_only_makes_a_coroutine_or_generator_is_refused_with_its_line(
    body: Callable[[list[str]], object],
) -> None:
    log: list[str] = []
    kernel = Kernel()
    kernel.spawn("arm", lambda: body(log))  # type: ignore[arg-type]
    with pytest.raises(KernelError, match=rf"arm did nothing: .*test_kernel\.py:\d+: {body.__name__} returned a"):
        kernel.run(limit_s=1.0)

    class Lift:
        def advance(self, target_us: int) -> int:
            return target_us

        def observe(self) -> None:
            return body(log)  # type: ignore[return-value]

    kernel = Kernel()
    kernel.world = Lift()
    kernel.spawn("arm", lambda: kernel.sleep(0.5))
    with pytest.raises(KernelError, match=rf"{body.__name__} returned a"):
        kernel.run(limit_s=1.0)
    assert not log


def test_a_generator_that_has_begun_or_ended_may_be_what_is_left_of_a_body() -> None:
    begun, ended = (_generator([]) for _ in range(2))
    next(begun)
    assert list(ended) == [None]
    kernel = Kernel()
    for left in (begun, ended):
        kernel.spawn("arm", lambda left=left: left)  # type: ignore[misc]
    assert kernel.run(limit_s=1.0) == "idle"
