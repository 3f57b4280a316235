"""Drift in a session: its options, and what it looks for after the last test."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.extra.drift.options import DriftOptions
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import Flag, OptionReader, Repeatable, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report

KINDS = ("message", "value", "state", "transition", "gone", "parameter")
"""Of drift: the first word of what it is called."""


class DriftFeature(Feature[DriftOptions]):
    """Compares the code under test with what the testbench declares of it, and with what the tests reached."""

    name = "drift"
    options = (
        Flag(
            "fail-on-drift",
            "fail when the code under test has a message, value, state, transition or parameter that testbench and "
            "tests lack (see: python -m pytest_hricdv init --update)",
        ),
        Repeatable(
            "known-drift",
            "DRIFT",
            "drift that may be there, as 'parameter settle_s'",
            "one a line, 'parameter settle_s: reason': drift that may be there",
        ),
    )

    def read(self, reader: OptionReader) -> DriftOptions:
        """What is looked for. Raises pytest.UsageError for drift of a kind that there is not."""
        known = {}
        for line in reader.texts("known_drift"):
            key, _, reason = line.partition(": ")
            kind, _, name = key.strip().partition(" ")
            if kind not in KINDS or not name:
                raise usage_error(
                    f"hri_known_drift: {line!r}: expected 'KIND NAME: reason', as 'parameter settle_s: fixed by the "
                    f"hardware'; KIND is {', '.join(KINDS[:-1])} or {KINDS[-1]}"
                )
            known[key.strip()] = reason.strip()
        return DriftOptions(reader.flag("fail_on_drift"), known)

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """Look for drift, where it is to fail the session; the session's problems have it."""
        settings = self.settings(session.options)
        if session.interrupted or not settings.fails:
            return report
        from pytest_hricdv.extra.drift.looking import looked  # it reads code

        drift_seen = looked(session.context, report.tests if session.is_whole else None, settings.known)
        session.warnings += [f"drift: {text}" for text in (*drift_seen.problems, *drift_seen.outdated)]
        if drift_seen.new:
            shown = "; ".join(f"{drift.text} ({drift.place or 'declared'})" for drift in drift_seen.new[:MOST_SHOWN])
            more = f"; and {len(drift_seen.new) - MOST_SHOWN} more" if len(drift_seen.new) > MOST_SHOWN else ""
            session.problems.append(
                f"--hri-fail-on-drift: {shown}{more}. The lines to add: python -m pytest_hricdv init --update; what "
                "may be so goes to hri_known_drift"
            )
        return report


MOST_SHOWN = 5
"""So many are listed where a session fails (chosen); the command lists all."""

FEATURE = DriftFeature()
"""Whether code and testbench have drifted apart."""
