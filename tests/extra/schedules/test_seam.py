"""What the kernel, locks, event loops and the bus leave to a schedule."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from pytest_hricdv.runtime import Bus, Kernel, Recorder, Subscription
from pytest_hricdv.runtime.virtual import asyncio_functions, threads
from pytest_hricdv.runtime.virtual.deadlocks import find_endless_waits
from pytest_hricdv.runtime.virtual.locks import Condition, Event, Lock

QUEUE: Any = next(module for module in threads.MODULES if module.__name__ == "queue")
ASYNCIO: Any = asyncio_functions.MODULES[0]


@dataclass(frozen=True)
class Go:
    number: int


@dataclass(frozen=True)
class Stop:
    number: int


def run(kernel: Kernel, *bodies: Callable[[], object]) -> None:
    kernel.virtual = frozenset({"threading", "asyncio"})
    for number, body in enumerate(bodies):
        kernel.spawn(f"node {number}", body)  # type: ignore[arg-type]
    kernel.run(10.0)


def picking(kernel: Kernel, wanted: int, chosen: int) -> list[int]:
    """Lets another one go first, of so many."""
    counts: list[int] = []

    def pick(count: int) -> int:
        counts.append(count)
        return chosen if count == wanted else 0

    kernel.pick = pick
    return counts


@pytest.mark.parametrize(("chosen", "order"), [(0, "abc"), (1, "bac"), (2, "cab")])
def test_another_waiter_gets_a_lock(chosen: int, order: str) -> None:
    kernel, lock, got = Kernel(), Lock(), []

    def keep() -> None:
        with lock:
            kernel.sleep(1.0)

    def wait(name: str) -> None:
        kernel.sleep(0.1 + "abc".index(name) / 100)
        with lock:
            got.append(name)

    picking(kernel, 3, chosen)
    run(kernel, keep, *(lambda name=name: wait(name) for name in "abc"))
    assert "".join(got) == order


def test_another_waiter_gets_an_item_of_a_queue() -> None:
    kernel, items, got = Kernel(), QUEUE.Queue(), []

    def put() -> None:
        kernel.sleep(1.0)
        items.put("cup")

    picking(kernel, 2, 1)
    run(kernel, lambda: got.append(("a", items.get())), lambda: got.append(("b", items.get())), put)
    assert got == [("b", "cup")]


@pytest.mark.parametrize("chosen", [0, 1])
def test_of_timers_that_are_due_together_another_one_goes_first(chosen: int) -> None:
    kernel, got = Kernel(), []

    async def wait(name: str, times: int) -> None:
        for _ in range(times):
            await asyncio.sleep(1.0 / times)
        got.append(name)

    async def main() -> None:
        await asyncio.gather(wait("a", 2), wait("b", 1))

    picking(kernel, 2, 0)
    run(kernel, lambda: ASYNCIO.run(main()))
    usual, got, kernel = got, [], Kernel()
    picking(kernel, 2, chosen)
    run(kernel, lambda: ASYNCIO.run(main()))
    assert (got == usual) is not bool(chosen)


def test_a_late_message_is_overtaken_by_other_topics_only() -> None:
    kernel = Kernel()
    bus, got = Bus(kernel, (Go, Stop), Recorder()), []
    delays_s = iter((0.03, 0.0, 0.03))
    bus.transport = lambda sender, topic: next(delays_s)

    def hear(kind: type[Any]) -> None:
        messages: Subscription[Any] = bus.subscribe(kind)
        while (message := messages.wait(5.0)) is not None:
            got.append((message, round(kernel.now_s, 3)))

    def talk() -> None:
        kernel.sleep(1.0)
        for message in (Go(1), Stop(1), Go(2)):
            bus.publish("person", message)

    run(kernel, lambda: hear(Go), lambda: hear(Stop), talk)
    assert got == [(Stop(1), 1.0), (Go(1), 1.03), (Go(2), 1.03)]


def test_who_waits_without_end_is_found_with_what_it_missed() -> None:
    kernel, lock, ready, more = Kernel(), Lock(), Event(), Condition()

    def keep() -> None:
        lock.acquire()
        ready.set()
        ready.clear()
        with more:
            more.notify()

    def wait(what: Callable[[], object]) -> None:
        kernel.sleep(2.0)
        what()

    def wait_for_more() -> None:
        with more:
            more.wait()

    run(kernel, keep, lambda: wait(lock.acquire), lambda: wait(ready.wait), lambda: wait(wait_for_more))
    waits = [(wait.node, wait.since_s, wait.holder, wait.unheard_s) for wait in find_endless_waits(kernel.nodes)]
    kernel.close()
    assert waits == [("node 1", 2.0, "node 0", None), ("node 2", 2.0, None, 0.0), ("node 3", 2.0, None, 0.0)]


def test_an_idle_worker_does_not_wait_without_end_and_a_line_is_alike_on_all_machines() -> None:
    kernel, jobs = Kernel(), QUEUE.Queue()
    run(kernel, jobs.get, lambda: jobs.get())  # the first is as a pool's worker: no line of it is its author's
    waits = [*find_endless_waits(kernel.nodes)]
    kernel.close()
    assert [wait.node for wait in waits] == ["node 1"]
    assert waits[0].place.startswith("tests/extra/schedules/test_seam.py:")
