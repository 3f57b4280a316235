"""Settles a draft by first runs: parts that fail are removed and become questions, until all tests pass.

`settle` has a budget of processor time; where this does not suffice, there are fewer tests and fewer things to say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.code_model import Problem
from pytest_hricdv.extra.draft.first_runs import TOO_LONG, FirstRuns
from pytest_hricdv.extra.draft.observed_code import with_steps
from pytest_hricdv.extra.draft.project.answers import find_edits
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.settlement import (
    BUDGET_S,
    MIN_TESTS,
    Reread,
    Settlement,
    one_line,
    with_some_requirement,
    without,
)

MAX_TRIALS = 25
"""Most runs of a few tests, however little time each takes."""

OVERRUN_S = 20.0
"""Processor time beyond the budget, the least of two runs, after which everything that may fail is removed at once."""

SUITES = ("rl", "closure")

SHARE = 0.25
"""Share of the budget for each of the two suites; the rest is for the steps before them."""


def settle(
    draft: Draft, reread: Reread | None = None, budget_s: float = BUDGET_S, progress: Callable[[str], None] = print
) -> tuple[Draft, tuple[FirstRuns, ...]]:
    """The draft after its first runs, without the parts that failed, so that it passes.

    Args:
        reread: reads the code again with what was observed.
        budget_s: processor time of all runs.
        progress: called with a sentence for each step.
    """
    work = Settlement(replace(draft, allowed_endings=()), reread, budget_s, 2 * SHARE * budget_s)
    trial = _make_green(work, budget_s / 2, progress)
    work.draft = without(work.draft, trial.failed)
    trials = [trial] if trial.cause else _run_suites(work, SHARE * budget_s, progress)
    made = _without_rare(work.draft, trials)
    others = made.declared.questions if made.entry is not None or made.ros is not None else ()
    declared = replace(made.declared, questions=(*work.asked.values(), *others))
    return replace(_with_problems(replace(made, declared=declared), trials), missing=trials[-1].missing), tuple(trials)


def _make_green(work: Settlement, reserve_s: float, progress: Callable[[str], None]) -> FirstRuns:
    """Run a few tests, with what they have shown of the code, until they show no more; take out what fails then."""
    while True:
        trial = work.try_out()
        edits = ", ".join(find_edits(work.draft.earlier))
        if trial.error.startswith("ERROR") and edits:
            advice = f"correct what was changed in {edits}, or draft into another folder; nothing was written"
            raise DraftError(f"{trial.error}: {advice}")
        if work.budget_s >= reserve_s and work.look_again():
            progress("first runs: the draft has what they have shown, and runs again")
        elif not _go_on(work, trial, "first runs", progress):
            return trial


def _go_on(work: Settlement, trial: FirstRuns, name: str, progress: Callable[[str], None]) -> bool:
    """Take out what fails; returns whether anything was, so that it has to run again."""
    if not trial.cause:
        return work.hurry(trial)
    is_over = work.trials >= MAX_TRIALS or work.budget_s <= work.reserve_s
    if not (work.give_up(trial) if is_over else work.reduce(trial)):
        return False
    while work.budget_s <= -OVERRUN_S and work.give_up(trial):
        pass  # one step after the other would take a run each
    progress(f"{name}: {one_line(trial.cause)[:150]}: run without the cause")
    return True


def _run_suites(work: Settlement, limit_s: float, progress: Callable[[str], None]) -> list[FirstRuns]:
    """The runs of both suites, with as many tests as the budget allows; what fails in one is taken out of both."""
    work.reserve_s = 0.0
    trials: dict[str, FirstRuns] = {}
    passed: dict[str, Draft] = {}
    while True:
        suite = next((name for name in SUITES if passed.get(name) != _what_runs(work.draft)), "")
        if not suite:
            return list(trials.values())
        trial = trials[suite] = work.try_out(suite, None, limit_s)
        if trial.is_ended:
            work.draft = replace(work.draft, sizes={**work.draft.sizes, suite: max(trial.tests, MIN_TESTS)})
        work.draft = without(work.draft, trial.failed)
        is_known = trial.error == TOO_LONG and work.budget_s <= 0.0 and any(other.passed for other in trials.values())
        if not is_known and _go_on(work, trial, f"first runs, {suite}", progress):
            continue  # where the budget is over, a suite that is too slow says nothing against the draft
        if suite == "rl":  # what it has shown of states are targets of the other one
            work.draft = replace(work.draft, declared=with_steps(work.draft.declared, work.seen))
        passed[suite] = _what_runs(work.draft)
        progress(f"first runs, {suite}: {trial.tests} tests, {trial.passed} passed before requirements were settled")


def _what_runs(draft: Draft) -> Draft:
    """The draft without its requirements and sizes, which change no run."""
    return replace(draft, dropped=(), has_dropped_all=False, sizes={})


def _without_rare(draft: Draft, trials: Sequence[FirstRuns]) -> Draft:
    """The draft, in which requirements that few tests checked are questions: a smaller session would miss them."""
    rare = dict.fromkeys(name for trial in trials for name in trial.rare)
    return with_some_requirement(without(draft, tuple(rare)))


def _with_problems(draft: Draft, trials: Sequence[FirstRuns]) -> Draft:
    """The draft with what the runs have shown that somebody has to fix."""
    causes = {trial.cause: trial.raised_at for trial in trials if trial.cause}
    problems = [Problem("raised", f"{one_line(cause)}: the draft is not green", at) for cause, at in causes.items()]
    return replace(draft, declared=replace(draft.declared, problems=(*draft.declared.problems, *problems)))
