"""Requirements written in Python: functions and operators that build the same formulas as the text.

>>> ready = on("reading") & field("reading.gaze") & field("reading.pressure")
>>> print(always(ready >> eventually(fall(signal("leg_held")) & (signal("leg_offset") < 0.15), 0, 10)))
always(on(reading) & reading.gaze & reading.pressure -> eventually[0:10](fall(leg_held) & leg_offset < 0.15))

`& | ~` are "and", "or", "not", and `>>` is the arrow between antecedent and response. In Python they bind more strongly
than comparisons, so a comparison needs parentheses; without them there is an error with this advice. Times are seconds.

Names and types are checked against a vocabulary later: by `check_requirement`, or when a testbench loads the
requirements.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import overload

from pytest_hricdv.monitor import past_formula
from pytest_hricdv.monitor.dsl import (
    ComparisonValue,
    Implication,
    NameValue,
    NumberValue,
    TextValue,
    TruthValue,
    as_number,
    as_past,
    as_term,
    as_text,
)
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, HoldsUntil
from pytest_hricdv.monitor.node import IDENTIFIER, PastFormula, last_of
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.terms import Count, TimeBetween, TimeSince
from pytest_hricdv.monitor.units import MAX_TIME_S

__all__ = [
    "always",
    "count",
    "equal",
    "eventually",
    "fall",
    "field",
    "historically",
    "last",
    "on",
    "once",
    "previously",
    "requirement",
    "rise",
    "signal",
    "since",
    "string",
    "time_between",
    "time_since",
    "unequal",
]

Operand = NumberValue | TextValue | float | str

# --- names


def signal(name: str) -> NameValue:
    """A signal: a condition if it is a bool, a number if it is a float. Raises ValueError for an invalid name."""
    return NameValue(_identifier(name))


def field(name: str) -> NameValue:
    """The last value of a message's field, written `topic.field`. Raises ValueError for an invalid name."""
    return NameValue(_field_name(name))


def last(name: str) -> NameValue:
    """The value that a field, written `topic.field`, had in the message before. Raises ValueError as above."""
    return NameValue(last_of(_field_name(name)))


def string(name: str) -> TextValue:
    """A signal, or `topic.field`, that is a string; needed only to compare two of them. Raises ValueError as above."""
    return TextValue((field(name) if "." in name else signal(name)).text)


def on(topic: str) -> TruthValue:
    """True at the instant at which a message of the topic arrives. Raises ValueError for an invalid name."""
    return TruthValue(past_formula.On(_identifier(topic)))


# --- conditions


def equal(left: Operand, right: Operand) -> ComparisonValue:
    """`left == right`, of numbers or of texts. (Python's `==` would compare the Python objects.)

    Where one side is a string, or `string(name)`, both are strings.
    """
    return _equality("==", left, right)


def unequal(left: Operand, right: Operand) -> ComparisonValue:
    """`left != right`, of numbers or of texts."""
    return _equality("!=", left, right)


def rise(condition: TruthValue) -> TruthValue:
    """True at the instant at which `condition` becomes true."""
    return TruthValue(past_formula.Rise(as_past(condition)))


def fall(condition: TruthValue) -> TruthValue:
    """True at the instant at which `condition` becomes false."""
    return TruthValue(past_formula.Fall(as_past(condition)))


def previously(condition: TruthValue) -> TruthValue:
    """`condition` just before the instant."""
    return TruthValue(past_formula.Previously(as_past(condition)))


def once(condition: TruthValue, start_s: float = 0.0, end_s: float = math.inf) -> TruthValue:
    """`condition` was true at some time between `end_s` and `start_s` seconds ago; without a window: ever."""
    return TruthValue(past_formula.Once(as_past(condition), *_window(start_s, end_s)))


def historically(condition: TruthValue, start_s: float = 0.0, end_s: float = math.inf) -> TruthValue:
    """`condition` was true at all times between `end_s` and `start_s` seconds ago; without a window: always."""
    return TruthValue(past_formula.Historically(as_past(condition), *_window(start_s, end_s)))


def since(condition: TruthValue, start: TruthValue) -> TruthValue:
    """`condition since start`: `start` was true, and `condition` has been true since then."""
    return TruthValue(past_formula.Since(as_past(condition), as_past(start)))


# --- numbers over the past


def count(condition: TruthValue, start_s: float = 0.0, end_s: float = math.inf) -> NumberValue:
    """How often `condition` became true between `end_s` and `start_s` seconds ago; without a window: so far."""
    return NumberValue(Count(as_past(condition), *_window(start_s, end_s)))


def time_since(condition: TruthValue) -> NumberValue:
    """The time (s) since `condition` was last true, infinite before; to be compared with a number."""
    return NumberValue(TimeSince(as_past(condition)))


def time_between(begin: TruthValue, end: TruthValue) -> NumberValue:
    """The time (s) from when `begin` last became true to when `end` last did; no value before, as for `last`."""
    return NumberValue(TimeBetween(as_past(begin), as_past(end)))


# --- responses and formulas


class UnfinishedAlways:
    """`always(condition)`: a response only with `.until(release)`."""

    def __init__(self, condition: PastFormula) -> None:
        self._condition = condition

    def until(self, release: TruthValue) -> HoldsUntil:
        """`always(condition) until release`: from the trigger until `release`, or to the end of the run."""
        return HoldsUntil(self._condition, as_past(release))

    def __repr__(self) -> str:
        return f"<always({self._condition}), without window or until>"


def eventually(condition: TruthValue, start_s: float, end_s: float) -> Eventually:
    """The response `eventually[a:b](condition)`: true at some time from `start_s` to `end_s` after the trigger."""
    return Eventually(as_past(condition), *_response_window(start_s, end_s))


@overload
def always(required: Implication) -> Formula: ...
@overload
def always(required: TruthValue) -> UnfinishedAlways: ...
@overload
def always(required: TruthValue, start_s: float, end_s: float) -> AlwaysWithin: ...
def always(
    required: Implication | TruthValue, start_s: float | None = None, end_s: float | None = None
) -> Formula | UnfinishedAlways | AlwaysWithin:
    """As in the text: a whole formula, or a response.

    `always(antecedent >> response)` is a formula. As responses, `always(condition, a, b)` requires `condition` at all
    times from `a` to `b` seconds after the trigger, and `always(condition).until(release)` until `release`.

    Raises:
        TypeError: neither an implication nor a condition, or only one end of a window.
        ValueError: a window that ends before it starts, or with the trigger.
    """
    if isinstance(required, Implication):
        if start_s is not None or end_s is not None:
            raise TypeError("a window belongs to a response: always(antecedent >> always(condition, a, b))")
        return Formula(required.antecedent, required.response)
    condition = as_past(required)
    if start_s is None and end_s is None:
        return UnfinishedAlways(condition)
    if start_s is None or end_s is None:
        raise TypeError("a window has two ends: always(condition, a, b), in seconds after the trigger")
    return AlwaysWithin(condition, *_response_window(start_s, end_s))


def requirement(
    id: str, title: str, formula: Formula, source: str = "", shows: Sequence[str] = (), group: str = ""
) -> Requirement:
    """A requirement as from a table of a TOML file; its text is written from the formula.

    Args:
        id: such as `R1`.
        title: the requirement in one sentence.
        formula: the result of `always(antecedent >> response)`.
        source: where it comes from; may be empty.
        shows: numeric signals that a violation reports in addition (see `Requirement`).
        group: what it belongs to, for reports; may be empty.

    Raises:
        TypeError: `formula` is not a formula, for instance because the antecedent is missing.
    """
    if not isinstance(formula, Formula):
        raise TypeError(f"{id}: expected always(antecedent >> response), got {formula!r}")
    return Requirement(id, title, source, str(formula), formula, tuple(shows), group)


def _equality(relation: past_formula.Equality, left: Operand, right: Operand) -> ComparisonValue:
    if isinstance(left, str | TextValue) or isinstance(right, str | TextValue):
        return ComparisonValue(past_formula.TextComparison(relation, as_text(left), as_text(right)))
    return ComparisonValue(past_formula.NumberComparison(relation, as_term(left), as_term(right)))


def _field_name(name: str) -> str:
    topic, _, member = name.partition(".")
    return f"{_identifier(topic)}.{_identifier(member)}"


def _identifier(name: str) -> str:
    if not IDENTIFIER.fullmatch(name):
        raise ValueError(f"{name!r} is not a valid name: signal(name), on(topic), field('topic.field')")
    return name


def _response_window(start_s: float, end_s: float) -> tuple[float, float]:
    window = _window(start_s, end_s)
    if window[1] == 0:
        advice = "for a response at the very instant of the trigger leave the window out"
        raise ValueError(f"a window of a response has to end after the trigger, got 0 to 0; {advice}")
    return window


def _window(start_s: float, end_s: float) -> tuple[float, float]:
    window = as_number(start_s, "the start of a window"), as_number(end_s, "the end of a window", allow_infinite=True)
    if window[1] < window[0]:
        raise ValueError(f"a window from a to b needs a <= b, got {start_s} to {end_s}; times are in seconds")
    if any(MAX_TIME_S < time_s < math.inf for time_s in window):
        raise ValueError(f"a window has times of at most {MAX_TIME_S:g} s, got {start_s} to {end_s}")
    return window
