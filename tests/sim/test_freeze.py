"""Freezing changes nothing that matters; a run is a function of its inputs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from pytest_hricdv.runtime import Record
from tests.sampling import mostly_slow

from .stage import Stage, Step, handover, one_leg

SCRIPTS = {
    "released": one_leg(),
    "gripped": one_leg(grip_s=6.0),
    "not reached for": one_leg(at_leg=False),
    "bored": [*one_leg()[:2], ("bored", {}), *one_leg()],
}


def value_at(record: Record, name: str, time_s: float) -> float:
    times, values = record.signals[name]
    return max((t, v) for t, v in zip(times, values, strict=True) if t <= time_s)[1]


@pytest.mark.parametrize("script", mostly_slow({name: (script,) for name, script in SCRIPTS.items()}, 3))
def test_messages_and_signals_are_the_same_without_freezing(script: Sequence[Step]) -> None:
    turns = sum(command == "tell leg" for command, _ in script)
    frozen, stage = handover(script, turns)
    stepped, other = handover(script, turns, freeze=False)
    assert stage.world.frozen_s > 10.0
    assert other.world.frozen_s == 0.0
    assert [str(m) for m in frozen.messages] == [str(m) for m in stepped.messages]
    for name in ("leg_held", "hand_closing"):
        assert frozen.signals[name] == stepped.signals[name]
    closing = [t for t, v in zip(*frozen.signals["hand_closing"], strict=True) if v]
    released = [t for t, v in zip(*frozen.signals["leg_held"], strict=True) if not v]
    for time_s in closing:
        assert value_at(frozen, "hand_distance", time_s) == value_at(stepped, "hand_distance", time_s)
    for time_s in released:
        assert value_at(frozen, "leg_offset", time_s) == pytest.approx(
            value_at(stepped, "leg_offset", time_s), abs=1e-6
        )
    assert max(frozen.signals["arm_speed"][1]) == pytest.approx(max(stepped.signals["arm_speed"][1]), rel=1e-6)


def test_equal_inputs_give_equal_runs_even_after_another_world() -> None:
    script = one_leg() + one_leg(at_leg=False)
    first, _ = handover(script, turns=2)
    between, _ = handover(one_leg(rest={"rest_x_m": 0.5, "rest_y_m": -0.3, "rest_z_m": 0.6}), turns=1, seed=5)
    again, _ = handover(script, turns=2)
    assert first.sha256 == again.sha256
    assert between.sha256 != first.sha256


def test_another_process_gives_an_equal_run(engine_name: str) -> None:
    here, _ = handover(one_leg(), turns=1)
    code = f"import sim.engines; sim.engines._first_installed = lambda: {engine_name!r}; "
    code += "from tests.sim.stage import handover, one_leg; print(handover(one_leg(), turns=1)[0].sha256)"
    root = Path(__file__).parents[2]
    there = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert there.stdout.strip() == here.sha256


def test_time_passes_while_frozen_and_people_still_move() -> None:
    with Stage() as stage:
        hand = stage.world.person.hand

        def wait() -> None:
            stage.kernel.sleep(5.0)
            assert stage.world.frozen_s > 4.0
            frozen_s = stage.world.frozen_s
            took_s = hand.move((0.7, 0.0, 0.6))
            stage.kernel.sleep(took_s / 2)
            middle = hand.pose()[0]
            assert 0.7 < middle[0] < 0.92
            stage.kernel.sleep(took_s / 2)
            assert hand.pose()[0] == pytest.approx((0.7, 0.0, 0.6))
            assert stage.world.frozen_s > frozen_s

        assert stage.run(wait) == "over"
