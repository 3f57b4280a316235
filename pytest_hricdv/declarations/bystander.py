"""`Bystander`: an actor of a run without plans, such as a dog, or a door that somebody opens.

A testbench declares bystanders. Which acts they do, and when, are parameters of the run; `Run.actions` yields them.

>>> from pytest_hricdv.generate.sampler import Uniform
>>> dog = Bystander("dog", {"walk": {"far_m": Uniform(0.5, 3.0, "m")}, "lie_down": {}}, most=2)
>>> sorted(dog.parameters)
['dog_1_act', 'dog_1_pause_s', 'dog_1_walk_far_m', 'dog_2_act', 'dog_2_pause_s', 'dog_2_walk_far_m', 'dog_acts']
>>> dog.acts_of({"dog_acts": 1, "dog_1_act": 1, "dog_1_pause_s": 4.0, "dog_1_walk_far_m": 2.0})
[(4.0, 'walk', {'far_m': 2.0})]
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from random import Random

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.rng import random_index
from pytest_hricdv.generate.sampler import Sampler, Uniform

_NAME = re.compile(r"[a-z]\w*\Z", re.ASCII)
_ACT = re.compile(r"[A-Za-z_]\w*\Z", re.ASCII)


@dataclass(frozen=True)
class Whole(Sampler):
    """A whole number from `low` to `high`, each equally likely; the simplest is the least."""

    low: int
    high: int

    def sample(self, rng: Random) -> float:
        """A number."""
        return float(self.low + random_index(rng, self.high - self.low + 1))

    def corners(self) -> tuple[float, ...]:
        """The least and the greatest."""
        return (float(self.low), float(self.high))

    def simple_values(self) -> tuple[float, ...]:
        """All values, the least first."""
        return tuple(float(value) for value in range(self.low, self.high + 1))

    def contains(self, value: float) -> bool:
        """Whether it is one of them."""
        return self.low <= value <= self.high and value == int(value)

    def __str__(self) -> str:
        return f"whole number from {self.low} to {self.high}"


@dataclass(frozen=True)
class Bystander:
    """An actor without a model: it does a few acts, drawn one by one, each after a pause.

    What it does is part of the concretization: parameters of the run that begin with its name, so that it is recorded,
    replayed, searched and shrunk as they are. `NAME_acts` is how many acts it does; of the n-th (from 1), `NAME_n_act`
    is which, by its place among `acts` (from 1), and `NAME_n_pause_s` how long it does nothing before. In the world, a
    node takes its acts: `for action in run.actions("dog")`.

    Args:
        name: the actor's name: a lower-case letter, then letters, digits and underscores.
        acts: what it can do, one word each, with the ranges of the parameters.
        fewest: acts in a run.
        most: acts in a run.
        pause_s: before each act (s).

    Raises:
        GenerateError: no such name, no act, or numbers that are none.
    """

    name: str
    acts: Mapping[str, Mapping[str, Sampler]] = field(hash=False)
    fewest: int = 0
    most: int = 4
    pause_s: Sampler = Uniform(0.0, 10.0, "s")  # noqa: RUF009  (frozen)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not _NAME.match(self.name):
            raise GenerateError(f"Bystander: name is {self.name!r}; expected one of small letters, such as 'dog'")
        if not self.acts or not all(isinstance(act, str) and _ACT.match(act) for act in self.acts):
            raise GenerateError(f"Bystander {self.name!r}: acts are {list(self.acts)!r}; expected one word each")
        if not 0 <= self.fewest <= self.most or self.most < 1:
            numbers = f"{self.fewest} to {self.most} acts"
            raise GenerateError(f"Bystander {self.name!r}: {numbers}; expected 0 <= fewest <= most, and most >= 1")
        for sampler in (self.pause_s, *(sampler for samplers in self.acts.values() for sampler in samplers.values())):
            if not isinstance(sampler, Sampler):
                raise GenerateError(f"Bystander {self.name!r}: {sampler!r} is not a Uniform, Sometimes or Constant")

    @property
    def parameters(self) -> dict[str, Sampler]:
        """The parameters of a run that say what it does."""
        samplers: dict[str, Sampler] = {f"{self.name}_acts": Whole(self.fewest, self.most)}
        for number in range(1, self.most + 1):
            prefix = f"{self.name}_{number}"
            samplers[f"{prefix}_act"] = Whole(1, len(self.acts))
            samplers[f"{prefix}_pause_s"] = self.pause_s
            for act, own in self.acts.items():
                samplers |= {f"{prefix}_{act}_{name}": sampler for name, sampler in own.items()}
        return samplers

    def acts_of(self, parameters: Mapping[str, float]) -> list[tuple[float, str, dict[str, float]]]:
        """Its acts in a run with these parameters, in order: pause (s), act, and the act's own parameters."""
        return list(self._acts_of(parameters))

    def _acts_of(self, parameters: Mapping[str, float]) -> Iterator[tuple[float, str, dict[str, float]]]:
        names = list(self.acts)
        for number in range(1, int(parameters[f"{self.name}_acts"]) + 1):
            prefix = f"{self.name}_{number}"
            act = names[int(parameters[f"{prefix}_act"]) - 1]
            own = {name: parameters[f"{prefix}_{act}_{name}"] for name in self.acts[act]}
            yield parameters[f"{prefix}_pause_s"], act, own
