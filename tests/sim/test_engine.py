"""Wrong ids and numbers are errors, never empty answers; one world at a time; nothing printed."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator

import pytest

from controller.waypoints import HOME
from pytest_hricdv.runtime import Recorder
from sim.engine import SimulationError
from sim.geometry import UPRIGHT
from sim.world import World

from .memory import resident_kb
from .stage import Stage

NAN = math.nan


@pytest.fixture
def world() -> Iterator[World]:
    with World(Recorder()) as world:
        yield world


@pytest.mark.parametrize("bad", [NAN, math.inf])
def test_numbers_that_are_not_finite_never_reach_physics(world: World, bad: float) -> None:
    leg = world.legs.current
    with pytest.raises(SimulationError, match="finite"):
        world.torso.move_arm((bad, *HOME[1:]), 1.0)
    with pytest.raises(SimulationError, match="finite"):
        world.torso.move_arm(HOME, bad)
    with pytest.raises(SimulationError, match="finite"):
        world.fingers.push(2, bad)
    with pytest.raises(SimulationError, match="finite"):
        world.person.hand.move((bad, 0.0, 0.0))
    with pytest.raises(SimulationError, match="finite"):
        world.person.pull(bad)
    with pytest.raises(SimulationError, match="finite"):
        leg.pull((0.0, bad, 0.0))
    with pytest.raises(SimulationError, match="finite"):
        world.engine.place(leg.body, ((0.0, 0.0, bad), UPRIGHT))


def test_a_state_that_became_nan_stops_the_run_and_says_when(monkeypatch: pytest.MonkeyPatch) -> None:
    with Stage(freeze=False) as stage:
        monkeypatch.setattr(stage.world.torso, "arm_speeds", lambda: [NAN])
        with pytest.raises(ValueError, match=r"arm_speed is nan at 0\.0"):
            stage.run(lambda: stage.kernel.sleep(1.0))


def test_one_world_at_a_time(world: World) -> None:
    with pytest.raises(SimulationError, match="close it first"):
        World(Recorder())
    world.close()
    world.close()
    with World(Recorder()):
        pass


def test_importing_and_building_is_silent_in_a_process_of_its_own() -> None:
    code = "from sim.world import World; from pytest_hricdv.runtime import Recorder; World(Recorder()).close()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


@pytest.mark.parametrize(("library", "module"), [("pybullet", "sim.bullet.engine"), ("mujoco", "sim.mujoco.engine")])
def test_a_missing_engine_names_the_extra(library: str, module: str) -> None:
    code = f"import sys; sys.modules[{library!r}] = None; import {module}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert 'pip install "pytest-hricdv[sim]"' in done.stderr


@pytest.mark.slow
def test_a_world_that_is_closed_leaves_no_memory_behind(engine_name: str) -> None:
    for _ in range(300):  # after so many, what was freed is used again
        World(Recorder()).close()
    before_kb = resident_kb()
    for _ in range(120):
        World(Recorder()).close()
    # Each lost 80 kB while PyBullet merged the links; of MuJoCo's models, of other sizes each time, gaps are left.
    assert resident_kb() - before_kb < 120 * {"pybullet": 20, "mujoco": 40}[engine_name]
