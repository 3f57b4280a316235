"""Handovers that differ in all that a testbench may differ in: to judge the loop by many, and not by one.

Each is drawn from its number: how many sensors there are, how often they err, which disturbances do what, where in an
interaction, and with which parameters; most do nothing. Some targets take several interventions, one of them masked.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.disturbance_strategy import DisturbanceStrategy
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interactions import Combination, combinations_of, commands_of, starts_of
from pytest_hricdv.extra.closing.loop import Loop, OnlineTests
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy, ModelStrategy
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.rng import make_rng, pick, random_index
from pytest_hricdv.generate.sampler import Sampler, Uniform

PARTS = {2: 3, 3: 2}
"""Sensors -> how many parts are asked for at most: so that there are some 80 abstract tests."""

STRENGTH: dict[str, Sampler] = {"strength": Uniform(0.0, 1.0)}


@dataclass(frozen=True)
class Rule:
    """What a disturbance does: something, after so many commands, from a strength on."""

    does: str
    place: int
    strength: float


@dataclass(frozen=True)
class Scene:
    """One such handover."""

    number: int

    @cached_property
    def _rng(self) -> Random:
        return make_rng("scene", self.number)

    @cached_property
    def sensors(self) -> int:
        """How many sensors there are; a person stands so that some of them see it."""
        return pick(self._rng, (2, 3))

    @cached_property
    def error(self) -> float:
        """Probability that a sensor that sees something does not say so."""
        return pick(self._rng, (0.0, 0.02, 0.05, 0.1))

    @cached_property
    def rules(self) -> dict[str, Rule]:
        """Disturbance -> what it does: for each sensor one that flips it, some others, and many that do nothing."""
        _ = self.sensors, self.error
        does = [f"flip{sensor}" for sensor in range(self.sensors)] + ["silence", "delay", "drop", "pull", "crash"]
        does += [pick(self._rng, ("nothing", "noise")) for _ in range(random_index(self._rng, 8))]
        return {
            f"{name}": Rule(does_, 1 + random_index(self._rng, self.sensors + 1), 0.6 * self._rng.random())
            for name, does_ in zip("abcdefghijklmnopqrst", does, strict=False)
        }

    @property
    def disturbances(self) -> dict[str, dict[str, Sampler]]:
        """As a testbench declares them."""
        return dict.fromkeys(self.rules, STRENGTH)

    @cached_property
    def poses(self) -> tuple[str, ...]:
        """What sensors would say if they did not err."""
        return tuple("".join(bits) for bits in product("01", repeat=self.sensors))

    @cached_property
    def space(self) -> BeliefSpace:
        """How many parts a person asks for, and how they stand each time."""
        counts = range(1, PARTS[self.sensors] + 1)
        groups = {f"part {number}": tuple(f"p{pose}n{number}" for pose in self.poses) for number in counts}
        return BeliefSpace(start=tuple(f"parts{count}" for count in counts), groups=groups)

    @cached_property
    def exploration(self) -> Exploration:
        """All abstract tests."""
        runs, bits = [], self.space.bits
        for count in range(1, PARTS[self.sensors] + 1):
            for poses in product(self.poses, repeat=count):
                lines: list[str] = []
                beliefs = bits[f"parts{count}"]
                for number, pose in enumerate(poses, 1):
                    lines += ["ask", *(f"set {place} = {bit}" for place, bit in enumerate(pose)), "ready"]
                    beliefs |= bits[f"p{pose}n{number}"]
                runs.append(ExploredRun(tuple(lines), 1, beliefs))
        return Exploration((("person", "asks"),), self.space.beliefs, tuple(runs))

    def planned(self, commands: Sequence[str]) -> tuple[Bin, ...]:
        """For each request: how many parts are asked for in all, and the pose."""
        asked = str(commands.count("ask"))
        poses: list[str] = []
        for command in commands:
            if command == "ask":
                poses.append("")
            elif "=" in command and poses:
                poses[-1] += command[-1]
        return tuple((asked, pose.ljust(self.sensors, "0")) for pose in poses)

    @cached_property
    def targets(self) -> tuple[Point, ...]:
        """All can be hit."""
        ends = ("given", "kept", "silent", "late", "dropped")
        counts = map(str, range(1, PARTS[self.sensors] + 1))
        bins = (("bin", "handover", *each) for each in product(counts, self.poses, ends))
        full = "1" * self.sensors
        readings = [(pose, "kept") for pose in self.poses if pose != full]
        readings += [(full, "given"), (full, "dropped"), ("none", "silent"), ("none", "late")]
        statements = (("statement", "robot.py", line) for line in ("9", "11", "13"))
        return (*bins, *(("bin", "reading", *each) for each in readings), *statements, ("verdict", "R5", "Passed"))

    def run(self, test: AbstractTest) -> RunObservation:
        """One run: what happens is a function of the test and its seed."""
        rng = make_rng("scene", self.number, test.seed)
        commands = commands_of(test.lines)
        combinations = combinations_of(test.lines, test.values, starts_of(commands, self.planned))
        points: set[Point] = set()
        readings, hits = [], []
        for number, (planned, combination) in enumerate(zip(self.planned(commands), combinations, strict=True)):
            done = self._done(combination)
            reading, end = self._end(planned[1], done, rng)
            readings.append((reading, end))
            hits.append((*planned, end))
            if "crash" in done:
                points.add(("statement", "robot.py", "9"))
            if number == 0 and any(self.rules[name].does == "silence" and not place for place, name, _ in combination):
                points.add(("statement", "robot.py", "11"))
            if end == "given" and "pull" in done:  # which only a sensor that is wrong can mask
                points.add(("statement", "robot.py", "13"))
        points |= {("bin", "handover", *hit) for hit in hits} | {("bin", "reading", *each) for each in readings}
        distance = float(PARTS[self.sensors] - sum(hit[-1] == "given" for hit in hits))
        if not distance:
            points.add(("verdict", "R5", "Passed"))
        return RunObservation(
            test.to_data(),
            tuple(sorted(points)),
            {"reading": tuple(readings), "handover": tuple(hits)},
            ((("verdict", "R5", "Passed"), distance),) if distance else (),
            sim_s=30.0 * len(hits),
        )

    def _done(self, combination: Combination) -> list[str]:
        """What disturbances do: those that come in time to be read, and are strong enough."""
        done = []
        for place, name, values in combination:
            rule = self.rules[name]
            if place >= rule.place and dict(values)["strength"] > rule.strength:
                done.append(rule.does)
        return done

    def _end(self, pose: str, done: Sequence[str], rng: Random) -> tuple[str, str]:
        error = 0.3 if "noise" in done else self.error
        chances = [rng.random() for _ in range(self.sensors + 1)]
        sensors = [bit == "1" and chance >= error for bit, chance in zip(pose, chances, strict=False)]
        if "pull" in done:
            sensors[-1] = False
        for does in done:
            if does.startswith("flip"):
                sensors[int(does.removeprefix("flip"))] ^= True
        if "silence" in done:
            return "none", "silent"
        if "delay" in done or chances[-1] < self.error / 2:
            return "none", "late"
        given = "dropped" if "drop" in done else "given"
        return "".join(str(int(sensor)) for sensor in sensors), given if all(sensors) else "kept"

    def loop(self, seed: int, runs: int = 400) -> Loop:
        """A loop as a session has it."""
        pool = Pool(self.exploration, self.space, {"handover": self.planned})
        experience = Experience(pool)
        strategies = ModelStrategy(pool, experience), DisturbanceStrategy(pool, experience, self.disturbances)

        def runner(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
            return ((number, self.run(test)) for number, test in enumerate(tests))

        return Loop(Archive(self.targets), strategies, runner, seed, Budget(runs), fallback=FallbackStrategy(pool))
