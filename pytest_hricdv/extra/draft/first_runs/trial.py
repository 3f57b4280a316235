"""A draft after its first runs: what holds in them is required, and what does not is a question."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

from pytest_hricdv.extra.draft.first_runs.dialogs import Dialog, Reached, found_dialogs
from pytest_hricdv.extra.draft.first_runs.session import Trial, covered, run
from pytest_hricdv.extra.draft.found.findings import Problem
from pytest_hricdv.extra.draft.writing.drafted import ENDS, Draft
from pytest_hricdv.extra.draft.writing.requirements import requirement_ids

FIRST = 8
"""Tests of the very first runs (chosen: one has each start and most manners)."""

SEARCH_S = 30.0
"""Processor time in which dialogs are tried (chosen: a draft is to be green within two minutes); what would take
longer than that, as those before took, is not begun."""

LATE = "late"
"""Kind of the problem that the search for dialogs was ended."""

SUITES = ("rl", "closure")
"""The suites that are to be green."""


MEND = "what do the stand-ins of `ports.py` have to say there?"
"""What to do where the first runs raise."""

MEND_NODE = "which fields has what `said` in `conftest.py` sends it, and what do others answer?"
"""The same where the code is a node of ROS 2."""


def mend(draft: Draft, trial: Trial) -> str:
    """What to do where the first runs of a draft raise.

    What the code raises in some of them, and not in the others, most often is a fault of the code.
    """
    stand_ins = MEND if draft.ros is None else MEND_NODE
    if trial.raised_at is None or not 0 < trial.raised < trial.tests:
        return stand_ins
    share = f"{trial.raised} of {trial.tests} tests end so"
    return f"{share}: a fault of the code, for what it hears in them (`pytest` shows it)? if not, {stand_ins}"


def tried(draft: Draft, suites: Sequence[str] = SUITES) -> tuple[Draft, tuple[Trial, ...]]:
    """The draft after its first runs: requirements that do not hold are questions in it.

    A draft whose runs go round without time passing is tried once more with devices that take time, and one whose tests
    leave a state to each other with a process for each test. Runs may end as they did, and no other way.
    """
    trials: list[Trial] = []
    draft = replace(draft, may_end=())
    if "rl" in suites:
        draft = _begun(draft)
    for suite in suites:
        draft, trial = _settled(draft, suite)
        trials.append(trial)
        draft = without(draft, trial.failed)
        if trial.is_ended and trial.tests:
            draft = replace(draft, sizes={**draft.sizes, suite: trial.tests})
        if trial.error:
            break
    ids = [name for subject, name in requirement_ids(draft).items() if subject not in draft.dropped]
    unseen = [name for name in ids if all(name in trial.never for trial in trials)]
    held = {*ids} - {*unseen}
    by_one = {name: suite for suite, trial in zip(suites, trials, strict=False) for name in trial.never if name in held}
    draft = replace(draft, untriggered=by_one)
    return _with_problems(without(draft, unseen), trials), tuple(trials)


def _begun(draft: Draft) -> Draft:
    """The draft after few tests, as all of them would take long where much fails; with dialogs that lead further."""
    draft, first = _ending(draft, "rl", FIRST)
    if first.error and "no simulated time" not in first.error and draft.has_others:
        without_others, known = _ending(replace(draft, has_others=False), "rl", FIRST)
        if not known.error:  # the code raises for a text that it does not know
            draft, first = without_others, known
    draft = replace(draft, takes_time="no simulated time" in first.error)
    draft = without(draft, first.failed)
    if first.error or draft.ros is not None:  # a node takes many times as long as code that is called
        return draft
    begin_s = _children_s()
    took_s = 0.0
    refused: list[Dialog] = []

    def in_time(dialogs: Sequence[Dialog]) -> Mapping[Dialog, Reached]:
        nonlocal took_s
        if _children_s() + took_s - begin_s >= SEARCH_S:
            refused.extend(dialogs)
            return {}
        from_s = _children_s()
        ran = covered(draft, dialogs)
        took_s = _children_s() - from_s
        return ran

    with_dialogs = replace(draft, dialogs=found_dialogs(draft, in_time, first.reached))
    return _late(with_dialogs) if refused else with_dialogs


def _late(draft: Draft) -> Draft:
    """The draft, which says that a machine that is faster may find more dialogs."""
    text = f"the search for dialogs ended after {SEARCH_S:g} s of processor time: a longer one may find others"
    findings = draft.findings
    return replace(draft, findings=replace(findings, problems=(*findings.problems, Problem(LATE, text, None))))


def _children_s() -> float:
    """Processor time of all sessions that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def _settled(draft: Draft, suite: str) -> tuple[Draft, Trial]:
    """The runs of a suite, and the draft with what they need to end, and to repeat."""
    draft, trial = _ending(draft, suite)
    if trial.error and "no simulated time" in trial.error and not draft.takes_time:
        draft, trial = _ending(replace(draft, takes_time=True), suite)
    if trial.leaks and not draft.isolates:
        draft, trial = _ending(replace(draft, isolates=True), suite)
    return draft, trial


def _ending(draft: Draft, suite: str, tests: int | None = None) -> tuple[Draft, Trial]:
    """The runs of a suite, and the draft that allows how they end, and waives nothing that they executed."""
    trial = run(draft, suite, tests)
    while ends := set(trial.ends) - set(draft.may_end):
        draft = replace(draft, may_end=tuple(end for end in ENDS if end in (*draft.may_end, *ends)))
        trial = run(draft, suite, tests)
    return replace(draft, no_waivers=draft.no_waivers or trial.no_waivers), trial


def _with_problems(draft: Draft, trials: Sequence[Trial]) -> Draft:
    """The draft with what the runs have shown that somebody has to mend."""
    effects = tuple(dict.fromkeys(effect for trial in trials for effect in trial.effects))
    raised = tuple(
        Problem("raised", f"{_one_line(trial.error)}: the draft is not green; {mend(draft, trial)}", trial.raised_at)
        for trial in trials
        if trial.error
    )
    differing = tuple(
        Problem("unrepeatable", f"a run is another one when it is run again ({reason}): the draft is not green", None)
        for reason in dict.fromkeys(trial.unrepeatable for trial in trials if trial.unrepeatable)
    )
    findings = draft.findings
    return replace(draft, findings=replace(findings, problems=findings.problems + effects + raised + differing))


def _one_line(text: str) -> str:
    return " ".join(text.split())


def without(draft: Draft, names: Sequence[str]) -> Draft:
    """The draft, in which these requirements are questions."""
    subjects = {name: subject for subject, name in requirement_ids(draft).items()}
    dropped = tuple(subjects[name] for name in names if name in subjects)
    made = replace(draft, dropped=tuple(dict.fromkeys(draft.dropped + dropped)))
    return replace(made, has_dropped_all=made.has_dropped_all or {*subjects.values()} <= {*made.dropped})
