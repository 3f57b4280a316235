"""Threads, queues and event loops in the code under test: in virtual time where the testbench says so, else refused."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from tests.plugin import project
from tests.plugin.test_virtual_time import RUN, SLEEP, hashes

HEAD = '''
import asyncio
import queue
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from threading import Event, Thread

JOBS = queue.Queue()
LOCK = threading.Lock()


class Settling(Thread):
    """Is over when the lamp has its level."""

    def __init__(self):
        super().__init__(daemon=True)

    def run(self):
        with LOCK:
            time.sleep(SWITCHING_S)
        JOBS.put("settled")


@dataclass
class Lit:
    when: Event = field(default_factory=threading.Event)

    def soon(self):
        threading.Timer(SWITCHING_S, self.when.set).start()
        return self.when


async def settle():
    await asyncio.gather(asyncio.sleep(SWITCHING_S), asyncio.sleep(0.1))


GLARE = 80.0'''

WAYS = {
    "event": "Event().wait(SWITCHING_S)",
    "thread": "worker = Settling(); worker.start(); worker.join(); JOBS.get_nowait()",
    "queue": "Settling().start(); JOBS.get(timeout=10.0)",
    "timer": "Lit().soon().wait()",
    "lock": "LOCK.acquire(); LOCK.acquire(timeout=SWITCHING_S); LOCK.release()",
    "pool": "ThreadPoolExecutor(2).submit(time.sleep, SWITCHING_S).result()",
    "asyncio": "asyncio.run(settle())",
    "a loop of its own": "asyncio.new_event_loop().run_until_complete(settle())",
    "import in the function": "import threading as t; t.Event().wait(SWITCHING_S)",
    "dotted import": "import concurrent.futures as c; c.wait([c.ThreadPoolExecutor().submit(time.sleep, 0.3)])",
}


def wait_so(lamps: pytest.Pytester, way: str, virtual: str) -> None:
    """The guide waits in this way, with these as virtual."""
    project.change(lamps.path, "lamps/guide.py", SLEEP, f"        {WAYS[way]}\n")
    project.change(lamps.path, "lamps/guide.py", "GLARE = 80.0", HEAD)
    line = '        code=("lamps",),\n'
    project.change(lamps.path, "conftest.py", line, f"{line}        time=VirtualTime(apis={virtual}),\n")


@pytest.fixture(scope="module")
def undisturbed() -> dict[str, Any]:
    """Hashes of the records of the guide that sleeps with the clock of its port."""
    return {}


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_it_is_the_same_run(lamps: pytest.Pytester, way: str, undisturbed: dict[str, Any]) -> None:
    before = undisturbed.setdefault("hashes", None) or hashes(lamps)
    undisturbed["hashes"] = before
    wait_so(lamps, way, '("time", "threading", "asyncio")')
    assert hashes(lamps) == before
    assert threading.Thread.__module__ == "threading"
    assert threading.active_count() < 10


@pytest.mark.slow
@pytest.mark.parametrize("way", ["event", "thread", "timer", "pool", "asyncio"])
def test_without_the_switch_it_is_an_error_with_the_line(lamps: pytest.Pytester, way: str) -> None:
    wait_so(lamps, way, '("time",)')
    said = lamps.runpytest_inprocess(*RUN).stdout.str()
    kind = "asyncio" if way == "asyncio" else "threading"
    assert "RealTimeError: " in said
    assert f"{lamps.path / 'lamps' / 'guide.py'}:" in said
    remedy = f'give the testbench time=VirtualTime(apis=("time", "{kind}")) to have {kind}'
    assert f"a simulated run does not have: {remedy}" in said


def test_what_a_thread_does_is_covered(lamps: pytest.Pytester) -> None:
    wait_so(lamps, "queue", '("time", "threading")')
    result = lamps.runpytest_inprocess(*RUN)
    result.assert_outcomes(passed=3, deselected=1)
    lines = (lamps.path / "lamps" / "guide.py").read_text(encoding="utf-8").splitlines()
    (missing,) = (line for line in result.outlines if line.startswith("  lamps/guide.py"))
    assert f" {lines.index('        threading.Timer(SWITCHING_S, self.when.set).start()') + 1}-" in missing
    assert f"{lines.index('        with LOCK:') + 1}" not in missing
