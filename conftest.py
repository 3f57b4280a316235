"""The table-assembly testbench, handed to the plugin: copy this file and change it for your own robot."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pytest_hricdv.case import Run
    from pytest_hricdv.testbench import Outcome, Testbench

HERE = Path(__file__).parent
LIMIT_S = 300.0
SENSOR_ERROR = 0.05

pytest_plugins = ["pytester"]


def pytest_hricdv_testbench(config: pytest.Config) -> Testbench:
    """Hands the testbench over. Imports stay inside: a run without a suite pays for none of this."""
    from controller.journal import OUTCOMES
    from controller.ports import MESSAGES
    from pytest_hricdv.testbench import BeliefSpace, Chance, Concretization, CrossProduct, Model, Range, Testbench

    poses = tuple("".join(bits) for bits in product("01", repeat=3))
    speech, side = Range(2.0, 3.0, "s"), Range(-1.0, 1.0, "side")
    at_leg, off = Range(-0.03, 0.03, "m"), Range(0.5, 0.75, "m")
    commands = {
        "tell leg": {
            "voice_s": Range(3.0, 5.0, "s"),
            "rest_x_m": Range(0.25, 0.90, "m"),
            "rest_y_m": Range(-0.45, 0.30, "m"),
            "rest_z_m": Range(0.47, 0.70, "m"),
        },
        "receivesignal": {},
        "set_param gaze = 1": {
            "offset_m": Range(0.1, 0.2, "m"),
            "distance_m": Range(0.5, 0.6, "m"),
            "angle_deg": Range(15.0, 40.0, "deg", open_high=True),
            "side": side,
        },
        "set_param gaze = 0": {
            "offset_m": Range(0.2, 0.5, "m"),
            "distance_m": Range(0.6, 0.8, "m"),
            "angle_deg": Range(40.0, 50.0, "deg"),
            "side": side,
        },
        "set_param location = 1": {"dx_m": at_leg, "dy_m": at_leg, "dz_m": at_leg},
        "set_param location = 0": {"dx_m": off, "dy_m": off, "dz_m": off},
        "set_param pressure = 1": {"pull_n": Range(6.0, 10.0, "N"), "grip_s": Chance(0.02, Range(8.0, 14.0, "s"))},
        "set_param pressure = 0": {},
        "tell humanReady": {"voice_s": speech},
        "bored": {},
    }
    readings = (*poses, "none")
    timeouts = {(pose, outcome): "a turn that timed out has no reading" for pose in poses for outcome in OUTCOMES[2:]}
    return Testbench(
        name="table-assembly",
        model=Model(HERE / "models_bdi" / "table_assembly.mas2j"),
        beliefs=BeliefSpace(
            start=("leg1", "leg2", "leg3", "leg4"),
            groups={"boredom": ("bored", "not_bored")}
            | {f"leg {leg}": tuple(f"m{pose}l{leg}" for pose in poses) for leg in range(1, 5)},
            naming=("boredom",),
            neutral=("not_bored",),
        ),
        concretization=Concretization(
            commands=commands,
            run={
                "sensing_timeout_s": Range(10.0, 100.0, "s"),
                "outage_turn": Chance(0.04, Range(1.0, 5.0, "turn", open_high=True)),
            },
        ),
        requirements=HERE / "tests" / "hri" / "requirements.toml",
        messages=MESSAGES,
        signals={
            "leg_held": bool,
            "leg_offset": float,
            "hand_closing": bool,
            "hand_distance": float,
            "arm_speed": float,
        },
        code=("controller",),
        run=run,
        by_hand=HERE / "tests" / "hri" / "by_hand.toml",
        cross=CrossProduct({"reading": readings, "outcome": OUTCOMES}, impossible=timeouts),
    )


def run(run: Run) -> Outcome:
    """Builds world, person, sensors and controller around one test, and runs it."""
    from controller import machine
    from controller.ports import State
    from controller.robot import Robot as Controller
    from controller.settings import Settings
    from pytest_hricdv.testbench import Outcome
    from sim.human import Human
    from sim.robot import Robot
    from sim.sensors import Sensors
    from sim.world import World

    kernel, test = run.kernel, run.test
    with World(run.recorder) as world:
        kernel.world = world
        robot = Robot(kernel, world)
        script = [(action.command, action.parameters) for action in test.actions]
        human = Human(world, run.bus.port("human"), kernel, script)
        sensors = Sensors(
            world, run.bus.port("sensors"), kernel, test.seed, SENSOR_ERROR, int(test.run["outage_turn"])
        )
        settings = Settings(sensing_timeout_s=test.run["sensing_timeout_s"])

        def control() -> None:
            machine.run(Controller(run.bus.port("robot"), robot.clock, robot.arm, robot.hand, settings))

        def finish() -> None:
            kernel.stop("table done")

        def watch() -> None:
            states = run.bus.subscribe(State)
            while True:
                state = states.wait(LIMIT_S)
                if state is not None and state.name == "Timeout1" and human.done:
                    kernel.stop("nobody asks any more")

        measured = run.measured(control)
        kernel.spawn("robot", lambda: (measured(), finish()) and None)
        kernel.spawn("human", human.enact)
        kernel.spawn("sensors", sensors.sense)
        kernel.spawn("end", watch)
        ended = run.go(LIMIT_S)
        frozen_s = world.frozen_s
    return Outcome(ended, legs_of(run), frozen_s, readings_by_outcome(run))


def legs_of(run: Run) -> tuple[str, ...]:
    return tuple(str(m.fields["outcome"]) for m in run.recorder.messages if m.topic == "turn_done")


def readings_by_outcome(run: Run) -> tuple[tuple[str, ...], ...]:
    hits, reading = [], "none"
    for message in run.recorder.messages:
        if message.topic == "reading":
            reading = "".join(str(int(bool(message.fields[name]))) for name in ("gaze", "pressure", "location"))
        elif message.topic == "turn_done":
            hits.append((reading, str(message.fields["outcome"])))
            reading = "none"
    return tuple(hits)
