"""Compares the behaviour of tests with a baseline: which ones differ, and the first difference of each."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

from msgspec.structs import replace

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.hash_seed import hash_seed_difference
from pytest_hricdv.results.baseline import (
    Baseline,
    SuiteBaseline,
    baseline_of,
    behaviour_of,
    environment_of,
    hash_seed,
)
from pytest_hricdv.results.behaviour import Behaviour, BehaviourChange, BehaviourChanges, BusMessage, ChangeKind
from pytest_hricdv.results.model import Report, SuiteResult, TestResult
from pytest_hricdv.results.section import failure_causes

_ABSENT = object()
_NEVER = sys.maxsize
"""Farther than any message of a run."""


class FirstDifference(NamedTuple):
    """The first difference of two runs: its kind, without times and numbers, and all of it as text.

    `time_s` (s) and `topic` are of the message that differs; None and empty if all messages are the same.
    """

    kind: str
    text: str
    time_s: float | None = None
    topic: str = ""


def compare_behaviour(report: Report, baseline: Baseline, *, whole: bool) -> BehaviourChanges:
    """Compare what each test of a report did with a baseline. Tests that were not run are left out.

    Args:
        whole: all tests of the suites were selected.
    """
    suites = {suite.name: baseline.suites.get(suite.name) for suite in report.suites}
    run = [test for test in report.tests if test.outcome != "not-run"]
    pairs = [(test, _before(suites.get(test.suite), test)) for test in run]
    compared = [(test, before) for test, before in pairs if before is not None]
    changes = {test.nodeid: change_of(before, behaviour_of(test)) for test, before in compared}
    changed = {nodeid: change for nodeid, change in changes.items() if change is not None}
    return BehaviourChanges(
        compared=len(compared),
        changed=changed,
        kinds=_kinds(changed),
        new=tuple(test.id for test, before in pairs if before is None and _has_behaviour(suites.get(test.suite))),
        removed=tuple(_list_removed_tests(report, suites)) if whole else (),
        notes=tuple(dict.fromkeys(_notes(report, suites, changed=bool(changed)))),
    )


def compare_with_session_before(report: Report, before: Report, *, whole: bool) -> BehaviourChanges | None:
    """Compare what each test did with the session before; None where nothing changed, or nothing can be compared.

    Tests that were not run then, as of a session that was interrupted and is resumed, are left out.

    Args:
        whole: all tests of the suites were selected: a cause that none of them fails for is gone.
    """
    seeds = {suite.name: suite.seed for suite in report.suites}
    suites = tuple(suite for suite in before.suites if seeds.get(suite.name) == suite.seed)
    tests = tuple(test for test in before.tests if test.outcome != "not-run")
    records = {test.nodeid: test.record_sha256 for test in tests}
    same = all(records.get(test.nodeid, test.record_sha256) == test.record_sha256 for test in report.tests)
    if same or before.testbench != report.testbench:
        return None
    changes = compare_behaviour(report, baseline_of(replace(before, suites=suites, tests=tests)), whole=False)
    if not changes.changed:
        return None
    causes = tuple(_list_cause_changes(report, before, whole=whole and not before.not_run))
    return replace(changes, against="session before", new=(), notes=(*causes, *changes.notes))


def _list_cause_changes(report: Report, before: Report, *, whole: bool) -> Iterator[str]:
    """The causes that the session before did not have, and of whole sessions those that are gone."""
    now, old = failure_causes(report), failure_causes(before)
    if now is None or old is None:
        return
    yield from (f"new cause {name}: {words}" for name, words in now.items() if name not in old)
    if whole:
        yield from (f"cause {name} is gone: {words}" for name, words in old.items() if name not in now)


def _has_behaviour(suite: SuiteBaseline | None) -> bool:
    """Whether a test that it lacks is new: what an older version wrote lacks all tests."""
    return suite is None or suite.tests is not None


def _before(suite: SuiteBaseline | None, test: TestResult) -> Behaviour | None:
    tests = (suite.tests if suite else None) or {}
    return tests.get(test.nodeid) or tests.get(test.id)


def headline(changes: BehaviourChanges) -> str:
    """`12 of 134 tests behave differently from the baseline`, or from the session before."""
    count = len(changes.changed)
    if not changes.compared:
        return f"the behaviour of no test was compared with the {changes.against}"
    if not count:
        return f"all {changes.compared} tests behave as in the {changes.against}"
    return f"{count} of {changes.compared} tests behave{'s' * (count == 1)} differently from the {changes.against}"


def change_of(before: Behaviour, now: Behaviour) -> BehaviourChange | None:
    """The change between two runs of a test; None if their records are bit-identical and their ends are equal."""
    if before.record_sha256 == now.record_sha256 and not any(_ends(before, now)):
        return None
    first = first_difference(before, now)
    return BehaviourChange(
        kind=first.kind,
        text=first.text,
        time_s=first.time_s,
        topic=first.topic,
        also=tuple(_also(before, now)),
        before=before,
    )


def first_difference(before: Behaviour, now: Behaviour) -> FirstDifference:
    """The first difference of two runs that are not the same: of messages; else of the end; else of signals."""
    if now.record_sha256 is None:
        return FirstDifference("ends in error", "the test is in error; before, its run came to its end")
    if before.record_sha256 is None:
        return FirstDifference("no longer in error", "the run came to its end; before, the test was in error")
    first = _first_message(before.messages, now.messages) or _other_end(before, now) or _other_signals(before, now)
    if before.parameters == now.parameters:
        return first
    return first._replace(kind="has other parameters", text=f"the test itself has other parameters; {first.text}")


# Messages


def _first_message(before: Sequence[BusMessage], now: Sequence[BusMessage]) -> FirstDifference | None:
    for number, (old, new) in enumerate(zip_longest(before, now)):
        if new is None:
            return _describe_absent_message(old)
        if old is None:
            return _extra(new)
        if _content(old) != _content(new):
            return _other_message(before[number:], now[number:])
        if old.time_s != new.time_s:
            return _describe_late_message(old, new)
    return None


def _content(message: BusMessage) -> tuple[str, str, Mapping[str, Any]]:
    return message.sender, message.topic, message.fields


def _other_message(before: Sequence[BusMessage], now: Sequence[BusMessage]) -> FirstDifference:
    """The first difference of two sequences that begin with different messages: the earlier of the two.

    It comes early or late if the other run has it too, and sooner than the other message; else it is extra or missing.
    If neither run has the other's message, one is instead of the other.
    """
    old, new = before[0], now[0]
    if (old.sender, old.topic) == (new.sender, new.topic):
        return _other_fields(old, new)
    to_new, to_old = _distance(new, before), _distance(old, now)
    if to_new == to_old and (to_new == _NEVER or old.time_s == new.time_s):
        return _instead(old, new)
    if new.time_s < old.time_s:
        return _describe_late_message(before[to_new], new) if to_new <= to_old else _extra(new)
    if old.time_s < new.time_s:
        return _describe_late_message(old, now[to_old]) if to_old <= to_new else _describe_absent_message(old)
    return _describe_absent_message(old) if to_new < to_old else _extra(new)


def _distance(message: BusMessage, sequence: Sequence[BusMessage]) -> int:
    """The number of messages before the same content comes."""
    return next((n for n, later in enumerate(sequence) if _content(later) == _content(message)), _NEVER)


def _other_fields(old: BusMessage, new: BusMessage) -> FirstDifference:
    names = dict.fromkeys((*old.fields, *new.fields))
    other = [name for name in names if old.fields.get(name, _ABSENT) != new.fields.get(name, _ABSENT)]
    return _instead(old, new, other)


def _instead(old: BusMessage, new: BusMessage, names: Sequence[str] | None = None) -> FirstDifference:
    """A message in place of another; if only some fields differ, `names` are these."""
    kind, kind_before = (_message_text(message, names, words=True) for message in (new, old))
    said, said_before = (_message_text(message, names) for message in (new, old))
    fields = ", ".join(f"`{name}`" for name in names or ())
    if kind != kind_before:
        kind = f"{kind} instead of {kind_before}"
    elif not names:
        kind = f"{kind} from another sender"
    elif said != said_before:
        kind = f"`{new.topic}` with another {fields}"
    else:
        kind = f"`{new.topic}` with a slightly other {fields}"
        said, said_before = (_message_text(message, names, exact=True) for message in (new, old))
    before_s = "" if _tenths(old.time_s) == _tenths(new.time_s) else f" at {_tenths(old.time_s)}"
    text = f"at {_tenths(new.time_s)} {said} instead of {said_before}{before_s}"
    return FirstDifference(kind, text, new.time_s, new.topic)


def _describe_absent_message(old: BusMessage) -> FirstDifference:
    return _at(old, "is missing")


def _extra(new: BusMessage) -> FirstDifference:
    return _at(new, "is extra")


def _at(message: BusMessage, verb: str) -> FirstDifference:
    text = f"at {_tenths(message.time_s)} {_message_text(message)} {verb}"
    return FirstDifference(f"{_message_text(message, words=True)} {verb}", text, message.time_s, message.topic)


def _describe_late_message(old: BusMessage, new: BusMessage) -> FirstDifference:
    by_s = new.time_s - old.time_s
    size = f"{abs(by_s):.1f} s" if abs(by_s) >= 0.05 else f"{abs(by_s):.3f} s"
    how = "later" if by_s > 0 else "earlier"
    text = f"at {_tenths(new.time_s)} {_message_text(new)}, {size} {how} than before"
    return FirstDifference(f"{_message_text(new, words=True)} {how}", text, min(old.time_s, new.time_s), new.topic)


def _message_text(
    message: BusMessage, names: Sequence[str] | None = None, *, words: bool = False, exact: bool = False
) -> str:
    """A message as `topic(values)`: of these fields, or of all; with `words` without numbers."""
    shown = {name: value for name, value in message.fields.items() if names is None or name in names}
    if words:
        shown = {name: value for name, value in shown.items() if isinstance(value, str | bool)}
    match [*shown.items()]:
        case []:
            return f"`{message.topic}`"
        case [(_, str(only))]:
            return f"`{message.topic}({_value(only, exact)})`"
        case several:
            return f"`{message.topic}({', '.join(f'{name}={_value(value, exact)}' for name, value in several)})`"


def _value(value: object, exact: bool) -> str:
    """Numbers with six digits, and texts of limited length, unless they have to be exact."""
    text = f"{value:.6g}" if isinstance(value, float) and not exact else _text(value)
    return text if exact or len(text) <= 40 else f"{text[:37]}..."


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _tenths(time_s: float) -> str:
    return f"{time_s:.1f} s"


# The end, signals, verdicts


def _other_end(before: Behaviour, now: Behaviour) -> FirstDifference | None:
    for kind, text in _ends(before, now):
        return FirstDifference(kind, f"the messages are the same, but it {text}")
    return None


def _ends(before: Behaviour, now: Behaviour) -> Iterator[tuple[str, str]]:
    """How else a run ended, as kind and text."""
    if before.end_reason != now.end_reason:
        text = f"ended with {now.end_reason!r} instead of {before.end_reason!r}"
        yield text, text
    if before.outcomes != now.outcomes:
        new, old = (", ".join(outcomes) or "none" for outcomes in (now.outcomes, before.outcomes))
        yield "other outcomes", f"had the outcomes {new} instead of {old}"
    if before.errors != now.errors:
        new, old = ("; ".join(faults) or "none" for faults in (now.errors, before.errors))
        yield "other faults", f"had the faults {new} instead of {old}"


def _other_signals(before: Behaviour, now: Behaviour) -> FirstDifference:
    old, new = before.signals, now.signals
    groups = {
        ("differs", "differ"): [name for name in new if name in old and new[name] != old[name]],
        ("is new", "are new"): [name for name in new if name not in old],
        ("is missing", "are missing"): [name for name in old if name not in new],
    }
    sentences = [
        f"signal{'s' * (len(names) > 1)} {', '.join(sorted(names))} {verbs[len(names) > 1]}"
        for verbs, names in groups.items()
        if names
    ]
    if not sentences:
        return FirstDifference(
            "messages less than 1 ms earlier or later", "messages come less than 1 ms earlier or later"
        )
    return FirstDifference("only signals differ", f"the messages are the same, but {'; '.join(sentences)}")


def _also(before: Behaviour, now: Behaviour) -> Iterator[str]:
    """The consequences of the first difference: the end, outcomes, faults, verdicts, margins."""
    yield from (text for _, text in _ends(before, now))
    for name, (verdict, margin) in now.verdicts.items():
        old_verdict, old_margin = before.verdicts.get(name, ("", None))
        if old_verdict and verdict != old_verdict:
            yield f"{name} {verdict} instead of {old_verdict}"
        elif margin != old_margin and None not in (margin, old_margin):
            yield f"margin of {name} {margin:.4g} instead of {old_margin:.4g}"


# The whole


def _kinds(changed: Mapping[str, BehaviourChange]) -> tuple[ChangeKind, ...]:
    by_kind: dict[str, list[str]] = {}
    for nodeid in sorted(changed, key=lambda nodeid: (changed[nodeid].time_s or 0.0, nodeid)):
        by_kind.setdefault(changed[nodeid].kind, []).append(nodeid)
    kinds = [ChangeKind(kind=kind, tests=len(nodeids), example=nodeids[0]) for kind, nodeids in by_kind.items()]
    return tuple(sorted(kinds, key=lambda kind: (-kind.tests, kind.kind)))


def _list_removed_tests(report: Report, suites: Mapping[str, SuiteBaseline | None]) -> Iterator[str]:
    present = {name for test in report.tests for name in (test.id, test.nodeid)}
    for before in suites.values():
        yield from sorted(name for name in (before and before.tests) or () if name not in present)


def _notes(report: Report, suites: Mapping[str, SuiteBaseline | None], *, changed: bool) -> Iterator[str]:
    for suite in report.suites:
        before = suites[suite.name]
        if before is None:
            continue
        if before.tests is None:
            yield (
                f"the baseline has no behaviour of suite {suite.name}, because an older version wrote it: "
                "--hri-update-baseline adds it"
            )
        elif changed:
            yield from _causes(before, report, suite)
        elif before.code_sha256 != report.code_under_test.sha256:
            yield "the code under test has changed, and none of these tests shows it"


def _causes(before: SuiteBaseline, report: Report, suite: SuiteResult) -> Iterator[str]:
    """Possible causes of the changed behaviour other than the code under test."""
    for name, version in environment_of(report, suite).items():
        old = before.environment.get(name, version)
        if old != version:
            yield f"{name} was {old} before, and is {version} now: records may differ for that"
    other_seed = hash_seed_difference(before.hash_seed, hash_seed(report))
    if other_seed:
        yield (
            f"Python's hash seed is another one than before ({other_seed}): code that goes through a set does so in "
            f"another order; set PYTHONHASHSEED={before.hash_seed if before.hash_seed.isdigit() else '0'} for both"
        )
    if before.code_sha256 == report.code_under_test.sha256:
        yield (
            "the code under test is the same as before, so the testbench, its world, the model or a library "
            f"has changed, {'if it is not the hash seed, ' if other_seed else ''}or runs depend on what is another one "
            "each time, such as a clock"
        )
