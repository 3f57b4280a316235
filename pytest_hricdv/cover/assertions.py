"""Assertion coverage: how often each requirement was put to the test, and what came of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

COUNTS = ("triggers", "passes", "failures", "vacuous", "pending")


def tally(requirement: str, entries: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """One requirement over the tests of a suite.

    Returns:
        `passed`, `failed`, `nc`: tests by verdict. `triggers`: attempts, which are `passes` (real ones), `failures` and
        `pending` (undecided when the run ended). `vacuous`: runs in which the antecedent never held, so that the
        requirement held for want of an occasion.
    """
    verdicts = [entry["requirements"][requirement] for entry in entries]
    count = Counter(verdict["verdict"] for verdict in verdicts)
    sums = {name: sum(verdict.get(name, 0) for verdict in verdicts) for name in COUNTS}
    return {"passed": count["Passed"], "failed": count["Failed"], "nc": count["NC"], **sums}
