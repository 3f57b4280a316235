"""SIGTERM ends a session soon, whatever the code under test does, and its report has what was reached."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.plugin.project import A_WORKER, change, command, report

pytestmark = [
    pytest.mark.slow,  # each test is a session or several
    pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="this system has no such signals"),
]

SUITE = "--hri-suite=by-hand"  # four tests; the third one wishes for level 10
FAR_S = 60.0
"""Far above the 5 s that it takes on a machine with nothing else to do, far below what it would take without."""

BEGINS_WITHIN_S = 500.0
"""Far above the 3 s that it takes a session, on a machine with nothing else to do, to begin its tests."""

STUBBORN = {
    "a loop": "while True:\n        pass",
    "a loop that catches all": "while True:\n        try:\n            while True:\n                pass\n"
    "        except BaseException:\n            pass",
    "a lock": "import threading\n    threading.Lock().acquire() and threading.Event().wait()",
    "a lock that catches all": "import threading\n    lock = threading.Lock()\n    lock.acquire()\n    while True:\n"
    "        try:\n            lock.acquire()\n        except BaseException:\n            pass",
    "in C": "import ctypes\n    mutex, lock = ctypes.create_string_buffer(64), ctypes.CDLL(None).pthread_mutex_lock\n"
    "    lock(mutex)\n    lock(mutex)",
    "in the end": "try:\n        raise OSError\n    finally:\n        while True:\n            pass",
}


@pytest.fixture(autouse=True)
def _interruptible() -> Iterator[None]:
    """What a shell starts in the background ignores Ctrl-C, and so would the sessions that tests start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def ended(lamps: pytest.Pytester, *options: str, where: str = "guide") -> int:
    """How a session ends that gets SIGTERM when the code has begun what it does not end."""
    arguments = [sys.executable, "-m", "pytest", SUITE, *options]
    with open(lamps.path / f"{where}.log", "w", encoding="utf-8") as log:
        session = subprocess.Popen(arguments, cwd=lamps.path, stdout=log, stderr=log, start_new_session=True)
        try:
            wait_for(lamps.path / "begun", session)
            session.terminate()
            status = session.wait(FAR_S)
            workers = [int(pid) for pid in (lamps.path / "begun").read_text(encoding="utf-8").split()]
            for pid in workers:
                wait_for_end(pid)
            return status
        finally:
            if session.poll() is None:
                os.killpg(session.pid, signal.SIGKILL)
                session.wait()


def wait_for(path: Path, session: subprocess.Popen[bytes]) -> None:
    until_s = time.monotonic() + BEGINS_WITHIN_S
    while not (path.exists() and path.read_text(encoding="utf-8").endswith("\n")):
        assert session.poll() is None, "the session has ended before"
        assert time.monotonic() < until_s, "the code has not begun"
        time.sleep(0.05)


def wait_for_end(pid: int) -> None:
    until_s = time.monotonic() + FAR_S
    while Path(f"/proc/{pid}").exists() and " Z " not in Path(f"/proc/{pid}/stat").read_text(encoding="utf-8"):
        assert time.monotonic() < until_s, f"process {pid} goes on"
        time.sleep(0.05)


BEGIN = '    with open("begun", "a") as begun:\n        print(__import__("os").getpid(), file=begun)\n'


@pytest.mark.parametrize(
    ("way", "options"),
    [
        *(pytest.param(way, ("-p", "no:xdist"), id=way) for way in STUBBORN),
        *(pytest.param(way, A_WORKER, id=f"{way}, on a worker") for way in ("a loop that catches all", "in C")),
    ],
)
def test_it_ends_whatever_the_code_under_test_does(lamps: pytest.Pytester, way: str, options: tuple[str, ...]) -> None:
    change(lamps.path, "lamps/guide.py", "    return 10.0", f"{BEGIN}    {STUBBORN[way]}\n    return 10.0")
    # The wait for a lock is refused after half a second: of so many tests some are left on any machine.
    assert ended(lamps, *options, "--hri-concretizations=10") not in (0, -15)
    written = report(lamps.path)
    assert written["selected"] == 40
    assert 1 <= written["reported"] < 40
    assert command("gate", str(lamps.path / "hri-report")).returncode == 1


@pytest.mark.parametrize("where", ["the testbench's run", "the test function"])
def test_it_ends_whatever_other_code_does(lamps: pytest.Pytester, where: str) -> None:
    stuck = STUBBORN["a loop that catches all"]
    path, old = (
        ("conftest.py", "    ended = run.go(LIMIT_S)")
        if where == "the testbench's run"
        else ("test_lamps.py", "    hri_case.check(hri_case.run())")
    )
    condition = "10" if path == "conftest.py" else ""
    body = f"{BEGIN}    {stuck}\n"
    if condition:
        body = "".join(f"    {line}\n" for line in body.splitlines())
        body = f"    if any('10' in action.command.split() for action in run.test.actions):\n{body}"
    change(lamps.path, path, old, f"{body}{old}")
    assert ended(lamps, "-p", "no:xdist") == pytest.ExitCode.INTERRUPTED
    written = report(lamps.path)
    assert written["selected"] == 4
    assert written["reported"] < 4


SLOW_END = """

import time
import pytest

@pytest.hookimpl(trylast=True)
def {hook}():
{begin}    while True:
        pass

def pytest_keyboard_interrupt():
    until_s = time.monotonic() + 2.0
    while time.monotonic() < until_s:
        pass
"""


@pytest.mark.parametrize("hook", ["pytest_sessionstart", "pytest_collection"])
def test_what_ends_the_session_is_not_cut_off_however_slow_it_is(lamps: pytest.Pytester, hook: str) -> None:
    """As on a machine with more to do than it can: what was reached by then is in the report."""
    with open(lamps.path / "conftest.py", "a", encoding="utf-8") as conftest:
        conftest.write(SLOW_END.format(hook=hook, begin=BEGIN))
    assert ended(lamps, "-p", "no:xdist", "--hri-close", "--hri-close-runs=8") == pytest.ExitCode.INTERRUPTED
    written = report(lamps.path)
    assert written["closing"]["runs"] >= 4
    assert written["reported"] == 0


def test_workers_end_when_their_session_is_killed(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", "    return 10.0", f"{BEGIN}    {STUBBORN['a loop that catches all']}")
    arguments = [sys.executable, "-m", "pytest", SUITE, *A_WORKER]
    session = subprocess.Popen(arguments, cwd=lamps.path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for(lamps.path / "begun", session)
    finally:
        session.kill()
        session.wait()
    wait_for_end(int((lamps.path / "begun").read_text(encoding="utf-8")))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_processes_of_a_closing_loop_end_with_their_session(lamps: pytest.Pytester, number: int) -> None:
    change(lamps.path, "lamps/guide.py", "    return 10.0", f"{BEGIN}    {STUBBORN['a loop that catches all']}")
    arguments = [sys.executable, "-m", "pytest", "--hri-suite=closure", "-p", "no:xdist"]
    session = subprocess.Popen(arguments, cwd=lamps.path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for(lamps.path / "begun", session)
        session.send_signal(number)
        assert session.wait(FAR_S) != 0
    finally:
        session.kill()
        session.wait()
    for pid in (lamps.path / "begun").read_text(encoding="utf-8").split():
        wait_for_end(int(pid))


def test_what_is_left_to_the_end_of_python_does_not_keep_it(tmp_path: Path) -> None:
    ending = (
        "import atexit, os, time\n"
        "from pytest_hricdv.session import early_end as module\n"
        "module.AT_EXIT_WITHIN_S = 0.1\n"
        "atexit.register(time.sleep, 10_000.0)\n"
        "atexit.register(module._keep_status, 3, os.getpid())\n"
        "print('all results')\n"
    )
    done = subprocess.run([sys.executable, "-c", ending], capture_output=True, text=True, check=False, timeout=600)
    assert (done.returncode, done.stdout) == (3, "all results\n")
    assert "take more than 0.1 s: Python exits without them" in done.stderr


def test_an_exit_that_the_code_has_registered_has_the_status_of_the_session() -> None:
    keeping = "import pytest_hricdv.session.early_end as module; atexit.register(module._keep_status, 3, os.getpid())"
    ending = f"import atexit, os; atexit.register(os._exit, 0); {keeping}"
    assert subprocess.run([sys.executable, "-c", ending], check=False, timeout=600).returncode == 3
