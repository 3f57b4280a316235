"""Violations and margins in words, with units and times, for all views: `headline`, `violation_line`, `margin_text`."""

from __future__ import annotations

import re
from collections.abc import Container, Mapping

from pytest_hricdv.monitor import RequirementResult, Violation
from pytest_hricdv.report.formatting import by_requirement, natural, quantity, seconds
from pytest_hricdv.results.model import Report, RequirementText, TestResult

NO_TEXT = RequirementText(title="", source="", text="")
"""Stands for the text of a requirement that the report lacks."""

_SAME_S = 0.0005
"""Times closer than this (s) count as equal, since reports give times in milliseconds."""


def order_failures(test: TestResult, known_violations: Container[str] = ()) -> list[str]:
    """The requirements that a test violated: what fails it first, then by the time of the violation.

    Args:
        known_violations: requirements whose violation does not fail it, unless it is outside of their condition.
    """
    failed = [name for name, result in test.requirements.items() if result.verdict == "Failed"]
    return sorted(
        failed, key=lambda name: (is_known(name, test, known_violations), _first_s(test, name), by_requirement(name))
    )


def is_known(name: str, test: TestResult, known_violations: Container[str]) -> bool:
    """Whether a test's violations of a requirement are all known."""
    return name in known_violations and not test.requirements[name].outside


def headline(
    test: TestResult,
    requirements: Mapping[str, RequirementText],
    units: Mapping[str, str],
    known_violations: Container[str] = (),
) -> str:
    """The failure in a line that stands alone: `R29 failed at 162.9 s by 0.128 m, then R21`; empty without one."""
    failed = order_failures(test, known_violations)
    if not failed:
        return ""
    first, *others = failed
    result = test.requirements[first]
    texts = requirements.get(first)
    text = f"{first} failed"
    if (violation := first_violation(result)) is not None:
        text += f" at {seconds(violation.time_s)}{_by(violation, unit_of(texts.text, units) if texts else '')}"
    text += " (known)" if is_known(first, test, known_violations) else ""
    new = [name for name in others if not is_known(name, test, known_violations)]
    return f"{text}, then {', '.join(new)}" if new else text


def first_violation(result: RequirementResult) -> Violation | None:
    """The first that is not known; of known ones the first. None where nothing says when it was."""
    return min(result.violations, key=lambda violation: (not violation.outside, violation.time_s), default=None)


def violation_line(violation: Violation, units: Mapping[str, str], unit: str = "") -> str:
    """One violation in a line: `triggered at 41.2 s, violated at 51.2 s: hand_distance = 0.03 m (margin -0.02 m)`.

    Args:
        units: signal -> unit, as far as known.
        unit: the unit of the margin.
    """
    text = f"triggered at {seconds(violation.trigger_s)}, violated at {seconds(violation.time_s)}"
    if violation.values:
        text += ": " + ", ".join(_value(name, violation, units) for name in sorted(violation.values, key=natural))
    if violation.text:
        text += f": {violation.text}"
    if violation.margin is not None:
        text += f" (margin {margin_text(violation.margin, unit)}{_later(violation, violation.margin_s)})"
    return f"{text}; not known under this condition" if violation.outside else text


def describe_violation(name: str, violation: Violation, units: Mapping[str, str], unit: str = "") -> str:
    """The violation in few words, the most important first: `R3 failed at 51.2 s by 0.02 m: hand_distance = 0.03 m`."""
    text = f"{name} failed at {seconds(violation.time_s)}{_by(violation, unit)}"
    values = ", ".join(_value(signal, violation, units) for signal in sorted(violation.values, key=natural))
    said = ": ".join(filter(None, (text, values, violation.text)))
    return f"{said}; not known under this condition" if violation.outside else said


def _value(name: str, violation: Violation, units: Mapping[str, str]) -> str:
    text = f"{name} = {quantity(violation.values[name])} {units.get(name, '')}".rstrip()
    return text + _later(violation, violation.values_s.get(name))


def _later(violation: Violation, time_s: float | None) -> str:
    """The moment of a value, where it is another one than that of the violation."""
    shown = "" if time_s is None else seconds(time_s)
    return f" at {shown}" if shown and shown != seconds(violation.time_s) else ""


def _by(violation: Violation, unit: str) -> str:
    """The amount of the violation, with the moment, unless the amount tells it already, as for a missed deadline."""
    margin = violation.margin
    if margin is None or margin >= 0.0:
        return ""
    text = f" by {margin_text(-margin, unit)}"
    moment = _later(violation, violation.margin_s)
    is_lateness = violation.margin_s is not None and abs(violation.time_s - margin - violation.margin_s) < _SAME_S
    return text if not moment or is_lateness else f",{text}{moment}"


def _first_s(test: TestResult, name: str) -> float:
    violation = first_violation(test.requirements[name])
    return test.sim_s if violation is None else violation.time_s


def unit_of(formula: str, units: Mapping[str, str]) -> str:
    """The unit of a requirement's margins: seconds for a deadline, else that of the signals it compares.

    Args:
        formula: the requirement's text; where its pattern names no signal with a unit, or several units, there is none.
        units: signal or `topic.field` -> unit.
    """
    response = formula.partition("->")[2]
    if "eventually" in response:
        return "s"
    named = {units[word] for word in re.findall(r"[A-Za-z_][\w.]*", response) if word in units}
    return named.pop() if len(named) == 1 else ""


def margin_unit(report: Report, requirement: str) -> str:
    """The unit of a requirement's margins in a report; empty if that is not known."""
    return unit_of(report.requirements.get(requirement, NO_TEXT).text, report.units or {})


def margin_text(margin: float, unit: str, digits: str = "") -> str:
    """`-0.02 m`, or with a format such as ".3g"."""
    return f"{format(margin, digits) if digits else quantity(margin)} {unit}".rstrip()
