"""The F16 of ARCH-COMP, flown by a clone of AeroBenchVVPython. It is GPL: nothing of it is in this repository."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from itertools import product
from math import pi, radians
from pathlib import Path
from subprocess import run

from pytest_hricdv.generate.concrete import ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Uniform
from pytest_hricdv.monitor import Log
from studies.falsification.search import FalsificationProblem, requirement_on

SOURCE = "https://github.com/stanleybak/AeroBenchVVPython"
COMMIT = "afa9f0a062054bd8857b84c434f6288d05f30292"

DURATION_S = 15.0
STEP_S = 1 / 30
"""Between two samples: the default of the simulation. The autopilot decides at samples, so it matters."""
SPEED_FT_S = 540.0
ANGLE_OF_ATTACK = radians(2.1215)
POWER = 9.0

ROLL = Uniform(pi / 4 - pi / 20, pi / 4 + pi / 30)
PITCH = Uniform(-0.4 * pi, -0.35 * pi)
YAW = Uniform(-pi / 4 - pi / 8, -pi / 4 + pi / 8)

SPACE = Concretization({"start": {"roll_rad": ROLL, "pitch_rad": PITCH, "yaw_rad": YAW}})

START_FT = 2338
"""That of the competition of 2024."""
SURVEYED_FT = (4040, START_FT, 2330)
"""Other public sources begin at the first, or the last."""

REQUIREMENT = requirement_on(
    ("t", "altitude"), "F16", f"G[0,15] altitude > 0, from {START_FT} ft", "always(t >= 0 -> altitude > 0)"
)

Flight = Callable[[float, Sequence[float], float], tuple[Sequence[float], Sequence[float]]]
"""Flies from an altitude (ft), with a roll, a pitch and a yaw (rad), in steps (s): times (s), altitudes (ft)."""


def flight(clone: Path) -> Flight:
    """The simulation of a clone. Raises SystemExit: it is none, or not at `COMMIT`."""
    head = run(["git", "-C", clone, "rev-parse", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    if head != COMMIT:
        raise SystemExit(f"--f16={clone}: expected a clone of {SOURCE} at {COMMIT}, but found {head or 'no clone'}")
    sys.path.insert(0, str(clone / "code"))
    simulate = import_module("aerobench.run_f16_sim").run_f16_sim
    autopilot = import_module("aerobench.examples.gcas.gcas_autopilot").GcasAutopilot

    def fly(start_ft: float, attitude_rad: Sequence[float], step_s: float) -> tuple[Sequence[float], Sequence[float]]:
        state = [SPEED_FT_S, ANGLE_OF_ATTACK, 0.0, *attitude_rad, *(0.0,) * 5, start_ft, POWER]
        flown = simulate(state, DURATION_S, autopilot(init_mode="roll"), step=step_s)
        return flown["times"], flown["states"][:, 11].tolist()

    return fly


def falsification_problem(fly: Flight) -> FalsificationProblem:
    """What is searched."""

    def log(test: ConcreteTest) -> Log:
        parameters = test.actions[0].parameters
        times_s, altitudes_ft = fly(START_FT, [parameters[name] for name in SPACE.commands["start"]], STEP_S)
        return Log({"t": (times_s, times_s), "altitude": (times_s, altitudes_ft)}, (), times_s[-1])

    return FalsificationProblem(REQUIREMENT, SPACE, 1, log)


def survey(fly: Flight) -> Iterator[tuple[float, float, float, int, int]]:
    """Initial altitude (ft), step (s), and over a grid of roll and pitch: the lowest altitude (ft), crashes, points.

    The yaw is that of the middle, as it changes nothing.
    """
    shares = [number / 12 for number in range(13)]
    for start_ft, step_s in product(SURVEYED_FT, (STEP_S, 0.01)):
        lowest = [
            min(fly(start_ft, [_at(ROLL, one), _at(PITCH, other), _at(YAW, 0.5)], step_s)[1])
            for one, other in product(shares, repeat=2)
        ]
        yield start_ft, step_s, min(lowest), sum(altitude <= 0 for altitude in lowest), len(lowest)


def _at(limits: Uniform, share: float) -> float:
    return limits.high * share + limits.low * (1 - share)
