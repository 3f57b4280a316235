"""Inputs as a user of Hypothesis draws them: lists of commands, and a rule-based machine that knows what people do."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from random import Random
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import SEED_LIMIT
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.sampler import Sampler
from pytest_hricdv.strategies import concrete_tests, values
from studies.fair_fight.world import World

SEEDS = st.integers(0, SEED_LIMIT - 1)
EVERY_FIFTH = 5
"""Steps of a machine between disturbances, on average."""


def _value(sampler: Sampler) -> st.SearchStrategy[float]:
    """As the public strategy, which knows no sampler of a project's own: such a one is sampled."""
    try:
        return values(sampler)
    except GenerateError:
        return st.integers(0, 2**16).map(lambda number: sampler.sample(Random(number)))


def _parameters(samplers: Mapping[str, Sampler]) -> st.SearchStrategy[dict[str, float]]:
    return st.fixed_dictionaries({name: _value(sampler) for name, sampler in samplers.items()})


def _action(world: World, command: str) -> st.SearchStrategy[ConcreteAction]:
    samplers = world.testbench.commands.commands[command]
    return st.builds(ConcreteAction, st.just(command), _parameters(samplers))


def lists(world: World) -> st.SearchStrategy[ConcreteTest]:
    """Any commands and disturbances: the public strategy, where all of the project's ranges are of the plugin."""
    ranges = world.testbench.commands
    try:
        return concrete_tests(ranges)
    except GenerateError:
        actions = st.lists(st.one_of([_action(world, command) for command in ranges.commands]), max_size=20)
        return st.builds(_test, SEEDS, actions, _parameters(ranges.run))


def _test(seed: int, actions: list[ConcreteAction], run: Mapping[str, float]) -> ConcreteTest:
    return ConcreteTest("property", "property", seed, tuple(actions), dict(run))


def machine(world: World) -> Any:
    """The class of a rule-based machine: its rules draw what a person may do next, and the run follows at the end."""
    phases = importlib.import_module(f"studies.fair_fight.machines.{world.base.name}")
    commands = world.testbench.commands
    follows: Mapping[str, Mapping[str, str]] = phases.FOLLOWS
    drawn = {command: _action(world, command) for command in commands.commands}
    disturbances = sorted({*commands.commands} - {*world.testbench.concretization.commands})

    class Person(RuleBasedStateMachine):
        """Somebody who goes on from where the last step has led."""

        def __init__(self) -> None:
            super().__init__()
            self.phase, self.seed = phases.START, 0
            self.actions: list[ConcreteAction] = []
            self.values: dict[str, float] = {}

        @initialize(seed=SEEDS, run=_parameters(commands.run))
        def begin(self, seed: int, run: dict[str, float]) -> None:
            self.seed, self.values = seed, run

        @rule(data=st.data())
        def act(self, data: Any) -> None:
            following = follows[self.phase]
            if disturbances and data.draw(st.integers(1, EVERY_FIFTH)) == EVERY_FIFTH:
                command = data.draw(st.sampled_from(disturbances))
            elif following:
                command = data.draw(st.sampled_from(sorted(following)))
            else:
                return
            self.phase = following.get(command, self.phase)
            self.actions.append(data.draw(drawn[command]))

        def teardown(self) -> None:
            if self.actions:
                world.check(_test(self.seed, self.actions, self.values))

    return Person
