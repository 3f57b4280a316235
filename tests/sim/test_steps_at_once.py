"""MuJoCo goes from one control tick to the next in one advance, and everything is as if it had gone step by step."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import pytest

from controller.ports import ARM_JOINTS
from pytest_hricdv.runtime import Record, Recorder
from sim.engine import STEP_S, SimulationError
from sim.world import World
from tests.sampling import mostly_slow

from .stage import Stage, one_leg

pytestmark = pytest.mark.engine("mujoco")


def handed_over(stage: Stage) -> None:
    """A person pulls at a leg and grips the fingers for a while, and carries it away."""
    stage.human(one_leg(grip_s=1.0))
    stage.sensors(1, error_probability=0.05)
    stage.run(lambda: stage.serve(1))


def refused(stage: Stage) -> None:
    """A person does not reach for the leg, which falls into the bin."""
    stage.human(one_leg(at_leg=False))
    stage.sensors(1, error_probability=0.05)
    stage.run(lambda: stage.serve(1))


def torn_out(pull_n: float) -> Callable[[Stage], None]:
    """A pull at a leg that is held out: beyond 15 N the weld gives way, and the leg slides."""

    def body(stage: Stage) -> None:
        def robot() -> None:
            stage.fetch()
            stage.world.unfreeze()
            stage.world.person.pull(pull_n)
            stage.kernel.sleep(0.7)
            stage.world.person.pull(0.0)
            stage.kernel.sleep(1.3)

        stage.run(robot)

    return body


def loosened(stage: Stage) -> None:
    """The grasp weakens while the arm moves: the leg slips out in the middle of a tick."""

    def robot() -> None:
        stage.fetch()
        stage.world.torso.move_arm((0.0,) * len(ARM_JOINTS), 4.0, 0.25)
        stage.world.unfreeze()
        stage.kernel.sleep(1.0)
        held = stage.world.legs.in_hand
        assert held is not None
        held.weaken(5.2)
        stage.kernel.sleep(3.0)

    stage.run(robot)


def stopped(stage: Stage) -> None:
    """Somebody leans in, and the arm stops and goes on, at times that are no ticks."""

    def robot() -> None:
        stage.world.torso.move_arm((0.15,) * len(ARM_JOINTS), 2.0, 0.25)
        for sleep_s in (0.513, 0.007, 0.091):
            stage.kernel.sleep(sleep_s)
            stage.world.torso.stop_arm()
            stage.kernel.sleep(sleep_s)
            stage.world.torso.move_arm((0.1,) * len(ARM_JOINTS), 1.0, 0.1)
            stage.world.unfreeze()
        stage.kernel.sleep(2.0)

    stage.run(robot)


def recorded(act: Callable[[Stage], None], *, freeze: bool) -> Record:
    """What is recorded of a run."""
    with Stage(freeze=freeze) as stage:
        act(stage)
        return stage.recorder.finish()


CASES = {
    "handed over": handed_over,
    "refused": refused,
    "pulled at": torn_out(14.0),
    "nearly torn out": torn_out(15.2),
    "torn out": torn_out(25.0),
    "loosened": loosened,
    "stopped": stopped,
}


@pytest.mark.parametrize("freeze", [True, False])
@pytest.mark.parametrize("name", mostly_slow(CASES.keys(), 5))
def test_records_are_those_of_single_steps(name: str, freeze: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    at_once = recorded(CASES[name], freeze=freeze)
    monkeypatch.setattr(World, "_steps_at_once", lambda world, at_most: 1)
    assert recorded(CASES[name], freeze=freeze).sha256 == at_once.sha256


def test_speeds_are_recorded_at_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    recorder = Recorder()
    with World(recorder) as world:
        world.torso.move_arm((0.1,) * len(ARM_JOINTS), 1.0, 0.4)
        world.advance(400_000)
    times_s = [time_s for time_s in recorder.finish().signals["arm_speed"][0] if 0.1 < time_s < 0.4]
    assert max(later - earlier for earlier, later in pairwise(times_s)) < 1.5 * STEP_S


def test_a_state_that_became_nan_within_an_advance_is_said_at_its_step() -> None:
    with World(Recorder(), freeze=False) as world:
        world.advance(100_000)
        servos = world.torso.drive
        tell, calls = servos.tell, []  # type: ignore[attr-defined]

        def telling() -> None:
            calls.append(world.time.step)
            if len(calls) == 4:
                world.engine.set_joints(world.torso.body, [0], [float("nan")])
            tell()

        servos.settled, servos.tell = False, telling  # type: ignore[attr-defined]
        with pytest.raises(SimulationError, match=r"at 0\.1250 s: .*(Nan|nan)"):  # after three steps of a tick
            world.advance(200_000)
