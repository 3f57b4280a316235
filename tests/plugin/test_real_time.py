"""Code that a testbench hands over waits in real time: an error with its line, at once, and no test that passed."""

from __future__ import annotations

import pytest

from tests.plugin import project

pytestmark = pytest.mark.slow  # each test is a session or several

RUN = ("--hri-suite=bdi-random", "--hri-tests=2", "-p", "no:cacheprovider", "-p", "no:xdist")
SLEEP = "        clock.sleep(SWITCHING_S)\n"
ADVICE = "list module resting in the testbench's code, with time=VirtualTime(apis=("
NOTHING = "nothing outside of a run can be waited for"

WAYS = {
    "sleep": ("import time", "time.sleep(0.01)", 'code, with time=VirtualTime(apis=("time",))'),
    "sleep by name": ("from time import sleep as nap", "nap(0.01)", 'code, with time=VirtualTime(apis=("time",))'),
    "event": ("import threading", "threading.Event().wait(60)", 'code, with time=VirtualTime(apis=("threading",))'),
    "lock": ("import threading\nLOCK = threading.Lock()\nLOCK.acquire()", "LOCK.acquire()", ADVICE),
    "queue": ("import queue", "queue.Queue().get(timeout=60)", 'code, with time=VirtualTime(apis=("threading",))'),
    "simple queue": ("import queue", "queue.SimpleQueue().get()", ADVICE),
    "future": (
        "import concurrent.futures",
        "concurrent.futures.Future().result()",
        'time=VirtualTime(apis=("threading",))',
    ),
    "thread": (
        "import threading\nOVER = threading.Event()",
        "one = threading.Thread(target=OVER.wait, daemon=True); one.start(); one.join()",
        ADVICE,
    ),
    "loop made before": (
        "import asyncio\nLOOP = asyncio.SelectorEventLoop()",
        "LOOP.run_until_complete(asyncio.sleep(0.01))",
        'code, with time=VirtualTime(apis=("asyncio",))',
    ),
    "select": ("import select", "select.select([], [], [], 60)", 'VirtualTime(apis=("time",))'),
    "socket": ("import socket\nENDS = socket.socketpair()", "ENDS[0].recv(1)", NOTHING),
    "process": ("import subprocess, sys", "subprocess.run([sys.executable, '-c', 'input()'], stdin=-1)", NOTHING),
    "process with output": (
        "import subprocess, sys",
        "subprocess.run([sys.executable, '-c', 'input()'], capture_output=True)",
        NOTHING,
    ),
    "process that is forked": (
        "import multiprocessing, signal",
        "one = multiprocessing.Process(target=signal.pause, daemon=True); one.start(); one.join()",
        NOTHING,
    ),
    "signal": ("import signal", "signal.sigwait({signal.SIGUSR1})", NOTHING),
    "signal by name": ("from signal import pause as rest_of_it", "rest_of_it()", NOTHING),
    "shell": ("import os", "os.system('exit 3')", NOTHING),
    "who catches all": (
        "import queue",
        "\n".join(
            (
                "while True:",
                "        try:",
                "            queue.Queue().get()",
                "        except BaseException:",
                "            pass",
            )
        ),
        "node guide catches whatever is raised in it",
    ),
}

LEAVING = ("socket", "process", "loop")


def resting(lamps: pytest.Pytester, head: str, body: str, parameters: str = "") -> None:
    """The guide calls a function that the testbench hands over, of a module that its code does not name."""
    text = f"{head}\n\n\ndef rest({parameters}):\n    {body}\n"
    (lamps.path / "resting.py").write_text(text, encoding="utf-8")
    project.change(lamps.path, "lamps/guide.py", SLEEP, f"        HOOKS[0]({parameters})\n")
    project.change(lamps.path, "lamps/guide.py", "GLARE = 80.0", "HOOKS = []\nGLARE = 80.0")
    conftest = lamps.path / "conftest.py"
    text = conftest.read_text(encoding="utf-8")
    conftest.write_text(f"{text}\nimport lamps.guide, resting\nlamps.guide.HOOKS.append(resting.rest)\n", "utf-8")


@pytest.mark.parametrize("way", WAYS)
def test_a_node_that_waits_outside_of_its_code_is_an_error_with_the_line(lamps: pytest.Pytester, way: str) -> None:
    head, body, advice = WAYS[way]
    resting(lamps, head, body)
    # What these leave open is theirs, and no other test is to hear of it.
    run = lamps.runpytest_subprocess if way.startswith(LEAVING) else lamps.runpytest_inprocess
    result = run(*RUN)
    result.assert_outcomes(failed=2, deselected=1)
    said = result.stdout.str()
    assert f"{lamps.path / 'resting.py'}:" in said
    assert ("in node guide is real time" if way == "select" else "node guide waits in real time") in said
    assert advice in said


def instead_of_the_run(lamps: pytest.Pytester, body: str, head: str = "") -> pytest.RunResult:
    """The testbench's run does something else than to simulate."""
    conftest = lamps.path / "conftest.py"
    text = conftest.read_text(encoding="utf-8")
    start = text.index("def run(run):")
    after = "\n    from pytest_hricdv.testbench import Outcome\n\n    return Outcome('done', outcomes=())\n"
    conftest.write_text(f"{head}\n{text[:start]}def run(run):\n    {body}\n{after}", encoding="utf-8")
    return lamps.runpytest_inprocess(*RUN)


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("run.recorder.signal(0.0, 'lamp_level', 0.0)", ", as the testbench's run never called run.go"),
        ("run.recorder.signal(0.0, 'lamp_level', 0.0); run.go(10.0)", ""),
        (
            "run.recorder.signal(0.0, 'lamp_level', 0.0); run.kernel.spawn('a', lambda: run.kernel.stop('over')); "
            "run.go(10.0)",
            "",
        ),
    ],
)
def test_a_run_that_simulates_nothing_never_passes(lamps: pytest.Pytester, body: str, why: str) -> None:
    project.change(
        lamps.path,
        "conftest.py",
        'code=("lamps",),',
        'code=("lamps",),\n        time=VirtualTime(allowed_endings=("idle", "early", "limit")),',
    )
    result = instead_of_the_run(lamps, body)
    result.assert_outcomes(failed=2, deselected=1)
    result.stdout.fnmatch_lines([f"*the run simulated nothing: no simulated time passed{why}, so its verdicts *"])


def test_a_thread_that_is_no_node_and_sleeps_is_a_fault(lamps: pytest.Pytester) -> None:
    resting(lamps, "import threading, time", "threading.Thread(target=time.sleep, args=(0.01,), name='ticker').start()")
    project.change(lamps.path, "lamps/guide.py", "        HOOKS[0]()\n", f"        HOOKS[0]()\n{SLEEP}")
    result = lamps.runpytest_subprocess(*RUN, "-W", "ignore")  # in this process our own pytest would hear of it
    result.assert_outcomes(failed=2, deselected=1)
    result.stdout.fnmatch_lines(["*thread ticker, which node guide started at *resting.py:5, waits in real time*"])
