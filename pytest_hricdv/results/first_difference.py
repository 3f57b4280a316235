"""The first difference of two runs of a test, for `behaviour_diff`: of messages, else of their end, else of signals."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

from pytest_hricdv._base import own_json as json
from pytest_hricdv.results.behaviour import Behaviour, BusMessage

_ABSENT = object()


_NEVER = sys.maxsize
"""A number of messages that is greater than that of any run."""


class FirstDifference(NamedTuple):
    """The first difference of two runs: its kind, without times and numbers, and the whole difference as text.

    `time_s` (s) and `topic` are of the message that differs; None and empty if all messages are the same.
    """

    kind: str
    text: str
    time_s: float | None = None
    topic: str = ""


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


def _other_end(before: Behaviour, now: Behaviour) -> FirstDifference | None:
    for kind, text in end_differences(before, now):
        return FirstDifference(kind, f"the messages are the same, but it {text}")
    return None


def end_differences(before: Behaviour, now: Behaviour) -> Iterator[tuple[str, str]]:
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
