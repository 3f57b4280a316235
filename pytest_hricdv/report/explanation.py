"""The text of a failing test, for somebody who has never seen this tool."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pytest_hricdv.report.figure import natural, plural, quantity, seconds
from pytest_hricdv.report.line import visible
from pytest_hricdv.report.rerun import told

_MAX_VIOLATIONS = 3
_MAX_ACTIONS = 14
_MAX_MISSING = 6


def failure(
    test: Mapping[str, Any],
    requirements: Mapping[str, Any],
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
        test: a test of the report; `outcome` and `wall_s` are not read, as they are not known yet when a test fails.
        requirements: the report's `requirements`: name to `title`, `source`, `text`.
        seed: the suite's seed, for the line that runs the test again; None for a test that no suite has.
        suite: what `--hri-suite` was given, for the same; the suite's name where not said, empty in a replay.
        known: violations that are known, name to reason; they are told last and do not count as the cause.
        units: of signals, name to unit.
        more: further options for the line that runs the test again.
        file: the test's replay file, where there is one.

    Returns:
        Several lines without a last end of line; control characters of names appear as escapes.
    """
    reasons = known or {}
    failed = [name for name in _named(test) if _verdict(test, name)["verdict"] == "Failed"]
    failed.sort(key=lambda name: name in reasons)
    lines: list[str] = []
    for name in failed:
        lines += [*_requirement(name, test, requirements.get(name, {}), reasons.get(name), units or {}), ""]
    if test.get("failure"):
        lines += [*str(test["failure"]).strip("\n").splitlines(), ""]
    lines += [*_rest(test, failed), *_course(test), "", *_actions(test, _first_violation_s(test, failed[:1])), ""]
    lines += told(test, suite, seed, more, file)
    return "\n".join(visible(line) for line in lines)


def aborted(
    test: Mapping[str, Any],
    what: str,
    *,
    seed: int,
    suite: str | None = None,
    more: Sequence[str] = (),
    file: str | None = None,
) -> str:
    """What to say of a test that an exception ended: where it was, what the human did, how to run it again.

    Args:
        test: as for `failure`.
        what: where it was when it ended, in a line.
        seed: the suite's seed, for the line that runs the test again; `suite`, `more` and `file` as for `failure`.
    """
    lines = [f"{what}; nothing was checked", "", *_actions(test), "", *told(test, suite, seed, more, file)]
    return "\n".join(visible(line) for line in lines)


def course(test: Mapping[str, Any]) -> str:
    """What happened in a run, whatever is wrong with it: verdicts, turns, and what the human did."""
    lines = [f"{name} {_verdict(test, name)['verdict']} ({counts(_verdict(test, name))})" for name in _named(test)]
    return "\n".join(visible(line) for line in [*lines, *_course(test), "", *_actions(test)])


def violation(found: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """One violation in a line: `triggered at 41.2 s, violated at 51.2 s: hand_distance = 0.03 m (margin -0.02)`.

    Args:
        found: a violation of the report.
        units: of signals, name to unit, so far as they are known.
    """
    parts = []
    if found.get("trigger_s") is not None:
        parts.append(f"triggered at {seconds(found['trigger_s'])}")
    if found.get("time_s") is not None:
        parts.append(f"violated at {seconds(found['time_s'])}")
    text = ", ".join(parts) or "violated"
    values = found.get("values") or {}
    if values:
        told = (f"{name} = {quantity(values[name])} {units.get(name, '')}" for name in sorted(values, key=natural))
        text += ": " + ", ".join(map(str.rstrip, told))
    if found.get("margin") is not None:
        text += f" (margin {quantity(found['margin'])})"
    return text


def counts(verdict: Mapping[str, Any]) -> str:
    """How often a requirement was put to the test: `2 triggers: 1 passed, 1 failed`."""
    kinds = (("passes", "passed"), ("failures", "failed"), ("vacuous", "vacuous"), ("pending", "still open at the end"))
    told = ", ".join(f"{verdict[key]} {word}" for key, word in kinds if verdict.get(key))
    triggers = plural(verdict["triggers"], "trigger")
    return f"{triggers}: {told}" if told else triggers


def nearest_miss(found: Mapping[str, Any]) -> str:
    """Why nothing was checked, in a line: `nearest at 41.2 s: only reading.pressure was missing`."""
    missing: Sequence[str] = found["missing"]
    shown = ", ".join(missing[:_MAX_MISSING])
    if len(missing) > _MAX_MISSING:
        shown += f" and {len(missing) - _MAX_MISSING} more"
    only = "only " if len(missing) == 1 else ""
    verb = "was" if len(missing) == 1 else "were"
    distance = f", by {quantity(found['distance'])}" if found["distance"] is not None else ""
    return f"nearest at {seconds(found['time_s'])}: {only}{shown} {verb} missing{distance}"


def _requirement(
    name: str, test: Mapping[str, Any], described: Mapping[str, Any], known: str | None, units: Mapping[str, str]
) -> Iterator[str]:
    verdict = _verdict(test, name)
    title = f": {described['title']}" if described.get("title") else ""
    yield f"{name} Failed{title}"
    if known is not None:
        yield f"  a known violation{f' ({known})' if known else ''}: it does not fail the run"
    if described.get("text"):
        yield f"  checked as  {described['text']}"
    if described.get("source"):
        yield f"  source      {described['source']}"
    shown: Sequence[Mapping[str, Any]] = verdict["violations"][:_MAX_VIOLATIONS]
    for found in shown:
        yield f"  {violation(found, units)}"
    if len(verdict["violations"]) > len(shown):
        yield f"  and {plural(len(verdict['violations']) - len(shown), 'more violation')}"
    yield f"  {counts(verdict)}{_worst(verdict)}"


def _worst(verdict: Mapping[str, Any]) -> str:
    if verdict["margin"] is None:
        return ""
    when = f" at {seconds(verdict['margin_time_s'])}" if verdict.get("margin_time_s") is not None else ""
    return f"; worst margin {quantity(verdict['margin'])}{when}"


def _rest(test: Mapping[str, Any], failed: Sequence[str]) -> Iterator[str]:
    others = [name for name in _named(test) if name not in failed]
    if others:
        told = (f"{name} {_verdict(test, name)['verdict']}" for name in others)
        note = " (NC: not checked, nothing triggered it)" if _any_unchecked(test) else ""
        yield f"others:  {', '.join(told)}{note}"
    for name in others:
        if _verdict(test, name).get("nearest_miss"):
            yield f"         {name} {nearest_miss(_verdict(test, name)['nearest_miss'])}"


def _course(test: Mapping[str, Any]) -> Iterator[str]:
    if test["legs"]:
        yield f"turns:   {', '.join(test['legs'])}"
    if test["sim_s"] is not None:
        ended = f": {test['ended']}" if test.get("ended") else ""
        yield f"ended:   after {seconds(test['sim_s'])} simulated{ended}"


def _first_violation_s(test: Mapping[str, Any], requirements: Sequence[str]) -> float | None:
    """When the first violation was, of these requirements."""
    violations = [each for name in requirements for each in _verdict(test, name)["violations"]]
    times = [each["time_s"] for each in violations if each.get("time_s") is not None]
    return min(times, default=None)


def _actions(test: Mapping[str, Any], until_s: float | None = None) -> Iterator[str]:
    """What the human did, to the end or up to a time (s), with the times where they are known."""
    own = f", own seed {test['seed']}" if test["seed"] is not None else ""
    times: Sequence[float] = test.get("acted_s") or ()
    if times and until_s is not None:
        yield from _actions_before(test["abstract"], times, until_s, f"abstract test {test['id']}{own}")
        return
    yield f"what the human did (abstract test {test['id']}{own}):"
    actions: Sequence[str] = test["abstract"]
    shown = actions if len(actions) <= _MAX_ACTIONS else actions[: _MAX_ACTIONS - 1]
    for action in shown:
        yield f"  {action}"
    if len(shown) < len(actions):
        yield f"  ... and {plural(len(actions) - len(shown), 'more action')}"
    if not actions:
        yield "  nothing"


def _actions_before(actions: Sequence[str], times: Sequence[float], until_s: float, of: str) -> Iterator[str]:
    """The last actions that began before a time: those are the ones that led to what happened then."""
    begun = [(at, action) for at, action in zip(times, actions, strict=False) if at <= until_s]
    yield f"what the human did until then ({of}):"
    shown = begun if len(begun) <= _MAX_ACTIONS else begun[1 - _MAX_ACTIONS :]
    if len(shown) < len(begun):
        yield f"  {plural(len(begun) - len(shown), 'action')} before, and"
    for at, action in shown:
        yield f"  {at:8.1f} s  {action}"
    if not begun:
        yield "  nothing"
    if len(begun) < len(actions):
        yield f"  and {plural(len(actions) - len(begun), 'more action')} later"


def _named(test: Mapping[str, Any]) -> list[str]:
    return sorted(test["requirements"], key=natural)


def _verdict(test: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found: Mapping[str, Any] = test["requirements"][name]
    return found


def _any_unchecked(test: Mapping[str, Any]) -> bool:
    return any(verdict["verdict"] == "NC" for verdict in test["requirements"].values())
