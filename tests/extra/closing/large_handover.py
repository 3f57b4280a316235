"""A handover of the table's size without a simulation: four legs, three sensors, and 27 disturbances.

Most disturbances are without effect. Beside the bins, it has statements that need one disturbance, one that needs it
before the first command, and one beyond that, which needs two there; and a requirement that is checked where all four
legs are released.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import pairwise, product
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.disturbance_strategy import DisturbanceStrategy
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.loop import Loop, OnlineTests
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy, ModelStrategy
from pytest_hricdv.extra.closing.nearest_strategy import NearestStrategy
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.pool import Combination, Intervention, Pool, combinations_of, commands_of, starts_of
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.rng import make_rng, pick
from pytest_hricdv.generate.sampler import Sampler, Uniform

POSES = tuple("".join(bits) for bits in product("01", repeat=3))
STANDS = (*POSES, "none")
OUTCOMES = ("released", "discarded", "silent", "timeout")
LEGS = (1, 2, 3, 4)
SPACE = BeliefSpace(
    start=tuple(f"legs{legs}" for legs in LEGS),
    groups={"boredom": ("bored", "not_bored")}
    | {f"leg {leg}": tuple(f"s{pose}n{leg}" for pose in STANDS) for leg in LEGS},
)
FLIPS = ("gaze_flips", "grip_flips", "place_flips")
NOISES = tuple(f"noise{number}" for number in range(12))
DISTURBANCES: Mapping[str, Mapping[str, Sampler]] = {
    **{name: {} for name in (*FLIPS, "ready_lost", "falls_silent", "request_lost", "leg_in_hand", "held_shut")},
    "sensors_silent": {"for_s": Uniform(5.0, 150.0)},
    "sensors_late": {"late_s": Uniform(0.5, 110.0)},
    "sensors_stuck": {"for_s": Uniform(5.0, 150.0)},
    "says_ready": {"after_s": Uniform(0.0, 15.0)},
    "ready_late": {"delay_s": Uniform(1.0, 20.0)},
    "asks_again": {"after_s": Uniform(0.0, 40.0)},
    "leg_late": {"for_s": Uniform(1.0, 120.0)},
    **{name: {"level": Uniform(0.0, 1.0)} for name in NOISES},
}
ALL_RELEASED = ("verdict", "R5", "Passed")
ERROR = 0.05
"""Probability that a sensor is wrong."""


def planned(commands: Sequence[str]) -> tuple[Bin, ...]:
    """For each request: how many legs are asked for in the whole test, whether the person is bored, and the pose."""
    asked = [place for place, command in enumerate(commands) if command == "ask"]
    turns = [commands[begin:end] for begin, end in pairwise([*asked, len(commands)])]
    legs = str(sum("leave" not in turn for turn in turns))
    return tuple((legs, "bored" if "leave" in turn else "not_bored", _pose(turn)) for turn in turns)


def _pose(turn: Sequence[str]) -> str:
    return "".join(command[-1] for command in turn if "=" in command) if "ready" in turn else "none"


@cache
def pool() -> Pool:
    """All tests; a bored person leaves at the first request, and comes back."""
    runs, bits = [], SPACE.bits
    for boredom, legs in product(("not_bored", "bored"), LEGS):
        for stands in product(STANDS, repeat=legs):
            lines = ["ask", "receive", "leave"] if boredom == "bored" else []
            beliefs = bits[f"legs{legs}"] | bits[boredom]
            for leg, pose in enumerate(stands, 1):
                sets = [f"set {name} = {bit}" for name, bit in zip(("gaze", "grip", "place"), pose, strict=False)]
                lines += ["ask", "receive", *([*sets, "ready"] if pose != "none" else ())]
                beliefs |= bits[f"s{pose}n{leg}"]
            runs.append(ExploredRun(tuple(lines), 1, beliefs))
    return Pool(Exploration((("person", "asks"),), SPACE.beliefs, tuple(runs)), SPACE, {"handover": planned})


def wanted() -> Iterator[Point]:
    """The bins and statements."""
    stands = [("not_bored", pose) for pose in STANDS] + [("bored", "none")]
    yield from (("bin", "handover", str(legs), *stand, end) for legs in LEGS for stand in stands for end in OUTCOMES)
    yield from (("statement", "robot.py", str(line)) for line in (*range(1, len(NOISES) + 1), 20, 21))
    yield ALL_RELEASED


def run(test: AbstractTest) -> RunObservation:
    """One run: what happens is a function of the test and its seed."""
    rng, plans = make_rng("large handover", test.seed), planned(commands_of(test.lines))
    combinations = combinations_of(test.lines, test.values, starts_of(commands_of(test.lines), planned))
    timeout_s = dict(test.values.get(RUN, {})).get("timeout_s", 10.0 + 90.0 * rng.random())
    points = set(_statements(combinations))
    hits: list[Bin] = []
    readings: list[Bin] = []
    for plan, combination in zip(plans, combinations, strict=True):
        reading, outcome = _end(plan[2], combination, timeout_s, [rng.random() for _ in FLIPS])
        readings.append((reading, outcome))
        hits.append((*plan, outcome))
    points |= {("bin", "handover", *hit) for hit in hits}
    missing = max(len(LEGS) - sum(hit[-1] == "released" for hit in hits), 0)
    if not missing:
        points.add(ALL_RELEASED)
    # Before all legs are done, nothing tells how many are missing.
    distances = ((ALL_RELEASED, missing / (1.0 + missing) if plans[0][0] == "4" else 2.0),) if missing else ()
    ends = {"decision": tuple(readings), "handover": tuple(hits)}
    return RunObservation(test.to_data(), tuple(sorted(points)), ends, distances, sim_s=30.0 * len(plans))


def _statements(combinations: Sequence[Combination]) -> Iterator[Point]:
    for intervention in (intervention for combination in combinations for intervention in combination):
        if intervention.name in NOISES and dict(intervention.values)["level"] > 0.3:
            number = NOISES.index(intervention.name)
            if intervention.place > number % 3:
                yield "statement", "robot.py", str(number + 1)
    at_the_start = {intervention.name for intervention in combinations[0] if intervention.place == 0}
    if "leg_in_hand" in at_the_start:
        yield "statement", "robot.py", "20"
        if "held_shut" in at_the_start:
            yield "statement", "robot.py", "21"


def _end(pose: str, combination: Combination, timeout_s: float, chances: Sequence[float]) -> Bin:
    """The reading, and how the handover ends."""
    values = {intervention.name: dict(intervention.values) for intervention in combination}
    places = {intervention.name: intervention.place for intervention in combination}
    if places.get("request_lost") == 1 or values.get("leg_late", {}).get("for_s", 0.0) > 60.0:
        return "none", "discarded"
    is_late = values.get("ready_late", {}).get("delay_s", 0.0) > 13.0
    is_ready = pose != "none" and not is_late and not {"ready_lost", "falls_silent"} & {*values}
    if not is_ready and (not places.get("says_ready") or values["says_ready"]["after_s"] < 3.0):
        return "none", "silent"
    silent_s = values["sensors_silent"]["for_s"] if places.get("sensors_silent", 0) > 1 else 0.0
    if max(silent_s, values.get("sensors_late", {}).get("late_s", 0.0)) > timeout_s + 12.0:
        return "none", "timeout"
    sensors = [bit == "1" and chance >= ERROR for bit, chance in zip(pose.replace("none", "000"), chances, strict=True)]
    sensors = [sensor != (name in values) for sensor, name in zip(sensors, FLIPS, strict=True)]
    return "".join(str(int(sensor)) for sensor in sensors), "released" if all(sensors) else "discarded"


def runner(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
    """Runs tests one by one."""
    return ((number, run(test)) for number, test in enumerate(tests))


class RandomStrategy:
    """Takes the place of people who decide during the run: any test, with a disturbance in half of its interactions."""

    name = "online"

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        return [self._propose(rng) for _ in range(count)]

    def _propose(self, rng: Random) -> Proposal:
        number = pool().any(rng)
        sizes = pool().sizes(number, "handover")
        combinations = [(_draw(size, rng),) if rng.random() < 0.5 else () for size in sizes]
        return Proposal(pool().draft(number, "handover", combinations), self.name)


def _draw(commands: int, rng: Random) -> Intervention:
    name = pick(rng, [*DISTURBANCES])
    values = tuple((parameter, sampler.sample(rng)) for parameter, sampler in sorted(DISTURBANCES[name].items()))
    return Intervention(pick(rng, range(commands + 1)), name, values)


def loop(seed: int) -> Loop:
    """A loop as a session has it."""
    experience = Experience(pool())
    strategies = (
        ModelStrategy(pool(), experience),
        DisturbanceStrategy(pool(), experience, DISTURBANCES),
        NearestStrategy(pool(), DISTURBANCES),
        RandomStrategy(),
    )
    return Loop(Archive(wanted()), strategies, runner, seed, Budget(400), fallback=FallbackStrategy(pool()))
