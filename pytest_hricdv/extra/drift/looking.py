"""Looking for drift: the code under test of a session, beside its testbench and the tests that ran."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.drift.drifting import Drift, drifts, findings_of, split
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.run_context import RunContext


@dataclass(frozen=True)
class Looked:
    """What was found.

    Args:
        new: drift that nobody has declared.
        known: drift that `hri_known_drift` has.
        outdated: lines of it that are none any more, a sentence each.
        problems: code that could not be read, a sentence each.
    """

    new: list[Drift]
    known: list[Drift]
    outdated: list[str]
    problems: list[str]


def looked(context: RunContext, tests: Sequence[TestResult] | None, known: Mapping[str, str]) -> Looked:
    """Look for drift.

    Args:
        context: of a session.
        tests: that tell which states were reached; None where that is not known.
        known: key -> reason, of drift that may be there.
    """
    testbench = context.collection.testbench
    roots = dict.fromkeys(
        [Path(context.collection.config.rootpath), Path.cwd(), *(Path(folder or ".") for folder in sys.path)]
    )
    findings, problems = findings_of(testbench.code, [root for root in roots if root.is_dir()])
    new, declared, gone = split(drifts(findings, testbench, tests), known)
    if tests is None:  # what was reached is not known, so neither whether a state still is not
        gone = [key for key in gone if key.partition(" ")[0] not in ("state", "transition")]
    return Looked(new, declared, [f"hri_known_drift has {key!r}, which is none any more" for key in gone], problems)
