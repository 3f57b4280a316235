"""Suites: the tests a method generated, as plain data that crosses processes and is kept in a cache."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from .abstract import AbstractTest, Plans
from .beliefs import BeliefSpace
from .error import GenerateError
from .identity import Draft, identify
from .model import contents
from .stream import canonical

SCHEMA = "hricdv-suite/2"
#: Part of every fingerprint: raised whenever the same inputs come to give other tests.
GENERATOR_VERSION = "1"


@dataclass(frozen=True)
class Generation:
    """How a suite came about.

    Args:
        bdi_runs: runs of the model, all told; 0 for a method without a model.
        iterations: iterations of learning.
        converged_at: the iteration at which no cell of Q changed any more, or None.
        q_delta: the largest change of a cell of Q in each iteration.
        news_at: the last iteration of learning in which a plan was executed that no run before had executed; None
            where nothing was learned.
        reward: the name of the reward; empty where nothing was learned.
        distinct_texts: how many of the suite's tests differ as text.
        declared_plans: the coverage plans the model has, by agent; what coverage is measured against.
        notes: what a reader should know: entries left out, fewer tests than asked for.
    """

    bdi_runs: int = 0
    iterations: int = 0
    converged_at: int | None = None
    q_delta: tuple[float, ...] = ()
    news_at: int | None = None
    reward: str = ""
    distinct_texts: int = 0
    declared_plans: Plans = field(default_factory=dict, hash=False)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Suite:
    """A suite: equal inputs and seed give an equal suite, to the byte of its JSON. The time it took is not part of it.

    Raises:
        GenerateError: two tests have the same id.
    """

    name: str
    seed: int
    tests: tuple[AbstractTest, ...]
    generation: Generation = Generation()

    def __post_init__(self) -> None:
        seen: set[str] = set()
        for test in self.tests:
            if test.id in seen:
                raise GenerateError(f"suite {self.name}: two tests have the id {test.id!r}; expected each id once")
            seen.add(test.id)

    @classmethod
    def of_drafts(cls, name: str, seed: int, drafts: Iterable[Draft], generation: Generation) -> Suite:
        """A suite of drafts, which get their ids and seeds here."""
        return cls.of_tests(name, seed, identify(name, seed, drafts), generation)

    @classmethod
    def of_tests(cls, name: str, seed: int, tests: Sequence[AbstractTest], generation: Generation) -> Suite:
        """A suite of tests; counts the distinct texts."""
        distinct = len({test.lines for test in tests})
        return cls(name, seed, tuple(tests), replace(generation, distinct_texts=distinct))

    def noted(self, note: str) -> Suite:
        """The same suite with one more note on how it came about."""
        return replace(self, generation=replace(self.generation, notes=(*self.generation.notes, note)))

    def covered_plans(self) -> Plans:
        """The coverage plans that the model executed in at least one of the tests, by agent."""
        covered: dict[str, set[str]] = {agent: set() for agent in self.generation.declared_plans}
        for test in self.tests:
            for agent, labels in test.plans.items():
                covered.setdefault(agent, set()).update(labels)
        return {agent: tuple(sorted(labels)) for agent, labels in covered.items()}

    def uncovered_plans(self) -> Plans:
        """The declared coverage plans that none of the tests executed, by agent, where there are any."""
        covered = self.covered_plans()
        left = {
            agent: tuple(label for label in labels if label not in covered[agent])
            for agent, labels in self.generation.declared_plans.items()
        }
        return {agent: labels for agent, labels in left.items() if labels}

    def to_json(self) -> str:
        """Canonical JSON, a plain string; the same for equal suites."""
        return canonical({"schema": SCHEMA, **asdict(self)})

    @classmethod
    def from_json(cls, text: str) -> Suite:
        """The suite that `to_json` wrote.

        Raises:
            GenerateError: the text is not such a suite, or one of another version.
        """
        try:
            data = json.loads(text)
            schema = data["schema"]
            if schema != SCHEMA:
                raise GenerateError(f"a suite of schema {schema!r}; expected {SCHEMA!r}: generate it again")
            tests = tuple(_test(each) for each in data["tests"])
            return cls(str(data["name"]), int(data["seed"]), tests, _generation(data["generation"]))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise GenerateError(f"not a suite: {error!r}; expected what Suite.to_json writes") from error


def _test(data: dict[str, Any]) -> AbstractTest:
    lists = {"beliefs": tuple(data["beliefs"]), "lines": tuple(data["lines"]), "plans": _plans(data["plans"])}
    return AbstractTest(**{**data, **lists})


def _generation(data: dict[str, Any]) -> Generation:
    lists = {
        "q_delta": tuple(data["q_delta"]),
        "declared_plans": _plans(data["declared_plans"]),
        "notes": tuple(data["notes"]),
    }
    return Generation(**{**data, **lists})


def _plans(data: Mapping[str, Sequence[str]]) -> Plans:
    return {agent: tuple(labels) for agent, labels in data.items()}


def fingerprint(
    files: Iterable[Path],
    space: BeliefSpace | None,
    parameters: object,
    seed: int,
    version: str = GENERATOR_VERSION,
) -> str:
    """What a suite depends on, as one hash (hex): the key of a cache.

    Args:
        files: the model's files, and any other that is read; their names and bytes count, their folders do not.
        space: the belief space, if there is one.
        parameters: a dataclass of the method's parameters, or anything JSON can say.
        seed: the master seed.
        version: of the generator.

    Raises:
        GenerateError: a file cannot be read.
    """
    beliefs = None if space is None else [space.start, list(space.groups.items()), space.naming, space.neutral]
    plain = asdict(parameters) if hasattr(type(parameters), "__dataclass_fields__") else parameters  # type: ignore[call-overload]
    key = canonical([version, contents(files), beliefs, plain, seed])
    return hashlib.sha256(key.encode("ascii")).hexdigest()
