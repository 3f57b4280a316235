"""The end of a run: it goes on while a requirement waits for a response, and no longer."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from pytest_hricdv.execution.run_monitors import MonitorFeed
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, parse_formula
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from pytest_hricdv.testbench import Run

VOCABULARY = Vocabulary(messages={"ask": {}, "answer": {}})
TEXT = "always(on(ask) -> eventually[0:100](on(answer)))"


@dataclass(frozen=True)
class Ask:
    """A question."""


@dataclass(frozen=True)
class Answer:
    """What has to follow."""


@pytest.mark.parametrize(("answers", "end_s"), [(True, 5.0), (False, 101.0)])
def test_a_run_ends_at_once_when_its_last_instant_meets_the_deadline(answers: bool, end_s: float) -> None:
    kernel, recorder = Kernel(), Recorder()
    monitors = MonitorSet([Requirement("A", "answered", "", TEXT, parse_formula(TEXT, VOCABULARY))])
    recorder.listeners.append(MonitorFeed(monitors, VOCABULARY))
    bus = Bus(kernel, (Ask, Answer), recorder)
    test = ConcreteTest(id="a", suite="s", seed=0, actions=(), run={})
    run = Run(test, kernel, bus, recorder, lambda body: body, monitors)

    def robot() -> None:
        port = bus.port("robot")
        kernel.sleep(1.0)
        port.publish(Ask())
        kernel.sleep(4.0)
        if answers:
            port.publish(Answer())
        kernel.stop("done")

    kernel.spawn("robot", robot)
    kernel.spawn("other", lambda: kernel.sleep(1000.0))
    assert run.go(300.0) == "done"
    assert kernel.now_s == pytest.approx(end_s, abs=1e-5)
    [verdict] = monitors.finish(kernel.now_s)
    assert verdict.verdict == ("Passed" if answers else "Failed")
