"""The timeline of a run as a record of its own: optional parts, whose records the model has, keep some of runs that are
no tests of the report."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv._base.record import Names, NotNegative, PlainRecord


class Timeline(PlainRecord, frozen=True, kw_only=True):
    """What happened in a run, thinned to what a picture can show.

    Args:
        end_s: when the run ended.
        messages: time (s), sender, topic and the fields as JSON, separated by tabs.
        signals: name -> "time value time value ...", each value from its time (s) on.
        triggers: requirement -> "begin-end begin-end! begin-end?" (s), `!` where it failed, `?` where it is pending.
        checksums: signal -> CRC-32 (hexadecimal) of all its changes, bit by bit, before they were thinned.
        texts: signals that are texts: name -> (time, text), each from its time (s) on.
    """

    end_s: NotNegative
    messages: Names
    signals: Mapping[str, str]
    triggers: Mapping[str, str]
    checksums: Mapping[str, str] = {}
    texts: Mapping[str, tuple[tuple[NotNegative, str], ...]] = {}
