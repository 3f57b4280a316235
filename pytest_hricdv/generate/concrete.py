"""Concrete tests: abstract tests with parameters for each action, sampled from declared ranges.

Paper: section on concretization; in coverage-driven verification this is constrained random generation.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest, canonical_command
from pytest_hricdv.generate.rng import canonical_json, derive_seed, make_rng
from pytest_hricdv.generate.sampler import SAMPLINGS, Constant, Sampler
from pytest_hricdv.suggestion import nearest

Parameters = Mapping[str, float]
UNIFORM = "uniform"
"""The default sampling."""

_UNITLESS = Constant(0.0)
"""Formats the values of parameters without a declared range."""


@dataclass(frozen=True)
class Concretization:
    """The ranges from which the parameters of commands are sampled.

    Args:
        commands: for each command line that can be executed, the samplers of its parameters by name (with the unit in
            the name, as in `hold_s`); an empty mapping for a command without parameters.
        run: the samplers of parameters that are drawn once per run.

    Raises:
        GenerateError: a command that is not in canonical spelling, or a sampler that is no `Sampler`.
    """

    commands: Mapping[str, Mapping[str, Sampler]] = field(hash=False)
    run: Mapping[str, Sampler] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        for command, samplers in self.commands.items():
            if canonical_command(command) != command:
                raise GenerateError(
                    f"concretization of {command!r}: expected the spelling {canonical_command(command)!r}"
                )
            _check_samplers(f"concretization of {command!r}", samplers)
        _check_samplers("concretization of a run", self.run)

    def shown(self, test: ConcreteTest) -> tuple[str, ...]:
        """A concrete test for people: one line per action, then one for the run, each value with its unit."""
        lines = [_shown(each.command, each.parameters, self.commands.get(each.command, {})) for each in test.actions]
        return (*lines, _shown("run", test.run, self.run)) if test.run else tuple(lines)


def _shown(what: str, parameters: Parameters, samplers: Mapping[str, Sampler]) -> str:
    values = [f"{name} {samplers.get(name, _UNITLESS).shown(value)}" for name, value in parameters.items()]
    return f"{what}: {', '.join(values)}" if values else what


def _check_samplers(where: str, samplers: Mapping[str, Sampler]) -> None:
    for name, sampler in samplers.items():
        if not isinstance(sampler, Sampler):
            raise GenerateError(f"{where}: parameter {name!r} is {sampler!r}; expected a Range, Chance or Constant")


@dataclass(frozen=True)
class ConcreteAction:
    """One action: its command line and its parameters by name."""

    command: str
    parameters: Parameters = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class ConcreteTest:
    """Everything a run depends on besides the code under test, as data."""

    id: str
    suite: str
    seed: int
    actions: tuple[ConcreteAction, ...]
    run: Parameters = field(default_factory=dict, hash=False)

    def to_json(self) -> str:
        """Canonical JSON; floats are exact."""
        actions = [[action.command, dict(action.parameters)] for action in self.actions]
        return canonical_json(
            {"id": self.id, "suite": self.suite, "seed": self.seed, "actions": actions, "run": dict(self.run)}
        )

    @classmethod
    def from_json(cls, text: str) -> ConcreteTest:
        """The test that `to_json` wrote.

        Raises:
            GenerateError: the text is not such a test.
        """
        try:
            data = json.loads(text)
            actions = tuple(ConcreteAction(command, _floats(given)) for command, given in data["actions"])
            return cls(str(data["id"]), str(data["suite"]), int(data["seed"]), actions, _floats(data["run"]))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise GenerateError(f"not a concrete test: {error!r}; expected what ConcreteTest.to_json writes") from error


def _floats(parameters: Mapping[str, float]) -> dict[str, float]:
    return {str(name): float(value) for name, value in parameters.items()}


def variant(test: AbstractTest, k: int) -> AbstractTest:
    """The test for the k-th concretization: the same for k = 0, else with an id and a seed derived from it."""
    if k < 0:
        raise GenerateError(f"concretization number {k}: expected at least 0")
    return test if k == 0 else replace(test, id=f"{test.id}-k{k}", seed=derive_seed("variant", test.seed, k))


def expand(tests: Iterable[AbstractTest], concretizations: int, sampling: str = UNIFORM) -> tuple[AbstractTest, ...]:
    """Each test `concretizations` times, its variants next to each other; for k = 0 the id is unchanged.

    Another sampling than the uniform one gives other tests, so these have other ids and seeds.

    Raises:
        GenerateError: fewer than one concretization, or an unknown sampling.
    """
    if sampling not in SAMPLINGS:
        raise GenerateError(f"no sampling {sampling!r}{nearest(sampling, SAMPLINGS)}")
    if sampling != UNIFORM:
        drawn = (replace(test, id=f"{test.id}-{sampling}", seed=derive_seed(sampling, test.seed)) for test in tests)
        return expand(drawn, concretizations)
    if concretizations < 1:
        raise GenerateError(f"{concretizations} concretizations of a test: expected at least 1")
    return tuple(variant(test, k) for test in tests for k in range(concretizations))


def concretize(test: AbstractTest, concretization: Concretization, k: int = 0, sampling: str = UNIFORM) -> ConcreteTest:
    """Sample a test's parameters.

    Each parameter of each action has its own random stream, from the test's seed, the action's place and the
    parameter's name. So its value stays the same when another parameter is added or another range is changed.

    Raises:
        GenerateError: a command of the test has no declared ranges.
    """
    test, sample = variant(test, k), SAMPLINGS[sampling]
    actions = []
    for place, command in enumerate(test.lines):
        samplers = concretization.commands.get(command)
        if samplers is None:
            known = nearest(command, concretization.commands)
            raise GenerateError(f"test {test.id}: no ranges are declared for command {command!r}{known}")
        drawn = {name: sample(each, make_rng(test.seed, place, command, name)) for name, each in samplers.items()}
        actions.append(ConcreteAction(command, drawn))
    run = {name: sample(each, make_rng(test.seed, "run", name)) for name, each in concretization.run.items()}
    return ConcreteTest(test.id, test.suite, test.seed, tuple(actions), run)
