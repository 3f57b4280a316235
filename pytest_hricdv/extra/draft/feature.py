"""Drift in a session: its options, and the comparison after the last test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import Flag, OptionReader, Repeatable, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.extra.draft.drift import Drift
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext

KINDS = ("message", "value", "transition", "gone")
"""Kinds of drift: the first word of each description."""


MAX_SHOWN = 5
"""Drift that is listed where a session fails; the command lists all."""


@dataclass(frozen=True)
class DriftOptions:
    """The options of the search for drift.

    Args:
        fails: a session looks for it, and fails for unknown drift.
        known: its key -> the reason why it may be there.
    """

    fails: bool = False
    known: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class DriftResult:
    """Drift of a session.

    Args:
        new: that nobody has declared.
        known: that `hri_known_drift` declares.
        outdated: lines of it that are none any more, a sentence each.
        problems: code that could not be read, a sentence each.
    """

    new: list[Drift]
    known: list[Drift]
    outdated: list[str]
    problems: list[str]


class DriftFeature(Feature[DriftOptions]):
    """Compares the code under test with what the testbench declares of it."""

    name = "draft"
    group = "verdict"
    options = (
        Flag(
            "fail-on-drift",
            "fail when the code under test has a message, value, state or transition that the testbench lacks "
            "(see: hricdv update)",
        ),
        Repeatable(
            "known-drift",
            "DRIFT",
            "drift that may be there, as 'message alarm'",
            "one a line, 'message alarm: reason': drift that may be there",
            shown=False,
        ),
    )

    def read(self, reader: OptionReader) -> DriftOptions:
        """The kinds of drift to look for. Raises pytest.UsageError for an unknown kind."""
        known = {}
        for line in reader.texts("known_drift"):
            key, _, reason = line.partition(": ")
            kind, _, name = key.strip().partition(" ")
            if kind not in KINDS or not name:
                raise usage_error(
                    f"hri_known_drift: {line!r}: expected 'KIND NAME: reason', as 'message alarm: of the next "
                    f"release'; KIND is {', '.join(KINDS[:-1])} or {KINDS[-1]}"
                )
            known[key.strip()] = reason.strip()
        return DriftOptions(reader.flag("fail_on_drift"), known)

    def follow_up(self, context: RunContext) -> str:
        """The comparison, where it decides."""
        return "the look for drift (--hri-fail-on-drift)" if self.settings(context.options).fails else ""

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """Look for drift, where it is to fail the session; the session's problems have it."""
        settings = self.settings(session.options)
        if session.interrupted or not settings.fails:
            return report
        session.done.add(self.name)
        result = find_drift(session.context, settings.known)
        session.warnings += [f"drift: {text}" for text in (*result.problems, *result.outdated)]
        if result.new:
            shown = "; ".join(f"{drift.text} ({drift.location or 'declared'})" for drift in result.new[:MAX_SHOWN])
            more = f"; and {len(result.new) - MAX_SHOWN} more" if len(result.new) > MAX_SHOWN else ""
            session.problems.append(
                f"--hri-fail-on-drift: {shown}{more}. All of it: hricdv update; what may be so goes to hri_known_drift"
            )
        return report


FEATURE = DriftFeature()
"""Whether code and testbench have drifted apart."""


def find_drift(context: RunContext, known: Mapping[str, str]) -> DriftResult:
    """Compare the code under test of a session with its testbench.

    Args:
        context: of a session.
        known: key -> reason, of drift that may be there.
    """
    import sys
    from pathlib import Path

    from pytest_hricdv.extra.draft.drift import drifts, models_of, split  # they read code

    testbench = context.collection.testbench
    roots = dict.fromkeys(
        [Path(context.collection.config.rootpath), Path.cwd(), *(Path(folder or ".") for folder in sys.path)]
    )
    models, problems = models_of(testbench.code, [root for root in roots if root.is_dir()])
    new, declared, gone = split(drifts(models, testbench), known)
    outdated = [f"hri_known_drift has {key!r}, which is none any more" for key in gone]
    return DriftResult(new, declared, outdated, problems)
