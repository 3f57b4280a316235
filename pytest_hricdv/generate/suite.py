"""`Suite`: the tests that a method generated, as plain data for caches and worker processes; and its diagnosis.

`session.suites` keeps suites in pytest's cache and sends them to workers. `diagnose` measures how varied the tests are,
for the report, and for a warning of `generate.methods`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace

from msgspec import Struct

from pytest_hricdv._base.input_file import MalformedError, from_json
from pytest_hricdv._base.message import quote
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest, Plans, TestData, check_suite_name, identify
from pytest_hricdv.generate.rng import canonical_json

SCHEMA = "hricdv-suite/3"


@dataclass(frozen=True)
class Generation:
    """Facts on the generation of a suite.

    Args:
        bdi_runs: all runs of the model; 0 for a method without a model.
        converged_at: the iteration at which no cell of Q changed any more, or None.
        q_delta: the largest change of a cell of Q in each iteration.
        last_new_plan_at: the last iteration of learning that executed a plan which no earlier run had executed; None
            without learning.
        reward: the name of the reward; empty without learning.
        distinct_texts: how many of the suite's tests differ as text.
        declared_plans: all coverage plans of the model, by agent.
        notes: messages for the reader, for instance on entries left out or fewer tests than asked for.
    """

    bdi_runs: int = 0
    iterations: int = 0
    converged_at: int | None = None
    q_delta: tuple[float, ...] = ()
    last_new_plan_at: int | None = None
    reward: str = ""
    distinct_texts: int = 0
    declared_plans: Plans = field(default_factory=dict, hash=False)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Suite:
    """The tests of one method. Equal inputs and seed give equal bytes of JSON; times are not part of it.

    Raises:
        GenerateError: two tests have the same id, or the name is none of a suite.
    """

    name: str
    seed: int
    tests: tuple[AbstractTest, ...]
    generation: Generation = Generation()

    def __post_init__(self) -> None:
        check_suite_name(self.name)
        seen: set[str] = set()
        for test in self.tests:
            if test.id in seen:
                raise GenerateError(f"suite {self.name}: two tests have the id {test.id!r}; expected each id once")
            seen.add(test.id)

    @classmethod
    def of_drafts(cls, name: str, seed: int, drafts: Iterable[AbstractDraft], generation: Generation) -> Suite:
        """A suite of drafts, with their ids and seeds."""
        return cls.of_tests(name, seed, identify(name, seed, drafts), generation)

    @classmethod
    def of_tests(cls, name: str, seed: int, tests: Sequence[AbstractTest], generation: Generation) -> Suite:
        """A suite of tests; counts the distinct texts."""
        distinct = len({test.lines for test in tests})
        return cls(name, seed, tuple(tests), replace(generation, distinct_texts=distinct))

    def with_note(self, note: str) -> Suite:
        """The same suite with one more note."""
        return replace(self, generation=replace(self.generation, notes=(*self.generation.notes, note)))

    def plans_covered(self) -> Plans:
        """The coverage plans that the model executed in at least one of the tests, by agent."""
        covered: dict[str, set[str]] = {agent: set() for agent in self.generation.declared_plans}
        for test in self.tests:
            for agent, labels in test.plans.items():
                covered.setdefault(agent, set()).update(labels)
        return {agent: tuple(sorted(labels)) for agent, labels in covered.items()}

    def plans_not_covered(self) -> Plans:
        """The declared coverage plans that no test executed, by agent; agents without any are left out."""
        covered = self.plans_covered()
        left = {
            agent: tuple(label for label in labels if label not in covered[agent])
            for agent, labels in self.generation.declared_plans.items()
        }
        return {agent: labels for agent, labels in left.items() if labels}

    def to_json(self) -> str:
        """Canonical JSON, a plain string; the same for equal suites."""
        return canonical_json(
            {
                "schema": SCHEMA,
                "name": self.name,
                "seed": self.seed,
                "tests": [test.to_data() for test in self.tests],
                "generation": asdict(self.generation),
            }
        )

    @classmethod
    def from_json(cls, text: str) -> Suite:
        """The suite that `to_json` wrote.

        Raises:
            GenerateError: the text is not such a suite, or one of another version.
        """
        try:
            schema = schema_of(text)
            if schema != SCHEMA:
                raise GenerateError(f"a suite of schema {quote(schema)}; expected {SCHEMA!r}: generate it again")
            data = from_json(text, _SuiteData)
        except MalformedError as error:
            raise GenerateError(f"not a suite{error}; expected what Suite.to_json writes") from None
        return cls(data.name, data.seed, tuple(map(AbstractTest.from_data, data.tests)), data.generation)


class _SuiteData(Struct):
    """The JSON text of a suite."""

    name: str
    seed: int
    tests: tuple[TestData, ...]
    generation: Generation


class _Head(Struct):
    schema: str | int | None = None


def schema_of(text: str) -> str | int | None:
    """The schema of a JSON text, whatever else it has: what another version wrote should not be called malformed."""
    return from_json(text, _Head).schema


@dataclass(frozen=True)
class SuiteDiagnosis:
    """How varied the tests of a suite are, before any of them has run.

    Args:
        distinct_texts: number of different texts.
        distinct_subsets: number of different belief subsets; 0 if the tests came from none.
        belief_entropy_bits: Shannon entropy of the beliefs over all tests (bit): how evenly they are used.
        belief_entropy_most_bits: the entropy if all beliefs that occur were used equally often (bit).
        plans: agent -> the coverage plans that the model executed in at least one of the tests.
        last_new_plan_at: the last test (from 1, in the suite's order) that executes a plan which no earlier test
            executes; 0 if there is none.
    """

    tests: int
    distinct_texts: int
    distinct_subsets: int
    belief_entropy_bits: float
    belief_entropy_most_bits: float
    plans: Plans = field(hash=False)
    last_new_plan_at: int

    @property
    def warning(self) -> str:
        """The warning if more than half of the tests repeat the text of another one, else empty."""
        if 2 * self.distinct_texts >= self.tests:
            return ""
        return f"mostly repeats: only {self.distinct_texts} of {self.tests} tests differ as text"


def diagnose(suite: Suite) -> SuiteDiagnosis:
    """The diagnosis of a suite."""
    uses = Counter(belief for test in suite.tests for belief in test.beliefs)
    seen: set[tuple[str, str]] = set()
    last_new_plan_at = 0
    for number, test in enumerate(suite.tests, 1):
        executed = {(agent, label) for agent, labels in test.plans.items() for label in labels}
        last_new_plan_at = number if executed - seen else last_new_plan_at
        seen |= executed
    return SuiteDiagnosis(
        tests=len(suite.tests),
        distinct_texts=len({test.lines for test in suite.tests}),
        distinct_subsets=len({test.beliefs for test in suite.tests if test.beliefs}),
        belief_entropy_bits=entropy_bits(uses),
        belief_entropy_most_bits=math.log2(len(uses)) if uses else 0.0,
        plans=suite.plans_covered(),
        last_new_plan_at=last_new_plan_at,
    )


def entropy_bits(uses: Counter[str]) -> float:
    """Shannon entropy of the counts (bit); 0 for no count or only one."""
    total = uses.total()
    return math.fsum(count / total * math.log2(total / count) for count in uses.values())
