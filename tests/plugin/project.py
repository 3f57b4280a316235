"""A complete project of a user, small and without physics: a guide robot switches lamps for visitors.

The model is the one of `tests.generate.toy`; everything else that a user writes is here, as the text of files.
"""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report.__main__ import main
from tests.generate.toy import lamps

MODES = {"plain": (), "on two workers": ("-n", "2"), "without xdist": ("-p", "no:xdist")}
"""The ways to run pytest that every behaviour has to survive."""

A_WORKER = ("-n", "1")
"""For what is the same with any number of workers: each takes as long to start as ten runs in this process."""

in_each_mode = pytest.mark.parametrize(
    "options",
    [
        pytest.param((), id="plain"),
        pytest.param(A_WORKER, id="on a worker"),
    ],
)
"""Runs a test in this process and on a worker."""

plain_and_slowly_on_a_worker = pytest.mark.parametrize(
    "options",
    [
        pytest.param((), id="plain"),
        pytest.param(A_WORKER, id="on a worker", marks=pytest.mark.slow),
    ],
)
"""The same for behaviour that depends little on the mode: on a worker among the slow tests only."""

counted_up_to_313 = pytest.mark.skipif(
    sys.version_info >= (3, 14), reason="from Python 3.14 on, fields without a default are no statements"
)
"""For tests that count the project's statements."""

INI = """
[pytest]
pythonpath = .
addopts = -p no:hypothesispytest
hri_audit = off
hri_diagnose = 0
hri_known_violations =
    R2: the hall has no dimmer
"""

CONFTEST = '''
"""The lamps testbench."""

from pathlib import Path
from pytest_hricdv.testbench import Field, Signal, Simulation, StateField, Suites, VirtualTime  # some of them for tests
HERE = Path(__file__).parent
LIMIT_S = 60.0


def pytest_hricdv_testbench(config):
    from lamps.messages import Answer, Greeting, Switched, Wish
    from pytest_hricdv.testbench import BeliefSpace, Concretization, CrossProduct, Model, Testbench, Uniform

    pause = {"pause_s": Uniform(0.5, 1.0, "s")}
    levels = ("0", "10", "100", "none")
    return Testbench(
        name="lamps",
        model=Model(
            HERE / "models" / "lamps.mas2j", steering_agent="usher", actor="visitor", covered=("visitor", "guide")
        ),
        beliefs=BeliefSpace(
            start=("hall", "cellar"),
            groups={"mood": ("polite", "curt"), "wish": ("bright", "dim", "dark")},
            id_groups=("mood",),
        ),
        concretization=Concretization(
            commands={
                "enter hall": pause,
                "enter cellar": pause,
                "greet": pause,
                "set_lamp level = 100": pause,
                "set_lamp level = 10": pause,
                "set_lamp level = 0": pause,
                "leave": {},
            },
            run={"patience_s": Uniform(5.0, 8.0, "s")},
        ),
        requirements=HERE / "requirements.toml",
        messages=(Answer, Greeting, Switched, Wish),
        signals={"lamp_level": Signal(float, "%")},
        fields={},
        code=("lamps",),
        run=run,
        suites=Suites(by_hand=HERE / "by_hand.toml"),
        cross={"light": CrossProduct({"place": ("hall", "cellar"), "level": levels})},
    )


def run(run):
    from lamps import guide
    from lamps.messages import Greeting, Wish
    from pytest_hricdv.testbench import Outcome

    class Lamp:
        def set(self, level):
            run.recorder.signal(run.kernel.now_s, "lamp_level", level)

    def visitor():
        bus = run.bus.port("visitor")
        for action in run.actions():
            name, *words = action.command.split()
            run.kernel.sleep(action.parameters.get("pause_s", 0.0))
            if name == "greet":
                bus.publish(Greeting())
            if name == "set_lamp":
                bus.publish(Wish(level=float(words[-1]), cellar=place_of(run.taken) == "cellar"))

    def robot():
        guide.serve(run.bus.port("guide"), run.kernel, lamp, run.test.run["patience_s"])
        run.kernel.stop("patience over")

    def place_of(actions):
        return "cellar" if any(action.command == "enter cellar" for action in actions) else "hall"

    lamp = Lamp()
    lamp.set(0.0)
    run.kernel.spawn("visitor", visitor)
    run.kernel.spawn("guide", run.measured(robot))
    ended = run.go(LIMIT_S)
    commands, place = [action.command for action in run.enacted.actions], place_of(run.enacted.actions)
    levels = [command.split()[-1] for command in commands if command.startswith("set_lamp")]
    return Outcome(ended, outcomes=("released",), cross={"light": [(place, level) for level in levels or ["none"]]})
'''

HOST_TEST = '''
"""The host test."""


def test_lamps(hri_case):
    hri_case.check(hri_case.run())


def test_of_their_own():
    pass
'''

MESSAGES = '''
"""Who says what."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Greeting:
    """A visitor greets."""


@dataclass(frozen=True)
class Answer:
    """The guide greets back."""


@dataclass(frozen=True)
class Wish:
    """A visitor asks for light (level in percent)."""

    level: float
    cellar: bool


@dataclass(frozen=True)
class Switched:
    """The guide says that the lamp is as it was asked for."""

    level: float
'''

GUIDE = '''
"""The guide: waits for wishes and switches the lamp."""

from lamps.messages import Answer, Greeting, Switched, Wish

GLARE = 80.0
SWITCHING_S = 0.3


def serve(bus, clock, lamp, patience_s):
    """Serve one visitor after the other, until none has come for a while."""
    greetings, wishes = bus.subscribe(Greeting), bus.subscribe(Wish)
    while True:
        wish = wishes.wait(patience_s)
        if greetings.poll() is not None:
            bus.publish(Answer())
        if wish is None:
            return
        level = level_for(wish)
        lamp.set(level)
        clock.sleep(SWITCHING_S)
        bus.publish(Switched(level))


def level_for(wish):
    """What the lamp is set to: no glare in the cellar. The hall was forgotten."""
    if wish.cellar and wish.level > GLARE:
        return GLARE
    if wish.level == 0.0:
        return switched_off()
    if wish.level == 10.0:
        return dimmed()
    return wish.level


def switched_off():
    return 0.0


def dimmed():
    return 10.0


def serviced():
    return "by hand"
'''

REQUIREMENTS = """
[R1]
title = "A wish shall be fulfilled within a second"
formula = "always(on(wish) -> eventually[0:1](on(switched)))"

[R2]
title = "The lamp shall never glare"
source = "EN 12464-1"
formula = "always(lamp_level > 0 -> lamp_level <= 80)"

[R3]
title = "A greeting shall be answered"
formula = "always(on(greeting) -> eventually[0:2](on(answer)))"
"""

BY_HAND = """
[[belief_set]]
name = "polite visitors"
beliefs = ["?[ae]l*", "polite", "bright"]

[[belief_set]]
name = "curt visitors"
beliefs = ["hall", "curt", "d*"]
"""

FILES = {
    "pytest.ini": INI,
    "conftest.py": CONFTEST,
    "test_lamps.py": HOST_TEST,
    "requirements.toml": REQUIREMENTS,
    "by_hand.toml": BY_HAND,
    "lamps/__init__.py": '"""The code under test."""\n',
    "lamps/messages.py": MESSAGES,
    "lamps/guide.py": GUIDE,
}


def write(folder: Path) -> None:
    """Write the project into an empty folder."""
    for name, text in FILES.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.lstrip("\n"), encoding="utf-8")
    (folder / "models").mkdir()
    lamps(folder / "models")


def change(folder: Path, name: str, old: str, new: str) -> None:
    """Change one place of one file of the project, as its user would.

    Its bytecode goes: Python takes it for current if source and change are of one second and size.
    """
    path = folder / name
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{name}: expected {old!r} once, found it {text.count(old)} times"
    path.write_text(text.replace(old, new), encoding="utf-8")
    for stale in path.parent.glob(f"__pycache__/{path.stem}.*"):
        stale.unlink()


BEACON = """
    def beacon():
        from lamps.messages import Answer

        port = run.bus.port("beacon")
        for number in range({messages}):
            run.kernel.sleep(0.01)
            port.publish(Answer() if number % 2 and {is_met} else Greeting())
            lamp.set(number % 7 / 7)
        run.kernel.stop("all sent")

    run.kernel.spawn("beacon", beacon)
    lamp = Lamp()
"""


def make_long(folder: Path, messages: int, *, is_met: bool) -> None:
    """Let each run of the project go on for so many messages of a beacon, and as many changes of the lamp.

    Every other message is a greeting, which triggers R3; unless `is_met`, all are, and none is answered in time.
    """
    change(folder, "conftest.py", "    lamp = Lamp()\n", BEACON.format(messages=messages, is_met=is_met))
    change(
        folder,
        "conftest.py",
        "        run=run,\n",
        '        run=run,\n        time=VirtualTime(allowed_endings=("early",)),\n',
    )
    change(folder, "conftest.py", "LIMIT_S = 60.0", "LIMIT_S = 1e6")
    change(folder, "conftest.py", '        run.kernel.stop("patience over")\n', "")


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`hricdv report` in the current folder, without a process of its own."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(arguments)
        except SystemExit as ended:  # the command line was wrong
            status = int(ended.code or 0)
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def report(folder: Path) -> dict[str, Any]:
    """The report that a run left in the project's folder."""
    loaded: dict[str, Any] = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))
    return loaded


def outcomes(folder: Path) -> dict[str, str]:
    """Id -> outcome, of the report."""
    return {test["id"]: test["outcome"] for test in report(folder)["tests"]}


def nodeids(result: pytest.RunResult) -> list[str]:
    """What `--collect-only -q` listed."""
    return [line for line in result.outlines if "::" in line]
