"""Types of a run's behaviour, in full (`Timeline`) and in short (`Behaviour`), and of its `BehaviourChanges`.

A report has a `Timeline` of each test, and a baseline a `Behaviour`; `behaviour_diff` compares them. Runs are
deterministic: if two records of one test differ, the code under test, the testbench, its world or a library changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from pytest_hricdv._base.record import Count, Names, NotNegative, Number, PlainRecord


class BusMessage(NamedTuple):
    """One message on the bus: its time (s, to the millisecond), sender, topic and fields. In JSON an array."""

    time_s: Number
    sender: str
    topic: str
    fields: Mapping[str, Any]


class Timeline(PlainRecord, frozen=True, kw_only=True):
    """The timeline of a run, thinned to what a picture can show.

    Args:
        end_s: when the run ended.
        messages: time (s), sender, topic and the fields as JSON, separated by tabs.
        signals: name -> "time value time value ...", each value from its time (s) on.
        triggers: requirement -> "begin-end begin-end! begin-end?" (s), `!` where it failed, `?` where it is pending.
        checksums: signal -> CRC-32 (hexadecimal) of all its changes, bit for bit, before they were thinned.
        texts: signals that are strings: name -> (time, text), each from its time (s) on.
    """

    end_s: NotNegative
    messages: Names
    signals: Mapping[str, str]
    triggers: Mapping[str, str]
    checksums: Mapping[str, str] = {}
    texts: Mapping[str, tuple[tuple[NotNegative, str], ...]] = {}


class Behaviour(PlainRecord, frozen=True, kw_only=True):
    """The behaviour of one run.

    Args:
        record_sha256: SHA-256 of the whole record, bit for bit; None if no run came to an end.
        parameters: checksum of the concrete test, so of what the run was given.
        end_reason: why the run ended, in the testbench's words.
        end_s: when (s of simulated time).
        outcomes: how each interaction ended, in order.
        messages: all, in order.
        signals: name -> checksum of all changes of the signal.
        verdicts: requirement -> verdict, and margin to six digits.
        errors: what was wrong with the run besides its requirements.
    """

    record_sha256: str | None
    parameters: str
    end_reason: str
    end_s: NotNegative
    outcomes: Names
    messages: tuple[BusMessage, ...]
    signals: Mapping[str, str]
    verdicts: Mapping[str, tuple[str, Number | None]]
    errors: Names = ()


class BehaviourChange(PlainRecord, frozen=True, kw_only=True):
    """A test that behaves differently from the baseline.

    Args:
        kind: the kind of the first difference, without times and numbers, so that equal kinds can be counted.
        text: the first difference, with times and values.
        time_s: when it was (s); None if all messages are the same.
        topic: the topic of the message that differs first; empty if all messages are the same.
        also: what else differs: the end, outcomes, faults, verdicts and margins; a sentence each.
        before: the behaviour in the baseline.
    """

    kind: str
    text: str
    time_s: NotNegative | None
    topic: str
    also: Names
    before: Behaviour


class ChangeKind(PlainRecord, frozen=True, kw_only=True):
    """Changes of one kind: how many tests, and the node id of the one that differs earliest."""

    kind: str
    tests: Count
    example: str


class BehaviourChanges(PlainRecord, frozen=True, kw_only=True):
    """A session's tests compared with a baseline, or where there is none with the session before.

    Args:
        compared: how many tests ran and are in the baseline.
        changed: node id -> change, of those that behave differently.
        kinds: the kinds of changes, the most frequent first.
        new: ids of tests that ran and are not in the baseline.
        removed: tests of the baseline that the suites no longer have; of a part of the tests none is listed.
        notes: what is to be known about the comparison, a sentence each.
        against: what they are compared with.
    """

    compared: Count
    changed: Mapping[str, BehaviourChange]
    kinds: tuple[ChangeKind, ...]
    new: Names
    removed: Names
    notes: Names
    against: Literal["baseline", "session before"] = "baseline"


class Difference(PlainRecord, frozen=True, kw_only=True):
    """A difference of a suite from the baseline.

    Args:
        what: for instance "R3 violated by", "statements" or "bins of handover".
        before: the value in the baseline, with its unit.
        now: the value in this run, likewise.
        items: the tests, plans or bins that came or went; empty if it is about a number only.
        worse: whether it fails the session; otherwise it is better.
        text: the same as a sentence, with the first items only.
    """

    suite: str
    what: str
    before: str
    now: str
    items: Names
    worse: bool
    text: str
