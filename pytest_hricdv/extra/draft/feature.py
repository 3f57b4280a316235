"""The option `--hri-known-drift`: drift that `hricdv update` accepts."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import OptionReader, Repeatable, usage_error

KINDS = ("message", "value", "transition", "gone")
"""Kinds of drift: the first word of each description."""


class DriftFeature(Feature[Mapping[str, str]]):
    """The feature of drafts; its settings are the drift that may be there: `Drift.key` -> the reason."""

    name = "draft"
    group = "verdict"
    options = (
        Repeatable(
            "known-drift",
            "DRIFT",
            "drift that may be there, as 'message alarm'",
            "one a line, 'message alarm: reason': drift that may be there",
            shown=False,
        ),
    )

    def read(self, reader: OptionReader) -> Mapping[str, str]:
        """The known drift. Raises pytest.UsageError for an unknown kind."""
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
        return known


FEATURE = DriftFeature()
"""The feature whose settings `hricdv update` reads."""
