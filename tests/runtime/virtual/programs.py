"""Programs with threads, which say what happens: each says the same with Python's own threads as in virtual time.

Each is a function of the modules that it uses. Its waits are multiples of `tick_s`, and nothing that matters happens at
the same tick in two threads, so that real threads have one outcome, too.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from types import ModuleType
from typing import Any

Program = Callable[["Library", Callable[[object], None]], None]


@dataclass(frozen=True)
class Library:
    """The modules, real or virtual."""

    threading: ModuleType
    queue: ModuleType
    futures: ModuleType
    time: ModuleType
    tick_s: float = 0.02

    def sleep(self, ticks: float) -> None:
        self.time.sleep(ticks * self.tick_s)

    def start(self, function: Callable[[], object]) -> Any:
        thread = self.threading.Thread(target=function)
        thread.start()
        return thread


def producer_and_consumer(lib: Library, say: Callable[[object], None]) -> None:
    jobs = lib.queue.Queue(maxsize=2)

    def produce() -> None:
        for number in range(4):
            jobs.put(number)
            say(f"put {number}")
        jobs.put(None)

    thread = lib.start(produce)
    while True:
        lib.sleep(2)
        job = jobs.get()
        lib.sleep(1)
        say(f"took {job}")
        jobs.task_done()
        if job is None:
            break
    jobs.join()
    thread.join()
    say(thread.is_alive())


def time_outs(lib: Library, say: Callable[[object], None]) -> None:
    event, lock, jobs = lib.threading.Event(), lib.threading.Lock(), lib.queue.PriorityQueue()
    say(event.wait(lib.tick_s))
    lock.acquire()
    say(lock.acquire(timeout=lib.tick_s))
    say(lock.acquire(blocking=False))
    try:
        jobs.get(timeout=lib.tick_s)
    except lib.queue.Empty:
        say("empty")
    jobs.put(2)
    jobs.put(1)
    say((jobs.get(), jobs.get_nowait(), jobs.empty()))

    def wait() -> None:
        event.wait()
        say("released")

    thread = lib.start(wait)
    thread.join(timeout=lib.tick_s)
    say(thread.is_alive())
    event.set()
    thread.join()
    say(event.is_set())


def who_came_first(lib: Library, say: Callable[[object], None]) -> None:
    lock = lib.threading.RLock()

    def worker(number: int) -> None:
        lib.sleep(2 * number)
        with lock, lock:
            say(f"{number} has it")
            lib.sleep(7)

    threads = [lib.start(lambda number=number: worker(number)) for number in range(3)]  # type: ignore[misc]
    for thread in threads:
        thread.join()


def condition(lib: Library, say: Callable[[object], None]) -> None:
    changed, level = lib.threading.Condition(), [0]

    def filler() -> None:
        for _ in range(3):
            lib.sleep(2)
            with changed:
                level[0] += 1
                changed.notify_all()

    lib.start(filler)
    with changed:
        say(changed.wait_for(lambda: level[0] >= 2, timeout=20 * lib.tick_s))
        say(level[0])
        say(changed.wait_for(lambda: level[0] >= 9, timeout=4 * lib.tick_s))
    try:
        changed.notify()
    except RuntimeError as error:
        say(str(error))


def timers(lib: Library, say: Callable[[object], None]) -> None:
    late = lib.threading.Timer(6 * lib.tick_s, say, ["late"])
    never = lib.threading.Timer(4 * lib.tick_s, say, ["never"])
    soon = lib.threading.Timer(lib.tick_s, say, kwargs=None, args=("soon",))
    for timer in (late, never, soon):
        timer.start()
    lib.sleep(2)
    never.cancel()
    late.join()
    say([timer.is_alive() for timer in (late, never, soon)])


def semaphores_and_barriers(lib: Library, say: Callable[[object], None]) -> None:
    places, gate = lib.threading.BoundedSemaphore(2), lib.threading.Barrier(3)

    def guest(number: int) -> None:
        lib.sleep(number)
        with places:
            say(f"{number} in")
            lib.sleep(6)
        lib.sleep(2 * number)
        gate.wait()

    threads = [lib.start(lambda number=number: guest(number)) for number in range(1, 4)]  # type: ignore[misc]
    for thread in threads:
        thread.join()
    say((gate.broken, gate.n_waiting))
    try:
        places.release()
    except ValueError as error:
        say(str(error))


def own_class(lib: Library, say: Callable[[object], None]) -> None:
    local = lib.threading.local()
    local.name = "main"

    class Worker(lib.threading.Thread):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            super().__init__(name="worker", daemon=True)

        def run(self) -> None:
            say(hasattr(local, "name"))
            local.name = "worker"
            say(lib.threading.current_thread() is self)
            say((self.name, self.daemon, lib.threading.main_thread() is self))
            lib.sleep(2)

    worker = Worker()
    say(worker.is_alive())
    worker.start()
    lib.sleep(1)
    say((worker in lib.threading.enumerate(), local.name))
    worker.join()
    say(worker in lib.threading.enumerate())
    for misuse in (worker.start, lib.threading.current_thread().join, lib.threading.Thread().join):
        try:
            misuse()
        except RuntimeError as error:
            say(str(error))


def thread_pool(lib: Library, say: Callable[[object], None]) -> None:
    def work(ticks: int) -> int:
        lib.sleep(ticks)
        say(f"worked {ticks}")
        return 12 // (ticks - 4)

    with lib.futures.ThreadPoolExecutor(max_workers=2) as pool:
        say(list(pool.map(work, [1, 2, 3])))
        futures = [pool.submit(work, ticks) for ticks in (9, 1, 2)]
        try:
            futures[0].result(timeout=lib.tick_s / 2)
        except lib.futures.TimeoutError:
            say("not yet")
        done, left = lib.futures.wait(futures, return_when=lib.futures.FIRST_COMPLETED)
        say((len(done), len(left)))
        say([future.result() for future in lib.futures.as_completed(futures)])
        failing = pool.submit(work, 4)
        say(type(failing.exception()))
    try:
        pool.submit(work, 1)
    except RuntimeError as error:
        say(str(error))


def odd_durations(lib: Library, say: Callable[[object], None]) -> None:
    """What is neither a float nor an integer is no duration."""
    for odd in (Decimal("0.01"), Fraction(1, 100), "0.01", None, 0.01j, [1]):
        try:
            lib.time.sleep(odd)
        except TypeError as error:
            say(type(error))
        else:
            say(odd)
    try:
        say(lib.threading.Event().wait(Decimal("0.01")))
    except TypeError as error:
        say(type(error))
    say(lib.time.sleep(False))


def wrong_use(lib: Library, say: Callable[[object], None]) -> None:
    """What Python refuses is refused by the same kind of error."""
    threading, lock = lib.threading, lib.threading.Lock()
    begun = lib.start(lambda: None)
    begun.join()
    for wrong in (
        lock.release,
        lambda: lock.acquire(False, 1),
        lambda: lock.acquire(timeout=-2),
        lambda: lock.acquire(timeout=1e12),
        lambda: threading.RLock().acquire(False, 0.5),
        threading.RLock().release,
        lambda: threading.Event().wait(1e12),
        lambda: threading.Semaphore().acquire(blocking=False, timeout=1),
        threading.BoundedSemaphore(1).release,
        begun.start,
        lambda: threading.Thread(group=1),
        lambda: lib.time.sleep(1e12),
        lambda: lib.queue.Queue().get(timeout=-1),
    ):
        try:
            say(wrong())
        except Exception as error:
            say(type(error))
    say((lock.acquire(timeout=-1), lock.locked()))


def copies_and_texts(lib: Library, say: Callable[[object], None]) -> None:
    for name in ("Lock", "RLock", "Event", "Condition", "Semaphore"):
        try:
            copy.deepcopy({name: getattr(lib.threading, name)()})
        except TypeError as error:
            say(str(error).startswith("cannot pickle '_thread."))
    event, lock = lib.threading.Event(), lib.threading.Lock()
    say((": unset>" in repr(event), repr(lock).partition(" ")[0]))
    event.set()
    lock.acquire()
    say((": set>" in repr(event), repr(lock).partition(" ")[0]))
    thread = lib.threading.Thread(target=lambda: lib.sleep(1))
    thread.daemon = True
    thread.start()
    try:
        thread.daemon = False
    except RuntimeError as error:
        say(str(error))
    thread.join()
    with lib.futures.ThreadPoolExecutor(1) as pool:
        try:
            list(lib.futures.as_completed([pool.submit(lib.sleep, 3), pool.submit(int)], lib.tick_s))
        except TimeoutError as error:
            say(str(error))


PROGRAMS: tuple[Program, ...] = (
    producer_and_consumer,
    time_outs,
    who_came_first,
    condition,
    timers,
    semaphores_and_barriers,
    own_class,
    thread_pool,
    odd_durations,
    wrong_use,
    copies_and_texts,
)
