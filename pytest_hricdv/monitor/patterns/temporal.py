"""Patterns of order and time, after Dwyer, Avrunin and Corbett (1999), "Patterns in Property Specifications for
Finite-State Verification", ICSE; with time limits in seconds.

An *event* may be an instant, such as `on(topic)`, or a condition that lasts, which then happens when it becomes true.
The scope of a requirement is always named, as it says when the requirement was checked:

- `during=condition`: as long as the condition is true;
- `after=event`: from each such event on to the end of the run, or until the next event `until`, or for `for_s` seconds.
"""

from __future__ import annotations

import math

from pytest_hricdv.monitor.build import always, count, eventually, once, previously, since
from pytest_hricdv.monitor.dsl import TruthValue
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.patterns.pattern import PatternError, as_event, pattern, require_duration

MAX_IN_SCOPE = 20
"""Limit of `existence(at_most=...)` in a scope: each event nests the formula three operators deeper, in all half of
the 128 that :data:`~pytest_hricdv.monitor.syntax_tree.MAX_BUILT_DEPTH` allows; the other half is for the arguments."""


@pattern
def response(trigger: TruthValue, reaction: TruthValue, *, within_s: float, after_s: float = 0.0) -> Formula:
    """Each trigger is followed by a reaction, at most `within_s` and at least `after_s` seconds later.

    Formula: `always(trigger -> eventually[after_s:within_s](reaction))`. Scope: the whole run; one reaction answers all
    triggers for which it is in time. Source: Dwyer et al., Response.

    Raises:
        PatternError: `within_s` is 0 or before `after_s`, or an argument is of a wrong type.

    >>> from pytest_hricdv.monitor.build import on
    >>> print(response(on("request"), on("leg_ready"), within_s=30))
    always(on(request) -> eventually[0:30](on(leg_ready)))
    """
    if within_s == 0 or within_s < after_s:
        raise PatternError("within_s", f"expected a time after the trigger and not before after_s, got {within_s}")
    return always(trigger >> eventually(reaction, after_s, within_s))


@pattern
def precedence(
    cause: TruthValue,
    event: TruthValue,
    *,
    within_s: float | None = None,
    after: TruthValue | None = None,
) -> Formula:
    """Each event was preceded by its cause, at the same instant or before.

    With `within_s`, the cause was at most this time (s) before. With `after`, each such event makes a new cause
    necessary. One cause is enough for several events; `existence` bounds their number.

    Formula: `always(event -> once[0:within_s](cause) & (!after since cause))`, each part if it is asked for; without
    both, `always(event -> once(cause))`. Scope: the whole run. Source: Dwyer et al., Precedence.

    Raises:
        PatternError: an argument is of a wrong type.

    >>> from pytest_hricdv.monitor.build import on, signal
    >>> print(precedence(on("request"), on("leg_ready")))
    always(on(leg_ready) -> once(on(request)))
    >>> print(precedence(on("ready"), signal("hand_open"), after=on("request")))
    always(rise(hand_open) -> !on(request) since on(ready))
    """
    if within_s is None and after is None:
        return always(event >> once(cause))
    recent = once(cause, 0, math.inf if within_s is None else within_s)
    if after is None:
        return always(as_event(event) >> recent)
    anew = since(~as_event(after), cause)
    return always(as_event(event) >> (anew if within_s is None else recent & anew))


@pattern
def absence(
    event: TruthValue,
    *,
    during: TruthValue | None = None,
    after: TruthValue | None = None,
    until: TruthValue | None = None,
    for_s: float | None = None,
) -> Formula:
    """The event does not happen, and a condition is not true, in the scope.

    Formula: `always(during -> !event)`; `always(after -> always[0:inf](!event))`;
    `always(after -> always(!event) until until)`; `always(after -> always[0:for_s](!event))`. Scope: see the module;
    exactly one of `during` and `after`. Source: Dwyer et al., Absence.

    Raises:
        PatternError: arguments of a scope that do not go together, or an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import fall, on, signal
    >>> print(absence(fall(signal("leg_held")), after=on("not_ready"), until=on("request")))
    always(on(not_ready) -> always(!fall(leg_held)) until on(request))
    """
    return _in_scope(~event, during, after, until, for_s)


@pattern
def universality(
    condition: TruthValue,
    *,
    during: TruthValue | None = None,
    after: TruthValue | None = None,
    until: TruthValue | None = None,
    for_s: float | None = None,
) -> Formula:
    """The condition is true at all times of the scope.

    Formula: `always(during -> condition)`; `always(after -> always[0:inf](condition))`;
    `always(after -> always(condition) until until)`; `always(after -> always[0:for_s](condition))`. Scope: see the
    module; exactly one of `during` and `after`. Source: Dwyer et al., Universality.

    Raises:
        PatternError: a condition that is true for single instants only, arguments of a scope that do not go together,
            or an argument of a wrong type.

    >>> from pytest_hricdv.monitor.build import on, signal
    >>> print(universality(signal("gripper_closed"), during=signal("carrying")))
    always(carrying -> gripper_closed)
    """
    return _in_scope(require_duration(condition, "condition"), during, after, until, for_s)


@pattern
def existence(
    event: TruthValue,
    *,
    at_most: int,
    within_s: float | None = None,
    after: TruthValue | None = None,
    until: TruthValue | None = None,
) -> Formula:
    """The event happens at most `at_most` times: in the run, in any `within_s` seconds, or in a scope.

    Formula: `always(event -> count(event) <= at_most)`; with a time, `count[0:within_s](event)`; for a scope,
    `always(after -> always(!next) until until)`, where `next` is an event with a given number of predecessors in the
    scope: for one, `event & !after & previously(!after since event)`. Scope: the whole run, or see the module; each
    `after` begins to count again, and in a scope messages of one instant count once. Source: Dwyer et al., Bounded
    Existence. (That something happens at all is a `response`.)

    Raises:
        PatternError: `at_most` is below 1 (in a scope, or above 20), arguments that do not go together, or an argument
            of a wrong type.

    >>> from pytest_hricdv.monitor.build import on
    >>> print(existence(on("leg_ready"), at_most=1, within_s=5))
    always(on(leg_ready) -> count[0:5](on(leg_ready)) <= 1)
    >>> print(existence(on("turn_done"), at_most=1, after=on("request")))
    always(on(request) -> always[0:inf](!(on(turn_done) & !on(request) & previously(!on(request) since on(turn_done)))))
    """
    if at_most < 1:
        raise PatternError("at_most", f"expected a number of at least 1, got {at_most}; for 0, use absence")
    event = as_event(event)
    if after is None:
        if until is not None:
            raise PatternError("until", "ends a scope that begins with `after`; there is no `after`")
        return always(event >> (count(event, 0, math.inf if within_s is None else within_s) <= at_most))
    if within_s is not None:
        raise PatternError("within_s", "expected one of within_s and after")
    if at_most > MAX_IN_SCOPE:
        raise PatternError("at_most", f"expected at most {MAX_IN_SCOPE} in a scope, got {at_most}")
    nth, outside = event, ~as_event(after)
    for _ in range(at_most):
        nth = event & outside & previously(since(outside, nth))
    return _in_scope(~nth, None, after, until, None)


def _in_scope(
    condition: TruthValue,
    during: TruthValue | None,
    after: TruthValue | None,
    until: TruthValue | None,
    for_s: float | None,
) -> Formula:
    """The condition at all times of a scope."""
    if during is not None:
        for name, value in (("after", after), ("until", until), ("for_s", for_s)):
            if value is not None:
                raise PatternError(name, "does not go with `during`, which is a scope by itself")
        return always(during >> condition)
    if after is None:
        raise PatternError("", "no scope; expected `during=condition` or `after=event`")
    if until is None:
        return always(after >> always(condition, 0, _length(for_s)))
    if for_s is not None:
        raise PatternError("for_s", "expected one of until and for_s")
    return always(after >> always(condition).until(until))


def _length(for_s: float | None) -> float:
    if for_s == 0:
        raise PatternError("for_s", "expected a number above 0, got 0; times are in seconds")
    return math.inf if for_s is None else for_s
