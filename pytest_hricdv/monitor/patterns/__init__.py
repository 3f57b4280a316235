"""Requirement patterns: functions that take conditions and numbers, and return the formula of a requirement.

>>> from pytest_hricdv.monitor.build import on, requirement
>>> request, leg_ready = on("request"), on("leg_ready")
>>> progress = requirement("P1", "A request is answered", response(request, leg_ready, within_s=30))
>>> print(progress.text)
always(on(request) -> eventually[0:30](on(leg_ready)))

In a file of requirements, the key `pattern` has the same call as text, with formulas of the language as arguments.

Modules: `pattern` (what a pattern is), `temporal` (order and time), `collaboration` (work with people),
`contact_limits` (limits of contact by region of the body, from a file).
"""

from collections.abc import Callable, Mapping

from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.patterns.collaboration import (
    contact_pressure,
    hand_guiding,
    power_and_force,
    protective_separation,
    protective_stop,
    speed_and_separation,
)
from pytest_hricdv.monitor.patterns.contact_limits import contact_limits, contact_limits_template
from pytest_hricdv.monitor.patterns.pattern import PatternError
from pytest_hricdv.monitor.patterns.temporal import absence, existence, precedence, response, universality

__all__ = [
    "PATTERNS",
    "PatternError",
    "absence",
    "contact_limits",
    "contact_limits_template",
    "contact_pressure",
    "existence",
    "hand_guiding",
    "power_and_force",
    "precedence",
    "protective_separation",
    "protective_stop",
    "response",
    "speed_and_separation",
    "universality",
]

PATTERNS: Mapping[str, Callable[..., Formula]] = {
    function.__name__: function
    for function in (
        response,
        precedence,
        absence,
        universality,
        existence,
        speed_and_separation,
        protective_separation,
        power_and_force,
        contact_pressure,
        protective_stop,
        hand_guiding,
    )
}
"""All patterns, by name."""

SOURCE_NEEDED = frozenset({"power_and_force", "contact_pressure"})
"""Patterns with limits that a requirement file may have only with a `source`."""
