"""The text of a failing test for readers who do not know this tool (`failure`), and the commands that rerun a test.

`TestRunner` gives the text to pytest; the terminal, the markdown and the page of a report show the commands.
"""

import shlex
from collections.abc import Iterator, Mapping, Sequence

from pytest_hricdv._base.message import list_names, visible
from pytest_hricdv.generate.actors import actors_of
from pytest_hricdv.monitor import NearMiss, RequirementResult
from pytest_hricdv.report.formatting import by_requirement, enumerate_names, plural, quantity, seconds, split_first
from pytest_hricdv.report.run_lines import (
    BRIEF_ACTIONS,
    MAX_ACTIONS,
    LogLine,
    actions_around,
    list_actions,
    logs_around,
)
from pytest_hricdv.report.violations import (
    first_violation,
    headline,
    margin_text,
    order_failures,
    unit_of,
    violation_line,
)
from pytest_hricdv.results.model import ReplayComparison, Report, RequirementText, TestResult

_OF_A_REPLAY = ("--hri-replay-force", "--hri-known", "--hri-strict", "--hri-fidelity", "--hri-engine")
_PLAIN_IN_DOUBLE_QUOTES = set("[]/.:-_ ()=,+@%#~{}&;<>|*?'")


def failure(
    test: TestResult,
    requirements: Mapping[str, RequirementText],
    *,
    seed: int | None,
    suite: str | None = None,
    known_violations: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rerun_options: Sequence[str] = (),
    file: str | None = None,
    logged: Sequence[LogLine] = (),
    brief: bool = False,
) -> str:
    """Why a test failed: requirements with times, values and margins; faults; what the human did; how to run it again.

    Its first line stands alone: services and editors show no more of it.

    Args:
        test: its result; `outcome` and `wall_s` are not read, as they are not known yet when a test fails.
        requirements: name -> texts.
        seed: the suite's seed, for the command that runs the test again; None for a custom test function.
        suite: what `--hri-suite` was given, for the same; None for the suite's name, empty in a replay.
        known_violations: name -> reason; they are listed last and do not count as the cause, unless they are
            outside of the condition under which they are known.
        units: signal -> unit.
        rerun_options: further options for the command that runs the test again.
        file: the test's replay file, if it has one.
        logged: what was logged in the run.
        brief: whether to leave out formulas, and what unchecked requirements lack.

    Returns:
        Several lines without a last end of line; control characters of names are shown as escapes.
    """
    reasons = known_violations or {}
    failed = order_failures(test, reasons)
    first = headline(test, requirements, units or {}, reasons)
    lines: list[str] = [first, ""] if first else []
    for name in failed:
        texts = requirements.get(name)
        about = _requirement(name, test.requirements[name], texts, reasons.get(name), units or {}, brief=brief)
        lines += [*about, ""]
    if test.errors:
        lines += [*test.errors, ""]
    if test.failure:
        lines += [*test.failure.strip("\n").splitlines(), ""]
    lines += [*(_others_counted(test, failed) if brief else _other_requirements(test, failed)), *_course(test), ""]
    violation = first_violation(test.requirements[failed[0]]) if failed else None
    at_s = violation.time_s if violation else None
    most = BRIEF_ACTIONS if brief else MAX_ACTIONS
    event = "" if at_s is None else f"{failed[0]} is violated"
    story = _actions(test, test.sim_s if at_s is None else at_s, event, most)
    lines += [*story, "", *_log_around(logged, test.sim_s if at_s is None else at_s)]
    lines += instructions(test, suite, seed, rerun_options, file)
    return "\n".join(visible(line) for line in lines)


def describe_abort(
    test: TestResult,
    place: str,
    *,
    seed: int,
    suite: str | None = None,
    rerun_options: Sequence[str] = (),
    file: str | None = None,
    logged: Sequence[LogLine] = (),
) -> str:
    """The text of a test that an exception ended: where it was, what the human did, how to run it again.

    Args:
        test: as for `failure`.
        place: where it was when it ended, in a line.
        seed: the suite's seed, for the command that runs the test again; `suite`, `rerun_options` and `file` as for
            `failure`, as `logged`.
    """
    again = instructions(test, suite, seed, rerun_options, file)
    last_s = max((line.time_s for line in logged), default=0.0)
    lines = [f"{place}; nothing was checked", "", *_actions(test), "", *_log_around(logged, last_s), *again]
    return "\n".join(visible(line) for line in lines)


def course(test: TestResult) -> str:
    """The course of a run, whether it failed or not: verdicts, outcomes, and the human's actions."""
    lines = [f"{name} {test.requirements[name].verdict} ({counts(test.requirements[name])})" for name in _names(test)]
    return "\n".join(visible(line) for line in [*lines, *_course(test), "", *_actions(test)])


def counts(result: RequirementResult) -> str:
    """How often a requirement was checked: `2 triggers: 1 passed, 1 failed`."""
    kinds = (
        (result.passes, "passed"),
        (result.failures, "failed"),
        (result.untriggered, "vacuous"),
        (result.pending, "pending at the end"),
    )
    text = ", ".join(f"{count} {word}" for count, word in kinds if count)
    triggers = plural(result.triggers, "trigger")
    return f"{triggers}: {text}" if text else triggers


def near_miss(miss: NearMiss) -> str:
    """Why nothing was checked, in a line: `nearest at 41.2 s: only reading.pressure was missing`."""
    shown = list_names(miss.missing, 6)
    text = f"only {shown} was missing" if len(miss.missing) == 1 else f"{shown} were missing"
    distance = f", by {quantity(miss.distance)}" if miss.distance is not None else ""
    return f"nearest at {seconds(miss.time_s)}: {text}{distance}"


def generate_command(nodeid: str, suite: str, seed: int, options: Sequence[str] = ()) -> str:
    """The command that generates a test again: `pytest "tests/..[rl-leg1-3fa2b1c0]" --hri-suite=rl --hri-seed=0`.

    Args:
        nodeid: the test's node id.
        suite: what `--hri-suite` is given to have the test generated.
        seed: the suite's seed, not the test's own.
        options: further options that the run was given and that decide which tests exist or what fails.
    """
    words = [f"--hri-suite={suite}", f"--hri-seed={seed}", *options]
    return " ".join(["pytest", _quote(nodeid), *map(_option, words)])


def replay_command(file: str, options: Sequence[str] = ()) -> str:
    """The command that replays a file: `pytest --hri-replay=hri-report/failures/rl-leg1-3fa2b1c0.json`.

    Args:
        file: the replay file.
        options: as for `generate_command`; only those that decide how it runs and what fails are used.
    """
    words = [f"--hri-replay={file}", *(option for option in options if option.startswith(_OF_A_REPLAY))]
    return " ".join(["pytest", *map(_option, words)])


def instructions(
    test: TestResult, suite: str | None, seed: int | None, options: Sequence[str] = (), file: str | None = None
) -> list[str]:
    """How to run a test again: commands, each below a line that says what it does.

    Args:
        test: a test of the report.
        suite: as for `generate_command`; empty for a test from a replay file, None for the test's own suite.
        seed: as for `generate_command`; None for a custom test function, which belongs to no suite.
        options: as for `generate_command`.
        file: the test's replay file, if it has one.
    """
    if seed is None:
        return ["run it again:", f"  pytest {_quote(test.nodeid)}"]
    if file and suite == "":
        return ["run it again:", f"  {replay_command(file, options)}"]
    lines = ["run it again:", f"  {generate_command(test.nodeid, suite or test.suite, seed, options)}"]
    return [*lines, "or the very same run, from its file:", f"  {replay_command(file, options)}"] if file else lines


def describe_replay(replayed: ReplayComparison) -> tuple[str, str]:
    """How the run of a replayed test compares with the recorded one, and a hint at the cause, which may be empty."""
    if replayed.same:
        return "the same run, bit for bit", ""
    changes = f": {', '.join(replayed.changed)}" if replayed.changed else "; cause unknown: --hri-audit looks for it"
    hint = f"it may be Python's hash seed, which was {replayed.hash_seed}" if replayed.hash_seed else ""
    return f"differs from the recording{changes}", hint


def instructions_of(report: Report, test: TestResult) -> list[str]:
    """How to run a test of a report again, with the options of the report's run."""
    seeds = {suite.name: suite.seed for suite in report.suites}
    return instructions(
        test, report.rerun_options.suite, seeds.get(test.suite, 0), report.rerun_options.options, test.replay
    )


def _requirement(
    name: str,
    result: RequirementResult,
    texts: RequirementText | None,
    known_as: str | None,
    units: Mapping[str, str],
    *,
    brief: bool,
) -> Iterator[str]:
    yield f"{name} Failed: {_one_line(texts.title)}" if texts and texts.title else f"{name} Failed"
    if known_as is not None and result.outside:
        yield f"  known only {_one_line(known_as)}"
    elif known_as is not None:
        yield f"  a known violation{f' ({_one_line(known_as)})' if known_as else ''}, which does not fail the run"
    if texts and texts.text and not brief:
        yield f"  checked as  {_one_line(texts.text)}"
    if texts and texts.source and not brief:
        yield f"  source      {_one_line(texts.source)}"
    unit = unit_of(texts.text, units) if texts else ""
    outside_first = sorted(result.violations, key=lambda violation: (not violation.outside, violation.time_s))
    shown, more = split_first(outside_first, 3)
    for violation in shown:
        yield f"  {violation_line(violation, units, unit)}"
    if more:
        yield f"  and {plural(more, 'more violation')}"
    if not brief or len(result.violations) > 1:  # of one, all is said
        yield f"  {counts(result)}{_worst_margin(result, unit)}"


def _one_line(text: str) -> str:
    """A text that its author broke into lines."""
    return " ".join(line.strip() for line in text.strip().splitlines())


def _worst_margin(result: RequirementResult, unit: str) -> str:
    if result.margin is None:
        return ""
    when = f" at {seconds(result.margin_time_s)}" if isinstance(result.margin_time_s, int | float) else ""
    return f"; worst margin {margin_text(result.margin, unit)}{when}"


def _other_requirements(test: TestResult, failed: Sequence[str]) -> Iterator[str]:
    others = {name: test.requirements[name] for name in _names(test) if name not in failed}
    if others:
        text = ", ".join(f"{name} {result.verdict}" for name, result in others.items())
        unchecked = any(result.verdict == "NC" for result in others.values())
        yield f"others:  {text}{' (NC: not checked, nothing triggered it)' if unchecked else ''}"
    for name, result in others.items():
        if result.near_miss:
            yield f"         {name} {near_miss(result.near_miss)}"


def _others_counted(test: TestResult, failed: Sequence[str]) -> Iterator[str]:
    words = {"Passed": "passed", "Failed": "failed", "NC": "not checked"}
    others = [
        "pending at the end" if result.verdict == "NC" and result.pending else words[result.verdict]
        for name, result in test.requirements.items()
        if name not in failed
    ]
    order = (*words.values(), "pending at the end")
    counted = [f"{others.count(word)} {word}" for word in order if word in others]
    if counted:
        yield f"others:  {', '.join(counted)}"


def _course(test: TestResult) -> Iterator[str]:
    if test.outcomes:
        yield f"outcome: {', '.join(test.outcomes)}"
    ended = f": {test.end_reason}" if test.end_reason else ""
    yield f"ended:   after {seconds(test.sim_s)} simulated{ended}"


def _actions(test: TestResult, at_s: float | None = None, event: str = "", most: int = MAX_ACTIONS) -> Iterator[str]:
    """The human's actions, to the end or around the instant (s) of an event."""
    name = f"abstract test {test.id}, own seed {test.seed}"
    who = enumerate_names(
        [*(actors_of(test.abstract) or ["the human"]), *actors_of(act for _, act in test.bystander_events)]
    )
    if test.action_times_s and at_s is not None:
        numbers = [number for _, number in test.action_starts]
        left = [number for number in range(len(test.abstract)) if number not in numbers]
        begun = [(time_s, test.abstract[number]) for time_s, number in test.action_starts]
        begun = sorted([*begun, *test.bystander_events], key=lambda entry: entry[0])
        actions = [*(action for _, action in begun), *(test.abstract[number] for number in left)]
        return actions_around(actions, [time_s for time_s, _ in begun], at_s, name, event, who, most)
    return list_actions(test.abstract, name, who)


def _log_around(logged: Sequence[LogLine], at_s: float) -> list[str]:
    """The log around an instant (s), after an empty line; nothing if there is none."""
    lines = [*logs_around(logged, at_s)]
    return [*lines, ""] if lines else []


def _names(test: TestResult) -> list[str]:
    return sorted(test.requirements, key=by_requirement)


def _quote(nodeid: str) -> str:
    if nodeid.startswith("-"):  # pytest would take it for an option, and --basetemp=DIR empties a folder
        nodeid = f"./{nodeid}"
    # Some shells require quotes around brackets. Every shell understands double quotes, so these are used unless a
    # character of the name has a meaning inside of them.
    if all(char.isalnum() or char in _PLAIN_IN_DOUBLE_QUOTES for char in nodeid):
        return f'"{nodeid}"'
    return shlex.quote(nodeid)


def _option(text: str) -> str:
    return text if all(char.isalnum() or char in "-_=/.,:" for char in text) else shlex.quote(text)
