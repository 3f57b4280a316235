"""A handover without a simulation: people ask for one to four parts, stand as they do, and things go wrong.

It has what makes aiming hard: an outcome depends on what is planned, on several disturbances at once, on their
parameters, and a little on chance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.loop import OnlineTests
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.pool import Combination, combinations_of, commands_of, starts_of
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.sampler import Sampler, Uniform

POSES = tuple("".join(bits) for bits in product("01", repeat=2))
OUTCOMES = ("given", "kept", "silent", "late")
PARTS = (1, 2, 3)

SPACE = BeliefSpace(
    start=tuple(f"parts{count}" for count in PARTS),
    groups={f"part {number}": tuple(f"p{pose}n{number}" for pose in POSES) for number in PARTS},
)

DISTURBANCES: Mapping[str, Mapping[str, Sampler]] = {
    "flip": {"sensor": Uniform(0.0, 2.0, open_high=True), "for_s": Uniform(0.0, 10.0)},
    "ready_lost": {},
    "mute": {"for_s": Uniform(0.0, 20.0)},
    "noise": {"level": Uniform(0.0, 1.0)},
    "shake": {},
    "light": {"lux": Uniform(0.0, 1.0)},
}

ERROR = 0.05
"""Probability that a sensor is wrong."""

TURN = ("ask", "look", "pull", "ready")


def planned(commands: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """For each request: how many parts are asked for in the whole test, and the pose."""
    asked = str(commands.count("ask"))
    poses = ["" for command in commands if command == "ask"]
    number = -1
    for command in commands:
        if command == "ask":
            number += 1
        elif "=" in command and number >= 0:
            poses[number] += command[-1]
    return tuple((asked, pose.ljust(2, "0")) for pose in poses)


def exploration() -> Exploration:
    """All tests."""
    runs, bits = [], SPACE.bits
    for count in PARTS:
        for poses in product(POSES, repeat=count):
            lines: list[str] = []
            beliefs = bits[f"parts{count}"]
            for number, pose in enumerate(poses, 1):
                lines += ["ask", f"set gaze = {pose[0]}", f"set grip = {pose[1]}", "ready"]
                beliefs |= bits[f"p{pose}n{number}"]
            runs.append(ExploredRun(tuple(lines), 1, beliefs))
    return Exploration((("person", "asks"),), SPACE.beliefs, tuple(runs))


BINS: tuple[Bin, ...] = tuple((str(count), pose, outcome) for count in PARTS for pose in POSES for outcome in OUTCOMES)
WANTED: tuple[Point, ...] = (
    *(("bin", "handover", *each) for each in BINS),
    ("statement", "robot.py", "9"),
    ("verdict", "R5", "Passed"),
)


def run(test: AbstractTest) -> RunObservation:
    """One run: what happens is a function of the test and its seed."""
    rng = make_rng("handover", test.seed)
    commands = commands_of(test.lines)
    combinations = combinations_of(test.lines, test.values, starts_of(commands, planned))
    interactions = [*zip(planned(commands), combinations, strict=True)]
    readings, hits = [], []
    for each in interactions:
        reading, outcome = _outcome(*each, [rng.random() for _ in range(3)])
        readings.append((reading, outcome))
        hits.append((*each[0], outcome))
    points: set[Point] = {("bin", "handover", *hit) for hit in hits}
    if any(
        intervention.name == "shake" and intervention.place == 2
        for combination in combinations
        for intervention in combination
    ):
        points.add(("statement", "robot.py", "9"))
    given = sum(hit[-1] == "given" for hit in hits)
    distance = 3.0 - given
    if not distance:
        points.add(("verdict", "R5", "Passed"))
    return RunObservation(
        test.to_data(),
        tuple(sorted(points)),
        {"decision": tuple(readings), "handover": tuple(hits)},
        ((("verdict", "R5", "Passed"), distance),) if distance else (),
        sim_s=30.0 * len(interactions),
    )


def runner(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
    """Runs tests one by one."""
    return ((number, run(test)) for number, test in enumerate(tests))


def _outcome(stands: Bin, combination: Combination, chances: Sequence[float]) -> tuple[str, str]:
    sensors = [digit == "1" for digit in stands[1]]
    sensors = [sensor and chance >= ERROR for sensor, chance in zip(sensors, chances, strict=False)]
    names = {intervention.name: (intervention.place, dict(intervention.values)) for intervention in combination}
    for intervention in combination:
        values = dict(intervention.values)
        if intervention.name == "flip" and intervention.place >= 2 and values["for_s"] > 3.0:
            sensors[int(values["sensor"])] ^= True
    if "ready_lost" in names and names["ready_lost"][0] <= 3:
        return "none", "silent"
    if ("mute" in names and names["mute"][1]["for_s"] > 12.0) or chances[2] < ERROR / 2:
        return "none", "late"
    return "".join(str(int(sensor)) for sensor in sensors), "given" if all(sensors) else "kept"
