"""A run that costs nothing: a person whose actions take time, in the real kernel, with the record as the result."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Bus, Kernel, Recorder


def concrete(*commands: str, seed: int = 1) -> ConcreteTest:
    """A test of these commands; the n-th takes n seconds."""
    actions = tuple(ConcreteAction(command, {"takes_s": float(n)}) for n, command in enumerate(commands, 1))
    return ConcreteTest("toy", "toys", seed, actions)


def run_of(test: ConcreteTest, stuck_after_s: float | None = None) -> Run:
    """A run without a world, a robot or requirements."""
    kernel, recorder = Kernel(stuck_after_s=stuck_after_s), Recorder()
    return Run(test, kernel, Bus(kernel, (), recorder), recorder, lambda body: body, MonitorSet())


def execute(test: ConcreteTest, stuck_after_s: float | None = None) -> str:
    """The record's hash, the time, what was done, and what was to be done."""
    run, done = run_of(test, stuck_after_s), list[str]()

    def person() -> None:
        for action in test.actions:
            run.recorder.signal(run.kernel.now_s, "doing", action.command)
            run.kernel.sleep(action.parameters["takes_s"])
            done.append(action.command)
            BEHAVIOUR.get(action.command, lambda: None)()
            if action.command == "leave":
                run.kernel.stop("left")
                run.kernel.sleep(1.0)

    run.kernel.spawn("person", person)
    run.go(1000.0)
    if run.ending is not None and run.ending.error is not None:
        raise run.ending.error
    planned = " ".join(action.command for action in run.test.actions)
    return f"{run.recorder.finish().sha256} {run.kernel.now_s:g} {' '.join(done)} of {planned}"


def _spin() -> None:
    while True:
        pass


def _fail() -> None:
    raise ValueError("tripped over the cable")


BEHAVIOUR: dict[str, Callable[[], object]] = {
    "die": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "exit": lambda: os._exit(3),
    "hang": lambda: time.sleep(60.0),  # what is tried: a run that does not come to its end
    "spin": _spin,
    "fail": _fail,
    "quit": sys.exit,
    "thread": lambda: threading.Thread(target=threading.Event().wait, daemon=True).start(),
}


def texts(tests: Sequence[ConcreteTest]) -> list[str]:
    """What each test does alone."""
    return [execute(test) for test in tests]
