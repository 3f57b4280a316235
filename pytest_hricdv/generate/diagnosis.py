"""Diagnosis: how much there is in a suite, told before a single test of it has run."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

from .abstract import Plans
from .suite import Suite


@dataclass(frozen=True)
class Diagnosis:
    """What a suite's tests have in common.

    Args:
        tests: how many there are.
        distinct_texts: how many differ as text.
        distinct_subsets: how many differ in the beliefs they came from; 0 where they came from none.
        belief_entropy_bits: Shannon entropy of the beliefs over all tests (bit): how evenly they are used.
        belief_entropy_most_bits: the entropy if each belief that occurs were used as often as the others (bit).
        plans: agent -> the coverage plans that the model executed in at least one of the tests.
        last_news: the test (from 1, in the suite's order) after which none executes a plan that those before had not
            executed; 0 where none executes any.
    """

    tests: int
    distinct_texts: int
    distinct_subsets: int
    belief_entropy_bits: float
    belief_entropy_most_bits: float
    plans: Plans = field(hash=False)
    last_news: int

    @property
    def warning(self) -> str:
        """What to say where more than half of the tests repeat the text of another one; empty where all is well."""
        if 2 * self.distinct_texts >= self.tests:
            return ""
        return f"mostly repeats: only {self.distinct_texts} of {self.tests} tests differ as text"


def diagnose(suite: Suite) -> Diagnosis:
    """Diagnose a suite."""
    uses = Counter(belief for test in suite.tests for belief in test.beliefs)
    seen: set[tuple[str, str]] = set()
    last_news = 0
    for number, test in enumerate(suite.tests, 1):
        executed = {(agent, label) for agent, labels in test.plans.items() for label in labels}
        last_news = number if executed - seen else last_news
        seen |= executed
    return Diagnosis(
        tests=len(suite.tests),
        distinct_texts=len({test.lines for test in suite.tests}),
        distinct_subsets=len({test.beliefs for test in suite.tests if test.beliefs}),
        belief_entropy_bits=entropy_bits(uses),
        belief_entropy_most_bits=math.log2(len(uses)) if uses else 0.0,
        plans=suite.covered_plans(),
        last_news=last_news,
    )


def entropy_bits(uses: Counter[str]) -> float:
    """Shannon entropy of what is counted (bit); 0 where nothing is, or only one thing."""
    total = uses.total()
    return math.fsum(count / total * math.log2(total / count) for count in uses.values())
