"""Libraries that the code under test uses wait in virtual time, too, though they are not named as its code."""

from __future__ import annotations

import concurrent.futures
import datetime
import importlib.util
import queue
import sys
import threading
import time
import uuid
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import msgspec
import pytest

from pytest_hricdv.runtime.kernel import Kernel
from pytest_hricdv.runtime.node_error import NodeError
from pytest_hricdv.runtime.virtual import VirtualModules, clocks
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
    "factories_of_fields": [(2.0, 4.0), ["6b86", "d473", "5fec"], ["00:00:04", "00:00:04"]],
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


def run_in_virtual_time(body: Callable[[Callable[[object], None]], None], *further: str) -> list[object]:
    """Run a node as a session does; returns what it said."""
    said: list[object] = []
    kernel = Kernel()
    kernel.virtual = frozenset(("time", "threading", "asyncio"))
    modules = VirtualModules([library_programs.__name__, *further])
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
        number: uuid.UUID = msgspec.field(default_factory=uuid.uuid4)

    Mark.__module__ = library_programs.__name__
    monkeypatch.setattr(library_programs, "Mark", Mark, raising=False)
    with pytest.raises(ProhibitedError, match=r"library_programs\.Mark: msgspec keeps uuid\.uuid4"):
        run_in_virtual_time(lambda say: say(Mark().number))


def test_a_pool_of_processes_is_refused_with_its_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library_programs, "Pool", concurrent.futures.ProcessPoolExecutor, raising=False)
    with pytest.raises(NodeError, match=r"test_libraries\.py:\d+: ProcessPoolExecutor in node robot"):
        run_in_virtual_time(lambda say: say(vars(library_programs)["Pool"](1)))
    assert vars(library_programs)["Pool"] is concurrent.futures.ProcessPoolExecutor


@pytest.mark.parametrize("shared", [queue.Queue(), threading.Lock(), threading.Event(), threading.local()])
def test_modules_that_share_an_object_share_what_stands_for_it(monkeypatch: pytest.MonkeyPatch, shared: object) -> None:
    other = ModuleType("tests.runtime.virtual.other")
    monkeypatch.setitem(sys.modules, other.__name__, other)
    modules = (other, library_programs)
    for module in modules:
        monkeypatch.setattr(module, "SHARED", shared, raising=False)
    seen: list[object] = []
    for _ in range(2):  # another one in each run
        run_in_virtual_time(lambda _: seen.extend(vars(module)["SHARED"] for module in modules), other.__name__)
    assert seen[0] is seen[1] is not shared
    assert seen[2] is seen[3] is not seen[0]
    assert vars(other)["SHARED"] is shared


def test_conditions_of_one_lock_stay_conditions_of_one_lock(monkeypatch: pytest.MonkeyPatch) -> None:
    lock = threading.Lock()
    for name, value in (("LOCK", lock), ("FULL", threading.Condition(lock)), ("EMPTY", threading.Condition(lock))):
        monkeypatch.setattr(library_programs, name, value, raising=False)

    def body(say: Callable[[object], None]) -> None:
        with vars(library_programs)["LOCK"]:
            vars(library_programs)["FULL"].notify()
        with vars(library_programs)["FULL"]:
            vars(library_programs)["EMPTY"].notify_all()
            say(vars(library_programs)["LOCK"].locked())

    assert run_in_virtual_time(body) == [True]


def test_a_module_that_is_loaded_from_a_file_waits_in_virtual_time(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "by_path.py"
    file.write_text("import threading\n\n\ndef rest(wait=threading.Event().wait):\n    wait(0.25)\n", encoding="utf-8")
    spec = importlib.util.spec_from_file_location("by_path", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(library_programs, "by_path", module, raising=False)

    def body(say: Callable[[object], None]) -> None:
        began_s = vars(library_programs)["time"].monotonic()
        module.rest()
        say(round(vars(library_programs)["time"].monotonic() - began_s, 3))

    assert run_in_virtual_time(body) == [0.25]


KEPT = {
    "as_method_of_an_event": "rest = threading.Event().wait",
    "as_method_of_a_queue": """
get = queue.Queue().get
def rest(wait_s):
    try:
        get(timeout=wait_s)
    except queue.Empty:
        pass
""",
    "of_a_lock_in_holders": """
lock = threading.Lock()
waits = {lock: 0.25}
class Ways(dict):
    pass
class Also(list):
    pass
class Closed(type):
    def __getattribute__(kind, name):
        assert name != "__dict__", "whoever asks for attributes would run code of a metaclass"
        return super().__getattribute__(name)
class Robot(metaclass=Closed):
    lock, take = (lock,), staticmethod(lock.acquire)
named = collections.namedtuple("Named", "lock")(lock)
queued, own = collections.deque([lock]), Ways(ways=Also([lock]))
every, frozen = {lock}, frozenset([lock])
chain = types.SimpleNamespace(chain=collections.ChainMap({"lock": weakref.ref(lock)}))
told = functools.partial(functools.partial(list, (lock,)))
def rest(wait_s, kept=lock):
    held = (kept, *Robot.lock, named.lock, queued[0], own["ways"][0], *every, *frozen, *told(), *waits)
    assert {chain.chain["lock"](), *held} == {lock} and waits[lock] == wait_s
    Robot.take()
    assert lock.locked() and not lock.acquire(timeout=wait_s)
""",
    "as_key": """
ways = {time.sleep: "slow"}
def rest(wait_s):
    assert ways[time.sleep] == "slow"
    for sleep, name in ways.items():
        sleep(wait_s)
""",
    "as_value_of_an_enumeration": """
import enum
class Way(enum.Enum):
    SLOW = (time.sleep, 2)
def rest(wait_s):
    assert Way((time.sleep, 2)) is Way.SLOW
    Way.SLOW.value[0](wait_s)
""",
    "as_pool_timer_and_thread": """
from concurrent.futures import ThreadPoolExecutor
ready, begun = threading.Event(), []
pool = ThreadPoolExecutor(1, "motor", begun.append, (1,))
timer, thread = threading.Timer(0.125, ready.set), threading.Thread(target=time.sleep, args=(0.125,), name="nap")
def rest(wait_s):
    timer.start()
    assert ready.wait(5) and thread.name == "nap"
    thread.start()
    thread.join()
    assert pool.submit(lambda: threading.current_thread().name).result().startswith("motor")
    assert begun.pop() == 1
""",
    "as_method_of_an_event_in_a_tuple": """
ready = (threading.Event(),)
waits = (ready[0].wait,)
def rest(wait_s):
    waits[0](wait_s)
    assert ready[0].wait(0) is False
""",
    "in_a_generator": """
def every(sleep):
    while True:
        yield sleep
ways = every(time.sleep)
next(ways)
def rest(wait_s):
    next(ways)(wait_s)
""",
    "in_a_registry": """
rest = functools.singledispatch(print)
rest.register(float, time.sleep)
""",
    "as_text_of_pickle": """
import pickle
text = pickle.dumps(time.sleep)
def rest(wait_s):
    assert pickle.loads(pickle.dumps(time.sleep)) is pickle.loads(text) is time.sleep
    pickle.loads(text)(wait_s)
    assert repr(time.sleep) == "<built-in function sleep>"
""",
    "as_method_of_a_class": """
from datetime import datetime
from dataclasses import dataclass, field
@dataclass
class Step:
    at: datetime = field(default_factory=datetime.now)
now = datetime.now
def rest(wait_s):
    began = Step().at
    time.sleep(wait_s)
    assert (now() - began).total_seconds() == wait_s
""",
}
"""Where a module keeps what waits -> its source."""


def make_module(monkeypatch: pytest.MonkeyPatch, source: str) -> ModuleType:
    module = ModuleType("kept_by_a_module")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    names = "collections, functools, itertools, logging, queue, threading, time, types, weakref"
    exec(f"import {names}\n{source}", vars(module))
    return module


@pytest.mark.parametrize("source", KEPT.values(), ids=KEPT)
def test_what_a_module_keeps_waits_in_virtual_time(monkeypatch: pytest.MonkeyPatch, source: str) -> None:
    module = make_module(monkeypatch, source)

    def body(say: Callable[[object], None]) -> None:
        began_s = vars(library_programs)["time"].monotonic()
        module.rest(0.25)
        say(vars(library_programs)["time"].monotonic() - began_s)

    for _ in range(2):
        if hasattr(module.rest, "cache_clear"):
            module.rest.cache_clear()
        assert run_in_virtual_time(body, module.__name__) == [0.25]


@pytest.mark.parametrize(
    ("source", "refused"),
    [
        ("def hold(lock):\n    yield lock\nways = [hold(threading.Lock())]", "a lock in a generator"),
        ("ways = map(threading.Event().wait, [1])", r"threading\.wait in a map"),
    ],
)
def test_what_keeps_a_lock_where_nothing_can_replace_it_is_refused(
    monkeypatch: pytest.MonkeyPatch, source: str, refused: str
) -> None:
    module = make_module(monkeypatch, source)
    with pytest.raises(ProhibitedError, match=rf"kept_by_a_module\.ways keeps {refused}"):
        run_in_virtual_time(lambda say: say(1), module.__name__)


@pytest.mark.parametrize(
    ("source", "refused"),
    [
        ("import os\ncall = functools.partial(os.system, 'touch made')", r"waits in real time, in os\.system"),
        ("import os\ndef call(ways=(os.system,)):\n    ways[0]('touch made')", r"waits in real time, in os\.system"),
        ("from os import _exit\ncall = functools.partial(_exit, 0)", r"os\._exit\(0\) at .*: it would end all tests"),
        ("import select\ndef call():\n    select.poll().poll(200)", r"waits in real time, in select\.poll\.poll"),
        ("import select\ndef call():\n    select.epoll().poll(0.2)", r"waits in real time, in select\.epoll\.poll"),
        ("import os\ncall = [os.execv][0].__call__", r"os\.execv\('true', \.\.\.\) at .*: it would end all tests"),
    ],
)
def test_what_no_run_may_call_is_refused_in_whatever_keeps_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, source: str, refused: str
) -> None:
    monkeypatch.chdir(tmp_path)
    module = make_module(monkeypatch, source)
    with pytest.raises(NodeError, match=refused):
        run_in_virtual_time(lambda _: module.call(*("true", ["true"])[: 2 * ("execv" in source)]), module.__name__)
    assert not [*tmp_path.iterdir()]


def test_modules_that_a_run_imports_share_objects_in_later_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "late_first.py").write_text("from threading import *\nREADY = Event()\n", encoding="utf-8")
    (tmp_path / "late_second.py").write_text("from late_first import READY\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))

    def body(say: Callable[[object], None]) -> None:
        names = {"__name__": library_programs.__name__}
        exec("import importlib\nfirst, second = map(importlib.import_module, ('late_first', 'late_second'))", names)
        say(names["first"].READY is names["second"].READY)  # type: ignore[attr-defined]
        say(type(names["first"].READY).__module__ == "threading")  # type: ignore[attr-defined]

    for _ in range(2):
        assert run_in_virtual_time(body) == [True, False]
    for name in ("late_first", "late_second"):
        del sys.modules[name]


def test_values_of_each_thread_are_made_with_their_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    module = make_module(
        monkeypatch,
        """
class State(threading.local):
    def __init__(self, number, *, name):
        self.values = number, name
STATE, PLAIN = State(7, name="arm"), threading.local()
""",
    )
    assert run_in_virtual_time(lambda say: say(module.STATE.values), module.__name__) == [(7, "arm")]


def test_a_pool_that_is_kept_serves_the_next_run(monkeypatch: pytest.MonkeyPatch) -> None:
    module = make_module(
        monkeypatch,
        """
from concurrent.futures import ThreadPoolExecutor
@functools.cache
def pool():
    return ThreadPoolExecutor(1)
""",
    )
    for _ in range(2):
        assert run_in_virtual_time(lambda say: say(module.pool().submit(int).result(1)), module.__name__) == [0]


def test_a_thread_from_before_the_run_is_refused_with_its_function(monkeypatch: pytest.MonkeyPatch) -> None:
    source = "end = threading.Event()\ndef serve():\n    end.wait()\nthreading.Thread(target=serve, name='io').start()"
    module = make_module(monkeypatch, source)
    try:
        with pytest.raises(ProhibitedError, match=r"thread io of kept_by_a_module\.serve was started before the run"):
            run_in_virtual_time(lambda say: say(1), module.__name__)
    finally:
        module.end.set()
    assert run_in_virtual_time(lambda say: say(1), module.__name__) == [1]


def test_code_may_replace_a_clock_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    module = make_module(monkeypatch, "from unittest import mock")

    def body(say: Callable[[object], None]) -> None:
        with module.mock.patch("time.sleep") as sleep, module.mock.patch("time.monotonic", return_value=7.0):
            module.time.sleep(5)
            say((sleep.call_args.args, module.time.monotonic()))
        importlib.reload(module.time).sleep(0.5)
        say(module.time.monotonic())

    assert run_in_virtual_time(body, module.__name__) == [((5,), 7.0), 0.5]


def test_a_moment_is_of_the_class_that_everybody_has(monkeypatch: pytest.MonkeyPatch) -> None:
    module = make_module(monkeypatch, "import copy, pickle\nfrom datetime import date, datetime, timezone")

    def body(say: Callable[[object], None]) -> None:
        now = module.datetime.now()
        again = module.pickle.loads(module.pickle.dumps(module.copy.deepcopy(module.datetime.now)))()
        say((type(now) is module.datetime is datetime.datetime, again == now, module.date.today() == now.date()))
        say((str(module.datetime.now(module.timezone.utc)), str(module.datetime.today())))

    moments = ("2000-01-01 00:00:00+00:00", "2000-01-01 00:00:00")
    assert run_in_virtual_time(body, module.__name__) == [(True, True, True), moments]
    assert datetime.datetime.now().year > 2000


def test_what_was_kept_before_runs_is_led_to_the_time_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    before = clocks._REAL["now"].__get__(None, datetime.datetime)
    module = make_module(monkeypatch, "")
    module.now = before  # type: ignore[attr-defined]
    assert run_in_virtual_time(lambda say: say(str(module.now())), module.__name__) == ["2000-01-01 00:00:00"]
    assert module.now is before
    assert before().year > 2000


def test_log_records_count_from_the_beginning_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    module = make_module(
        monkeypatch,
        """
import logging.handlers
def age_ms():
    time.sleep(1.5)
    return logging.makeLogRecord({}).relativeCreated
""",
    )
    for _ in range(2):
        assert run_in_virtual_time(lambda say: say(round(module.age_ms())), module.__name__) == [1500]


def test_a_socket_that_waited_until_its_limit_is_refused_with_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    module = make_module(monkeypatch, "import socket\nclass Port(socket.socket):\n    pass")

    def body(say: Callable[[object], None]) -> None:
        with module.Port(module.socket.AF_INET, module.socket.SOCK_DGRAM) as port:
            port.bind(("127.0.0.1", 0))
            port.settimeout(0.01)
            port.recvfrom(100)

    with pytest.raises(NodeError, match=r"test_libraries\.py:\d+: .* waits in real time, in socket\.socket\.recvfrom"):
        run_in_virtual_time(body, module.__name__)
