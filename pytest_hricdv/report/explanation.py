"""The text of a failing test, for readers who do not know this tool."""

from collections.abc import Iterator, Mapping, Sequence

from pytest_hricdv.coverage.records import ReportedNearMiss, ReportedViolation, RequirementResult
from pytest_hricdv.report.formatting import natural, plural, quantity, seconds, visible
from pytest_hricdv.report.rerun import instructions
from pytest_hricdv.results.model import RequirementText, TestResult

_MAX_VIOLATIONS = 3
_MAX_ACTIONS = 14
_MAX_MISSING = 6


def failure(
    test: TestResult,
    requirements: Mapping[str, RequirementText],
    *,
    seed: int | None,
    suite: str | None = None,
    known: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    more: Sequence[str] = (),
    file: str | None = None,
) -> str:
    """Why a test failed: requirement, times, values, margin; what happened; what the human did; how to run it again.

    Args:
        test: its result; `outcome` and `wall_s` are not read, as they are not known yet when a test fails.
        requirements: name -> texts.
        seed: the suite's seed, for the command that runs the test again; None for a custom test function.
        suite: what `--hri-suite` was given, for the same; None for the suite's name, empty in a replay.
        known: known violations, name -> reason; they are listed last and do not count as the cause.
        units: signal -> unit.
        more: further options for the command that runs the test again.
        file: the test's replay file, if it has one.

    Returns:
        Several lines without a last end of line; control characters of names are shown as escapes.
    """
    reasons = known or {}
    failed = [name for name in _names(test) if test.requirements[name].verdict == "Failed"]
    failed.sort(key=lambda name: name in reasons)
    lines: list[str] = []
    for name in failed:
        texts = requirements.get(name)
        lines += [*_requirement(name, test.requirements[name], texts, reasons.get(name), units or {}), ""]
    if test.failure:
        lines += [*test.failure.strip("\n").splitlines(), ""]
    lines += [*_other_requirements(test, failed), *_course(test), ""]
    lines += [*_actions(test, _first_violation_s(test, failed[:1])), ""]
    lines += instructions(test, suite, seed, more, file)
    return "\n".join(visible(line) for line in lines)


def aborted(
    test: TestResult,
    what: str,
    *,
    seed: int,
    suite: str | None = None,
    more: Sequence[str] = (),
    file: str | None = None,
) -> str:
    """The text of a test that an exception ended: where it was, what the human did, how to run it again.

    Args:
        test: as for `failure`.
        what: where it was when it ended, in a line.
        seed: the suite's seed, for the command that runs the test again; `suite`, `more` and `file` as for `failure`.
    """
    lines = [f"{what}; nothing was checked", "", *_actions(test), "", *instructions(test, suite, seed, more, file)]
    return "\n".join(visible(line) for line in lines)


def course(test: TestResult) -> str:
    """What happened in a run, whether it failed or not: verdicts, turns, and what the human did."""
    lines = [f"{name} {test.requirements[name].verdict} ({counts(test.requirements[name])})" for name in _names(test)]
    return "\n".join(visible(line) for line in [*lines, *_course(test), "", *_actions(test)])


def violation(found: ReportedViolation, units: Mapping[str, str]) -> str:
    """One violation in a line: `triggered at 41.2 s, violated at 51.2 s: hand_distance = 0.03 m (margin -0.02)`.

    Args:
        found: a violation of the report.
        units: signal -> unit, as far as known.
    """
    parts = []
    if found.trigger_s is not None:
        parts.append(f"triggered at {seconds(found.trigger_s)}")
    if found.time_s is not None:
        parts.append(f"violated at {seconds(found.time_s)}")
    text = ", ".join(parts) or "violated"
    if found.values:
        names = sorted(found.values, key=natural)
        text += ": " + ", ".join(
            f"{name} = {quantity(found.values[name])} {units.get(name, '')}".rstrip() for name in names
        )
    if found.margin is not None:
        text += f" (margin {quantity(found.margin)})"
    return text


def counts(result: RequirementResult) -> str:
    """How often a requirement was checked: `2 triggers: 1 passed, 1 failed`."""
    kinds = (
        (result.passes, "passed"),
        (result.failures, "failed"),
        (result.vacuous, "vacuous"),
        (result.pending, "pending at the end"),
    )
    text = ", ".join(f"{count} {word}" for count, word in kinds if count)
    triggers = plural(result.triggers, "trigger")
    return f"{triggers}: {text}" if text else triggers


def nearest_miss(found: ReportedNearMiss) -> str:
    """Why nothing was checked, in a line: `nearest at 41.2 s: only reading.pressure was missing`."""
    shown = ", ".join(found.missing[:_MAX_MISSING])
    if len(found.missing) > _MAX_MISSING:
        shown += f" and {len(found.missing) - _MAX_MISSING} more"
    text = f"only {shown} was missing" if len(found.missing) == 1 else f"{shown} were missing"
    distance = f", by {quantity(found.distance)}" if found.distance is not None else ""
    return f"nearest at {seconds(found.time_s)}: {text}{distance}"


def _requirement(
    name: str,
    result: RequirementResult,
    texts: RequirementText | None,
    known: str | None,
    units: Mapping[str, str],
) -> Iterator[str]:
    yield f"{name} Failed: {texts.title}" if texts and texts.title else f"{name} Failed"
    if known is not None:
        yield f"  a known violation{f' ({known})' if known else ''}: it does not fail the run"
    if texts and texts.text:
        yield f"  checked as  {texts.text}"
    if texts and texts.source:
        yield f"  source      {texts.source}"
    for found in result.violations[:_MAX_VIOLATIONS]:
        yield f"  {violation(found, units)}"
    if len(result.violations) > _MAX_VIOLATIONS:
        yield f"  and {plural(len(result.violations) - _MAX_VIOLATIONS, 'more violation')}"
    yield f"  {counts(result)}{_worst_margin(result)}"


def _worst_margin(result: RequirementResult) -> str:
    if result.margin is None:
        return ""
    when = f" at {seconds(result.margin_time_s)}" if isinstance(result.margin_time_s, int | float) else ""
    return f"; worst margin {quantity(result.margin)}{when}"


def _other_requirements(test: TestResult, failed: Sequence[str]) -> Iterator[str]:
    others = {name: test.requirements[name] for name in _names(test) if name not in failed}
    if others:
        text = ", ".join(f"{name} {result.verdict}" for name, result in others.items())
        unchecked = any(result.verdict == "NC" for result in others.values())
        yield f"others:  {text}{' (NC: not checked, nothing triggered it)' if unchecked else ''}"
    for name, result in others.items():
        if result.nearest_miss:
            yield f"         {name} {nearest_miss(result.nearest_miss)}"


def _course(test: TestResult) -> Iterator[str]:
    if test.outcomes:
        yield f"turns:   {', '.join(test.outcomes)}"
    ended = f": {test.ended}" if test.ended else ""
    yield f"ended:   after {seconds(test.sim_s)} simulated{ended}"


def _first_violation_s(test: TestResult, requirements: Sequence[str]) -> float | None:
    """When the first violation of these requirements was."""
    violations = [each for name in requirements for each in test.requirements[name].violations]
    return min((each.time_s for each in violations if each.time_s is not None), default=None)


def _actions(test: TestResult, until_s: float | None = None) -> Iterator[str]:
    """What the human did, to the end or up to a time (s), with the times where they are known."""
    name = f"abstract test {test.id}, own seed {test.seed}"
    if test.acted_s and until_s is not None:
        yield from _actions_before(test.abstract, test.acted_s, until_s, name)
        return
    yield f"what the human did ({name}):"
    actions = test.abstract
    shown = actions if len(actions) <= _MAX_ACTIONS else actions[: _MAX_ACTIONS - 1]
    for action in shown:
        yield f"  {action}"
    if len(shown) < len(actions):
        yield f"  ... and {plural(len(actions) - len(shown), 'more action')}"
    if not actions:
        yield "  nothing"


def _actions_before(actions: Sequence[str], times: Sequence[float], until_s: float, name: str) -> Iterator[str]:
    """The last actions that began before a time: the ones that led to what happened then."""
    begun = [(at, action) for at, action in zip(times, actions, strict=False) if at <= until_s]
    yield f"what the human did until then ({name}):"
    shown = begun if len(begun) <= _MAX_ACTIONS else begun[1 - _MAX_ACTIONS :]
    if len(shown) < len(begun):
        yield f"  {plural(len(begun) - len(shown), 'action')} before, and"
    for at, action in shown:
        yield f"  {at:8.1f} s  {action}"
    if not begun:
        yield "  nothing"
    if len(begun) < len(actions):
        yield f"  and {plural(len(actions) - len(begun), 'more action')} later"


def _names(test: TestResult) -> list[str]:
    return sorted(test.requirements, key=natural)
