"""Several people who decide during a run: they wait for each other, and their run is an ordinary test afterwards."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.extra.closing.online_strategy import OnlineRun, roles_of
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.actors import PAUSE_S, TURN_WAIT_S
from pytest_hricdv.generate.beliefs import START
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.concrete import concretize
from pytest_hricdv.generate.suite_files import dump_tests, parse_tests
from pytest_hricdv.monitor import load_requirements
from pytest_hricdv.online.decisions import ANY_INTERACTION, ANY_STATE, Weight
from pytest_hricdv.testbench import (
    Disturbance,
    InteractiveAgent,
    Outcome,
    People,
    PerceptMapping,
    Run,
    Testbench,
    TestbenchError,
)
from pytest_hricdv.testbench_faults import check_testbench
from tests.actors.corridor.bench import nurse, running, ward

PEOPLE = (InteractiveAgent("nurse", idle_timeout_s=2.0), InteractiveAgent("child", idle_timeout_s=3.0))


@cache
def bench() -> Testbench:
    return check_testbench(replace(ward(), people=People(PEOPLE)), "tests")


def wishes(**chosen: str) -> list[Weight]:
    """Weights with which these options are chosen: the start belief, and a belief of each group."""
    options = {START: bench().beliefs.start, **bench().beliefs.groups}
    return [
        (ANY_STATE, ANY_INTERACTION, about, option, float(option == chosen.get(about, option)))
        for about, group in options.items()
        for option in group
    ]


def decided(testbench: Testbench, seed: int, weights: list[Weight]) -> tuple[CaseResult, AbstractTest]:
    """A run in which both decide, and the test that it becomes."""
    empty = concretize(AbstractTest("t", "closure", "t", (), (), seed=seed), testbench.commands)
    people = OnlineRun(roles_of(testbench), testbench.commands, seed, weights)
    result = execute(settings(testbench), empty, producing=people.actions, watching=[people.watcher])
    return result, people.to_test(result)


def settings(testbench: Testbench) -> RunSettings:
    return RunSettings(testbench, load_requirements(testbench.requirements, testbench.vocabulary()))


def again(testbench: Testbench, test: AbstractTest) -> CaseResult:
    return execute(settings(testbench), concretize(test, testbench.commands))


@pytest.mark.parametrize("seed", range(4))
def test_the_test_is_the_same_run_to_the_bit(seed: int) -> None:
    result, test = decided(bench(), seed, [])
    repeated = again(bench(), AbstractTest.from_data(test.to_data()))
    assert repeated.record.sha256 == result.record.sha256
    assert (repeated.action_times_s, repeated.sim_s) == (result.action_times_s, result.sim_s)
    assert result.ending_faults == repeated.ending_faults == ()
    assert test.values[RUN][TURN_WAIT_S] == 0.0
    (read,) = parse_tests(dump_tests([test]), file="t", suite="closure", commands=bench().commands.commands)
    assert again(bench(), read).record.sha256 == result.record.sha256


def test_the_child_waits_until_the_nurse_has_called_it() -> None:
    # With this seed the child has come before the nurse calls.
    result, test = decided(bench(), 10, wishes(start="playful", nurse="watchful"))
    called, out = test.lines.index("nurse: call_out"), test.lines.index("child: step_out")
    assert test.after == {out + 1: (called + 1,)}
    assert result.action_times_s[out] == pytest.approx(
        result.action_times_s[called] + test.values[called + 1]["takes_s"], abs=1e-5
    )
    assert test.values[out + 1][PAUSE_S] == 2e-6
    assert test.plans == {"child": ("listens", "playful"), "nurse": ("watchful",)}
    assert again(bench(), test).record.sha256 == result.record.sha256


def test_what_a_person_waits_for_takes_its_time_in_the_run() -> None:
    # The nurse has called before the child listens: it waits for 5 s.
    result, test = decided(bench(), 22, wishes(start="playful", nurse="watchful"))
    out = test.lines.index("child: step_out")
    assert test.values[out + 1][PAUSE_S] == pytest.approx(5.0, abs=0.03)
    assert again(bench(), test).record.sha256 == result.record.sha256


def test_they_hear_the_run_and_disturbances_come_between_them() -> None:
    hears = (PerceptMapping("warned", "on(near) & near.somebody", source="robot"),)
    people = (PEOPLE[0], InteractiveAgent("child", hears, idle_timeout_s=3.0))
    pushes: list[float] = []
    disturbances = {"push": Disturbance({}, lambda corridor, parameters: pushes.append(corridor.cart_m))}
    testbench = check_testbench(replace(with_robot(), people=People(people), disturbances=disturbances), "tests")
    often: list[Weight] = [(ANY_STATE, ANY_INTERACTION, "disturbance", line, 0.5) for line in ("", "disturb push")]
    result, test = decided(testbench, 1, [*wishes(start="playful", nurse="watchful"), *often])
    assert len(pushes) == test.lines.count("disturb push") > 0
    assert again(testbench, test).record.sha256 == result.record.sha256
    assert len(pushes) == 2 * test.lines.count("disturb push")


def with_robot() -> Testbench:
    """The corridor with a model in which the robot is an agent, too, so that it can say something."""
    made = ward()
    path = made.model.path.with_name("ward_with_robot.mas2j")
    return replace(made, model=replace(made.model, path=path))


def test_a_person_with_nothing_to_do_is_gone_after_a_while() -> None:
    left: list[float] = []

    def patient(run: Run, corridor: object) -> None:
        nurse(run, corridor)  # type: ignore[arg-type]
        left.append(run.kernel.now_s)

    testbench = check_testbench(
        replace(bench(), run=running((patient, *(person for person in [child_who_does_nothing])))), "tests"
    )
    result, test = decided(testbench, 1, wishes(start="shy", nurse="patient"))
    rested_s = test.values[1]["takes_s"]
    assert left == [pytest.approx(rested_s + 2.0, abs=0.03)]
    again(testbench, test)
    assert left[0] == left[1]
    assert result.ending_faults == ()


def child_who_does_nothing(run: Run, corridor: object) -> None:
    """Takes what the child does, and does nothing."""
    for _ in run.actions("child"):
        run.kernel.sleep(0.1)


def test_waiting_is_not_for_the_testbench_to_say() -> None:
    def waiting(run: Run) -> Outcome:
        run.set_idle_handler(lambda: None)
        raise AssertionError

    with pytest.raises(
        TestbenchError, match=r"run\.set_idle_handler: the model has the actors nurse, child, each of which waits"
    ):
        decided(replace(bench(), run=waiting), 1, [])


@pytest.mark.parametrize(
    ("online", "complaint"),
    [
        (
            (InteractiveAgent("nurse"),),
            "people: agents does not have all actors of the model, who decide during a run together; add "
            r"InteractiveAgent\('child'\)",
        ),
        (None, r"people: agents is None; expected a tuple of InteractiveAgent\(...\), one for each actor"),
        (
            (InteractiveAgent("nurse"), InteractiveAgent("chid")),
            "people: agents has 'chid', which is not an actor of the model; nearest: child",
        ),
        (
            (InteractiveAgent("nurse"), InteractiveAgent("nurse"), InteractiveAgent("child")),
            "people: agents has 'nurse' twice; expected one",
        ),
    ],
)
def test_a_declaration_that_is_none_is_refused(online: object, complaint: str) -> None:
    with pytest.raises(TestbenchError, match=complaint):
        check_testbench(replace(ward(), people=People(online)), "tests")  # type: ignore[arg-type]
