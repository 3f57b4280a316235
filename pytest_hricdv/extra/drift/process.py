"""The process of `init --update`: it configures pytest, so that the testbench is that of a session, and compares."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.drift.command import RECORDING
from pytest_hricdv.extra.drift.feature import FEATURE
from pytest_hricdv.extra.drift.looking import looked
from pytest_hricdv.extra.drift.proposal import difference, proposed
from pytest_hricdv.extra.drift.recorded import refined, seen_in, text_drifts
from pytest_hricdv.extra.recordings.observed import Observed
from pytest_hricdv.hooks import HOOK
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.serving import UNWARNED, in_session

SUITE = "pseudorandom"
"""Nothing is generated, but a session needs a suite, and this one needs nothing of a testbench."""


def compare(context: RunContext, *, write: bool, say: Callable[[str], None], recordings: Sequence[Path] = ()) -> int:
    """Tell the drift, and the change of the conftest file; returns the exit status: 1 where there is drift."""
    tests, of_tests = _tests(context)
    drift_seen = looked(context, tests, FEATURE.settings(context.options).known)
    for text in (of_tests, *drift_seen.problems, *drift_seen.outdated):
        if text:
            say(text)
    recorded = _recorded(context, recordings, say)
    if recorded is not None:
        known = FEATURE.settings(context.options).known
        texts = text_drifts(recorded, context.collection.testbench)
        drift_seen.new.extend(drift for drift in texts if drift.key not in known)
    for drift in drift_seen.new:
        say(f"{drift.place or 'conftest.py'}: {drift.text}  [{drift.key}]")
    if drift_seen.known:
        say(f"known: {', '.join(drift.key for drift in drift_seen.known)}")
    path = _conftest(context)
    before = path.read_text(encoding="utf-8")
    ranges = [] if recorded is None else refined(before, recorded)[1]
    for text in ranges:
        say(text)
    if not drift_seen.new and not ranges:
        has = "what the code has" if recorded is None else "what the code and the recording have"
        say(f"no drift: testbench and tests have {has}")
        return 0
    after = before if recorded is None else refined(before, recorded)[0]  # its lines stay where they are
    _propose(context, (path, before, proposed(after, drift_seen.new)), write=write, say=say)
    return 1


def _recorded(context: RunContext, recordings: Sequence[Path], say: Callable[[str], None]) -> Observed | None:
    if not recordings:
        return None
    seen = seen_in(recordings, context.collection.testbench)
    for text in seen.told:
        say(text)
    return seen.observed


def _conftest(context: RunContext) -> Path:
    hook = getattr(context.collection.config.hook, HOOK)
    return Path(hook.get_hookimpls()[-1].function.__code__.co_filename)


def _propose(context: RunContext, change: tuple[Path, str, str], *, write: bool, say: Callable[[str], None]) -> None:
    """Show a change of a file, its text before and after; or write it."""
    path, before, after = change
    say("")
    if after == before:
        say("nothing of it is a line of conftest.py: plans and disturbances lead to states; what may be so goes to")
        say("hri_known_drift in the ini file, one a line: KIND NAME: reason")
    elif write:
        write_text(path, after)
        say(f"{path}: changed; review it, above all the ranges")
    else:
        name = os.path.relpath(path, context.collection.config.invocation_params.dir)
        for line in difference(before, after, name).splitlines():
            say(line)
        say("")
        say("nothing was written: the same with --write changes the file")


def _tests(context: RunContext) -> tuple[tuple[TestResult, ...] | None, str]:
    """The tests of the last report, and what is to be said where there are none."""
    folder = context.options.report
    try:
        report = load(folder)
    except ReportError:
        return None, f"no report in {folder}: run pytest first, and states that no plan leads to are told, too"
    return report.tests, ""


def main() -> None:
    """Compare; arguments are `--write` or nothing, and then those of pytest."""
    write, rest = sys.argv[1] == "write", sys.argv[2:]
    recordings = [Path(word.removeprefix(RECORDING)) for word in rest if word.startswith(RECORDING)]
    arguments = [word for word in rest if not word.startswith(RECORDING)]

    def say(text: str) -> None:
        with suppress(BrokenPipeError):  # of whoever read it: the status says the same
            print(visible(text), flush=True)

    def work(context: RunContext) -> None:
        status = compare(context, write=write, say=say, recordings=recordings)
        with suppress(BrokenPipeError):
            sys.stdout.flush()
        os._exit(status)

    sys.exit(in_session((f"--hri-suite={SUITE}", *arguments, *UNWARNED), work) or 2)


if __name__ == "__main__":
    main()
