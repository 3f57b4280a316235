"""Robot code that leaves waiting to libraries: each function says what it saw, with the time of the run (s)."""

from __future__ import annotations

import _thread
import asyncio
import concurrent.futures
import functools
import logging
import logging.handlers
import pickle
import queue
import sched
import threading
import time
import timeit
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any
from uuid import UUID, uuid4

import anyio
import attrs
import py_trees
import pybreaker
import pydantic
import tenacity
import transitions
import yaml
from apscheduler.schedulers.background import BackgroundScheduler
from transitions.extensions import states

Say = Callable[[object], None]
PROGRAMS: list[Callable[[Say], None]] = []


def program(function: Callable[[Say], None]) -> Callable[[Say], None]:
    PROGRAMS.append(function)
    return function


def _now() -> float:
    return round(time.monotonic(), 3)


@program
def timeout_of_a_behaviour_tree(say: Say) -> None:
    tree = py_trees.decorators.Timeout("reach", py_trees.behaviours.Running("arm"), duration=1.5)
    while True:
        tree.tick_once()
        if tree.status == py_trees.common.Status.FAILURE:
            break
        time.sleep(0.1)
    say(("failed", 1.5 <= _now() <= 1.7))


@states.add_state_features(states.Timeout)
class _WithTimeouts(transitions.Machine):
    pass


@program
def timeout_of_a_state(say: Say) -> None:
    machine = _WithTimeouts(
        states=["idle", {"name": "waits", "timeout": 3.0, "on_timeout": lambda event: say(("late", _now()))}],
        initial="idle",
        send_event=True,
    )
    machine.to_waits()
    time.sleep(5.0)
    say(("end", _now()))


@program
def retries_with_waits(say: Say) -> None:
    @tenacity.retry(wait=tenacity.wait_fixed(2.0), stop=tenacity.stop_after_delay(7.0))
    def grip() -> None:
        say(("try", _now()))
        raise OSError

    try:
        grip()
    except tenacity.RetryError:
        say(("gave up", _now()))


@program
def circuit_breaker(say: Say) -> None:
    breaker = pybreaker.CircuitBreaker(fail_max=1, reset_timeout=10)

    def grip() -> None:
        raise OSError

    def state_after_a_try() -> str:
        try:
            breaker.call(grip)
        except (OSError, pybreaker.CircuitBreakerError) as error:
            return type(error).__name__
        return ""

    first = state_after_a_try()
    time.sleep(5.0)
    say((first, state_after_a_try()))
    time.sleep(6.0)
    breaker.call(lambda: None)
    say((breaker.current_state, _now()))


@program
def scheduler_of_python(say: Say) -> None:
    plan = sched.scheduler()
    plan.enter(2.0, 1, lambda: say(("b", _now())))
    plan.enter(1.0, 1, lambda: say(("a", _now())))
    plan.run()


@program
def jobs_in_the_background(say: Say) -> None:
    scheduler = BackgroundScheduler(timezone=UTC)
    scheduler.add_job(lambda: say(("job", round(_now()))), "interval", seconds=2)
    scheduler.start()
    time.sleep(5.0)
    scheduler.shutdown()


@program
def sleeping_in_any_loop(say: Say) -> None:
    async def main() -> None:
        with anyio.move_on_after(2.0) as scope:
            await anyio.sleep(10.0)
        say((scope.cancelled_caught, _now()))
        await anyio.to_thread.run_sync(time.sleep, 1.0)
        say(_now())

    anyio.run(main)


@program
def timeout_in_a_coroutine(say: Say) -> None:
    async def main() -> None:
        try:
            async with asyncio.timeout(1.5):
                await asyncio.Event().wait()
        except TimeoutError:
            say(("late", _now()))

    asyncio.run(main())


@program
def pool_with_a_timeout(say: Say) -> None:
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        slow = pool.submit(time.sleep, 4.0)
        try:
            slow.result(timeout=1.0)
        except concurrent.futures.TimeoutError:
            say(("late", _now()))
    say(("done", _now()))


@program
def threads_of_the_lowest_level(say: Say) -> None:
    gate = _thread.allocate_lock()
    gate.acquire()

    def work() -> None:
        time.sleep(0.5)
        say(("thread", _now()))
        gate.release()

    _thread.start_new_thread(work, ())
    say((gate.acquire(True, 3.0), _now()))


@attrs.define
class _Mark:
    number: UUID = attrs.field(factory=uuid4)


class _Stamp(pydantic.BaseModel):
    at: datetime = pydantic.Field(default_factory=datetime.now)
    number: UUID = pydantic.Field(default_factory=uuid4)


class _Report(pydantic.BaseModel):
    marks: list[_Stamp] | None = None


class _Reports(pydantic.BaseModel):
    last: _Report


@program
def factories_of_fields(say: Say) -> None:
    time.sleep(2.0)
    say((timeit.timeit(lambda: time.sleep(0.5), number=4), round(timeit.default_timer(), 3)))
    marks = _Reports.model_validate({"last": {"marks": [{}]}}).last.marks
    assert marks is not None
    marked: list[Any] = [_Mark(), _Stamp(), *marks]
    say([str(each.number)[:4] for each in marked])
    say([str(each.at.time()) for each in (_Stamp.model_validate({}), *marks)])


class _Once:
    """Has a lock that was made when the module was imported."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.inside = 0

    def enter(self) -> int:
        with self.lock:
            self.inside += 1
            time.sleep(1.0)
            self.inside -= 1
            return self.inside


_ONCE = _Once()


@functools.singledispatch
def _kind(value: object) -> str:
    return "other"


@_kind.register
def _(value: datetime) -> str:
    return "moment"


class _Moment(datetime):
    """Its layout is that of a type in C, whose base cannot be replaced."""

    def half(self) -> str:
        return "am" if self.hour < 12 else "pm"


@program
def moments_of_every_kind(say: Say) -> None:
    moment = datetime(2020, 1, 2, tzinfo=UTC)
    say((_kind(moment), _kind(datetime.now(UTC)), type(moment).__module__, issubclass(type(moment), datetime)))
    say(yaml.safe_dump([datetime(2020, 1, 2), yaml.safe_load("2020-01-03")]))
    time.sleep(60.0)
    say((str(_Moment.now(UTC)), _Moment.now().half(), pickle.loads(pickle.dumps(moment)) == moment))


class _Own(threading.local):
    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def add(self) -> int:
        self.count += 1
        return self.count


_OWN, _PLAIN = _Own(), threading.local()


@program
def values_of_each_thread(say: Say) -> None:
    def work(number: int) -> None:
        _PLAIN.number = number
        _OWN.add()
        time.sleep(1.0)
        say((_OWN.add(), _PLAIN.number))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    say((_OWN.count, hasattr(_PLAIN, "number")))


@program
def clocks_of_the_system(say: Say) -> None:
    began_s = time.clock_gettime(time.CLOCK_MONOTONIC)
    time.sleep(61.0)
    say(round(time.clock_gettime(time.CLOCK_MONOTONIC) - began_s, 3))
    say((time.strftime("%H:%M:%S"), time.localtime().tm_min, time.ctime()))


@program
def lock_of_an_object_of_the_module(say: Say) -> None:
    threads = [threading.Thread(target=lambda: say(_ONCE.enter())) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    say(_now())


@program
def log_that_another_thread_writes(say: Say) -> None:
    class Writer(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            time.sleep(0.5)
            say((record.getMessage(), _now()))

    records: queue.Queue[Any] = queue.Queue()
    listener = logging.handlers.QueueListener(records, Writer())
    listener.start()
    for text in ("moves", "rests"):
        logging.handlers.QueueHandler(records).handle(logging.makeLogRecord({"msg": text}))
    listener.stop()
    say(_now())
