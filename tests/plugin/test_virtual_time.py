"""Python's own clocks in the code under test: in virtual time where the testbench says so, refused otherwise."""

from __future__ import annotations

import pytest

from tests.plugin import project

RUN = ("--hri-suite=bdi-random", "--hri-tests=3", "-p", "no:cacheprovider", "-p", "no:xdist")
SLEEP = "        clock.sleep(SWITCHING_S)\n"
WAYS = {
    "module": ("import time\n", "        time.sleep(SWITCHING_S)\n"),
    "name": ("from time import sleep as nap\n", "        nap(SWITCHING_S)\n"),
    "in the function": ("", "        import time\n        time.sleep(SWITCHING_S)\n"),
    "name in the function": ("", "        from time import sleep\n        sleep(SWITCHING_S)\n"),
    "until a time": (
        "import time\n",
        "        end = time.monotonic() + SWITCHING_S\n"
        "        while time.monotonic() < end - 1e-9:\n            time.sleep(0.1)\n",
    ),
}


def sleeping(lamps: pytest.Pytester, way: str, *, virtual: bool = True) -> None:
    """The guide sleeps in its own way."""
    wait(lamps, *WAYS[way])
    if virtual:
        let_be_virtual(lamps)


def wait(lamps: pytest.Pytester, head: str, body: str) -> None:
    """The guide waits by this body instead of the clock of its port; `head` is of its module."""
    project.change(lamps.path, "lamps/guide.py", SLEEP, body)
    project.change(lamps.path, "lamps/guide.py", "GLARE = 80.0", f"{head}GLARE = 80.0")


def let_be_virtual(lamps: pytest.Pytester) -> None:
    project.change(
        lamps.path,
        "conftest.py",
        '        code=("lamps",),\n',
        '        code=("lamps",),\n        time=VirtualTime(apis=("time",)),\n',
    )


def hashes(lamps: pytest.Pytester) -> list[str]:
    """Of the records of a run."""
    lamps.runpytest_inprocess(*RUN).assert_outcomes(passed=3, deselected=1)
    return [test["record_sha256"] for test in project.report(lamps.path)["tests"]]


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_sleeping_in_real_time_is_the_same_run_in_virtual_time(lamps: pytest.Pytester, way: str) -> None:
    before = hashes(lamps)
    sleeping(lamps, way)
    assert hashes(lamps) == before


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_without_the_switch_it_is_an_error_with_the_line(lamps: pytest.Pytester, way: str) -> None:
    sleeping(lamps, way, virtual=False)
    result = lamps.runpytest_inprocess(*RUN)
    said = result.stdout.str()
    assert "RealTimeError: " in said
    assert f"{lamps.path / 'lamps' / 'guide.py'}:" in said
    what = "time.monotonic" if way == "until a time" else "time.sleep"
    assert f"{what} in node guide is real time, which a simulated run does not have: give the testbench" in said


STOPWATCH = """from time import monotonic, sleep

class Stopwatch:
    def __init__(self, clock=monotonic):
        self.clock, self.began_s = clock, clock()

    def wait(self, until_s):
        while self.clock() - self.began_s < until_s - 1e-9:
            sleep(0.1)
"""


@pytest.mark.parametrize(
    ("head", "body"),
    [
        ("from stopwatch import Stopwatch\n", "        Stopwatch().wait(SWITCHING_S)\n"),
        (
            "import py_trees\n",
            "        pause = py_trees.timers.Timer('pause', duration=SWITCHING_S - 1e-3)\n"
            "        while pause.tick_once() or pause.status != py_trees.common.Status.SUCCESS:\n"
            "            clock.sleep(SWITCHING_S / 5)\n",
        ),
    ],
    ids=["stopwatch", "py_trees"],
)
def test_what_other_modules_wait_for_passes_in_virtual_time(lamps: pytest.Pytester, head: str, body: str) -> None:
    before = hashes(lamps)
    (lamps.path / "stopwatch.py").write_text(STOPWATCH)
    wait(lamps, head, body)
    let_be_virtual(lamps)
    assert hashes(lamps) == before


@pytest.mark.slow
def test_dates_are_those_of_the_run(lamps: pytest.Pytester) -> None:
    said = "        print(isinstance(datetime.now(), datetime), datetime.now(), date.today(), time.time(), '!')\n"
    project.change(lamps.path, "lamps/guide.py", SLEEP, f"{SLEEP}{said}        assert False\n")
    head = "import time\nfrom datetime import date, datetime\n"
    project.change(lamps.path, "lamps/guide.py", "GLARE = 80.0", f"{head}GLARE = 80.0")
    let_be_virtual(lamps)
    first, second = (lamps.runpytest_inprocess(*RUN).stdout.str() for _ in range(2))
    shown = [line for line in first.splitlines() if line.startswith("True 2000-01-01 00:00:0")]
    assert shown
    assert shown == [line for line in second.splitlines() if line.startswith("True ")]
    assert " 9466848" in shown[0]


def test_what_cannot_be_virtual(lamps: pytest.Pytester) -> None:
    let_be_virtual(lamps)
    project.change(
        lamps.path, "conftest.py", 'time=VirtualTime(apis=("time",))', 'time=VirtualTime(apis=("time", "sockets"))'
    )
    result = lamps.runpytest_inprocess(*RUN)
    result.stderr.fnmatch_lines(
        ['*time: apis has \'sockets\'; expected a tuple of these: "time" for time and datetime; "threading" for*']
    )
