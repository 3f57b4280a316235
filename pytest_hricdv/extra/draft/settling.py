"""How first runs settle a draft: what fails in them is taken out and becomes a question, until it is green.

Everything has a budget of processor time. What it does not suffice for is smaller: fewer tests, fewer things to say.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code_model import CodeModel, Problem, Question
from pytest_hricdv.extra.draft.first_runs import FirstRuns, run
from pytest_hricdv.extra.draft.observe.observations import Observations, merge_observations
from pytest_hricdv.extra.draft.project.draft import ENDS, Draft
from pytest_hricdv.extra.draft.project.requirements import requirement_ids

FIRST_TESTS = 8
"""Tests of the first suite, with each start belief and most other beliefs."""

MAX_LOOKS = 3
"""Drafts that are made of what the runs of the one before have shown."""

MAX_TRIALS = 25
"""Runs of a few tests in all, however little each takes."""

MAX_REPEATS = 4
"""Runs of a suite in which single things are taken out; after that, everything that may fail is."""

MIN_RUN_S = 10.0
"""Processor time that a run may always take: pytest itself and the imports of the code are part of it."""

SHARE = 0.35
"""Of the budget, for each of the two suites; the rest is for what comes before."""

BUDGET_S = 60.0
"""Processor time of all first runs."""

_REFUSED = re.compile(r"requirements\.toml:.*?\brequirement (\S+?)[,:]")
"""The id of a requirement that cannot be read, in an error."""

Reread = Callable[[Observations | None, frozenset[str]], CodeModel]
"""Reads the code again, with what was observed, and with the libraries that failed."""


@dataclass
class Settlement:
    """A draft while it is settled.

    Args:
        draft: as it is now.
        reread: reads the code again; None where nothing more can be known of it.
        budget_s: processor time that is left.
        questions: of what was taken out.
    """

    draft: Draft
    reread: Reread | None
    budget_s: float = BUDGET_S
    questions: list[Question] = field(default_factory=list)
    seen: Observations = field(default_factory=Observations)
    faulty: frozenset[str] = frozenset()
    trials: int = 0
    is_reduced: bool = False
    isolated_for: str = ""
    """The error for which each test got a process of its own."""

    def try_out(self, suite: str = "rl", tests: int | None = FIRST_TESTS, limit_s: float = 20.0) -> FirstRuns:
        """Run the draft as it is, until all ends of its runs are allowed."""
        while True:
            self.draft = _with_some_requirement(self.draft)
            trial = run(self.draft, suite, max(MIN_RUN_S, min(limit_s, self.budget_s)), tests)
            self.trials += 1
            self.budget_s -= trial.used_s
            if trial.seen is not None:
                self.seen = merge_observations((self.seen, trial.seen))
            if trial.no_waivers and not self.draft.no_waivers:
                self.draft = replace(self.draft, no_waivers=trial.no_waivers)
            new = set(trial.ends) - set(self.draft.allowed_endings)
            if not new:
                return trial
            ends = tuple(end for end in ENDS if end in (*self.draft.allowed_endings, *new))
            self.draft = replace(self.draft, allowed_endings=ends)

    def reduce(self, trial: FirstRuns) -> bool:
        """Take out what fails; returns whether anything was."""
        if self.isolated_for and self.isolated_for == trial.error:
            self.draft = replace(self.draft, isolates=False)  # it was not that
        steps = (
            *(self._drop_requirement, self._drop_name, self._run_in_root, self._take_time, self._isolate),
            *(self._replace_libraries, self._leave_out, self._give_up_unknown, self._drop_state, self._drop_calls),
            *(self._drop_inputs, self._drop_entry, self._drop_code),
        )
        for step in steps:
            if step(trial):
                self.is_reduced = True
                return True
        return False

    def _drop_requirement(self, trial: FirstRuns) -> bool:
        """Leave out a requirement that the testbench refuses."""
        found = _REFUSED.search(trial.error)
        before = self.draft.dropped
        if found is not None:
            self.draft = _without(self.draft, (found.group(1),))
        return self.draft.dropped != before

    def _drop_name(self, trial: FirstRuns) -> bool:
        """Leave out what the testbench refuses by its name: a message, or what a device returns."""
        if not trial.error.startswith("ERROR"):
            return False
        for message in self.draft.code.messages:
            if re.search(rf"['`\"]({message.name}|{message.topic})\\b", trial.error):
                messages = tuple(each for each in self.draft.code.messages if each is not message)
                return self._drop(trial, f"`{message.name}` is left out", replace(self.draft.code, messages=messages))
        for sensor in self.draft.sensors:
            if f"'{sensor.name}'" in trial.error:
                levels = tuple(f"set_{word(sensor.name)} {level}" for level, _ in sensor.levels)
                self.draft = replace(self.draft, left_out=(*self.draft.left_out, *levels))
                return True
        return False

    def _run_in_root(self, trial: FirstRuns) -> bool:
        """Run the code in the folder that it is in, where it opens a file of it by a relative path."""
        found = re.search(r"FileNotFoundError: .*?'([^'/][^']*)'", trial.error)
        if self.draft.runs_in_root or found is None or not (Path(self.draft.code.root) / found.group(1)).exists():
            return False
        self.draft = replace(self.draft, runs_in_root=True)
        return True

    def _take_time(self, trial: FirstRuns) -> bool:
        """Let calls of devices take time, where the code asks them without waiting."""
        is_still = "no simulated time" in trial.error or "without time passing" in trial.error
        if not is_still or self.draft.takes_time:
            return False
        self.draft = replace(self.draft, takes_time=True)
        return True

    def _isolate(self, trial: FirstRuns) -> bool:
        """Give each test a process of its own, if one may have left a state to the next."""
        is_later = bool(trial.raising and trial.calm) and not self.isolated_for
        if self.draft.isolates or not (trial.leaks or is_later):
            return False
        self.isolated_for = trial.error or "leaks"
        self.draft = replace(self.draft, isolates=True)
        return True

    def _replace_libraries(self, trial: FirstRuns) -> bool:
        """Give what is made from a library that failed a stand-in."""
        new = trial.libraries - self.faulty
        if self.reread is None or not new or not trial.error:
            return False
        self.faulty |= new
        model = self.reread(self.seen, self.faulty)
        if model.inner == self.draft.code.inner:
            return False
        names = ", ".join(port.name for port in model.inner)
        self._ask(f"{_one_line(trial.error)}: `{names}` has a stand-in now. What does it do?", "inner", trial)
        self.draft = replace(self.draft, code=model)
        return True

    def _leave_out(self, trial: FirstRuns) -> bool:
        """Leave out the command that tests which raise have, and the others do not have."""
        scores: dict[str, float] = {}
        for command in sorted({command for commands in trial.raising for command in commands}):
            raising = sum(command in commands for commands in trial.raising) / len(trial.raising)
            calm = sum(command in commands for commands in trial.calm) / len(trial.calm) if trial.calm else 0.0
            if calm < raising and not command.startswith("wait_") and command not in self.draft.left_out:
                scores[command] = raising - calm
        if not scores or not trial.calm:
            return False
        worst = max(scores, key=lambda command: scores[command])
        self._ask(
            f"`{worst}`: {_one_line(trial.error)}: a fault of the code, or nothing that anybody does?", worst, trial
        )
        self.draft = replace(self.draft, left_out=(*self.draft.left_out, worst))
        return True

    def _give_up_unknown(self, trial: FirstRuns) -> bool:
        if not self.draft.has_others:
            return False
        self.draft = replace(self.draft, has_others=False)
        return True

    def _drop_state(self, trial: FirstRuns) -> bool:
        messages = tuple(message for message in self.draft.code.messages if message.form != "state")
        if messages == self.draft.code.messages:
            return False
        machines = tuple(replace(machine, field="") for machine in self.draft.code.machines)
        return self._drop(
            trial, "its state is not observed", replace(self.draft.code, messages=messages, machines=machines)
        )

    def _drop_calls(self, trial: FirstRuns) -> bool:
        messages = tuple(message for message in self.draft.code.messages if message.form != "call")
        if messages == self.draft.code.messages:
            return False
        return self._drop(trial, "nobody calls it", replace(self.draft.code, messages=messages))

    def _drop_inputs(self, trial: FirstRuns) -> bool:
        messages = tuple(message for message in self.draft.code.messages if message.direction == "published")
        if messages == self.draft.code.messages:
            return False
        return self._drop(trial, "nobody tells it anything", replace(self.draft.code, messages=messages))

    def _drop_entry(self, trial: FirstRuns) -> bool:
        code = self.draft.code
        if code.entry is None or self.draft.ros is not None:
            return False
        return self._drop(trial, "it is only imported", replace(code, entry=None, messages=(), machines=(), inner=()))

    def _drop_code(self, trial: FirstRuns) -> bool:
        if not self.draft.imports_code or self.draft.ros is not None:
            return False
        self.draft = replace(self.draft, imports_code=False)
        return self._drop(trial, "it is not imported", replace(self.draft.code, entry=None, virtual=()))

    def give_up(self, trial: FirstRuns) -> bool:
        """Take out all that may fail; returns whether anything was."""
        return self._drop_entry(trial) or self._drop_code(trial)

    def _drop(self, trial: FirstRuns, how: str, code: CodeModel) -> bool:
        self._ask(
            f"The code could not be run as it is: {_one_line(trial.error)}; {how}. What does it need?", "run", trial
        )
        self.draft = replace(self.draft, code=code)
        return True

    def _ask(self, text: str, about: str, trial: FirstRuns) -> None:
        self.questions.append(Question(text[:400], about, trial.raised_at))

    def look_again(self) -> bool:
        """Make the draft anew of what was observed; returns whether it differs."""
        if self.reread is None or self.is_reduced or self.seen.is_empty:
            return False
        model = self.reread(self.seen, self.faulty)
        if model == self.draft.code:
            return False
        self.draft = replace(self.draft, code=model)
        return True


def settle(
    draft: Draft, reread: Reread | None = None, budget_s: float = BUDGET_S, progress: Callable[[str], None] = print
) -> tuple[Draft, tuple[FirstRuns, ...]]:
    """The draft after its first runs: it passes, with less where it did not.

    Args:
        draft: to be settled.
        reread: reads the code again with what was observed.
        budget_s: processor time of all runs.
        progress: called with a sentence for each step.
    """
    work = Settlement(replace(draft, allowed_endings=()), reread, budget_s)
    trial = _make_green(work, progress)
    for _ in range(MAX_LOOKS):
        if trial.error or work.budget_s < budget_s / 2 or not work.look_again():
            break
        progress("first runs: the draft has what they have shown, and runs again")
        trial = _make_green(work, progress)
    trials = [trial]
    if not trial.error:
        work.draft = _without(work.draft, trial.failed)
        trials = [_run_suite(work, suite, SHARE * budget_s, progress) for suite in ("rl", "closure")]
    made = _without_rare(work.draft, trials)
    code = replace(made.code, questions=(*work.questions, *made.code.questions))
    return replace(_with_problems(replace(made, code=code), trials), missing=trials[-1].missing), tuple(trials)


def _make_green(work: Settlement, progress: Callable[[str], None]) -> FirstRuns:
    """Run a few tests, and take out what fails, until nothing raises."""
    while True:
        trial = work.try_out()
        if not trial.error and not trial.leaks:
            return trial
        is_over = work.trials >= MAX_TRIALS or work.budget_s <= 0.0
        if not (work.give_up(trial) if is_over else work.reduce(trial)):
            return trial
        progress(f"first runs: {_one_line(trial.error or trial.unrepeatable)[:150]}: run without the cause")


def _run_suite(work: Settlement, suite: str, limit_s: float, progress: Callable[[str], None]) -> FirstRuns:
    """The runs of a suite, with as many tests as the budget allows; what fails in them is taken out, too."""
    for number in range(MAX_REPEATS + 3):
        trial = work.try_out(suite, None, limit_s)
        work.budget_s = max(work.budget_s, limit_s / 2)  # it has to be seen to be green
        if trial.is_ended:
            work.draft = replace(work.draft, sizes={**work.draft.sizes, suite: trial.tests or FIRST_TESTS})
        if trial.is_ended and not trial.tests:
            trial = replace(trial, error="")
            break
        work.draft = _without(work.draft, trial.failed)
        if not (trial.error or trial.leaks):
            break
        if not (work.reduce(trial) if number < MAX_REPEATS else work.give_up(trial)):
            break
        progress(f"first runs, {suite}: {_one_line(trial.error or trial.unrepeatable)[:150]}: run without the cause")
    progress(f"first runs, {suite}: {trial.tests} tests, {trial.passed} passed before requirements were settled")
    return trial


def _without_rare(draft: Draft, trials: Sequence[FirstRuns]) -> Draft:
    """The draft, in which requirements that few tests checked are questions: a smaller session would miss them."""
    rare = dict.fromkeys(name for trial in trials for name in trial.rare)
    return _with_some_requirement(_without(draft, tuple(rare)))


def _with_some_requirement(draft: Draft) -> Draft:
    """The draft, with a requirement on the visit where no other one is left."""
    is_none = {*requirement_ids(draft)} <= {*draft.dropped}
    return replace(draft, has_dropped_all=draft.has_dropped_all or is_none)


def _without(draft: Draft, names: Sequence[str]) -> Draft:
    """The draft, in which these requirements are questions."""
    subjects = {name: subject for subject, name in requirement_ids(draft).items()}
    dropped = tuple(subjects[name] for name in names if name in subjects)
    return _with_some_requirement(replace(draft, dropped=tuple(dict.fromkeys(draft.dropped + dropped))))


def _with_problems(draft: Draft, trials: Sequence[FirstRuns]) -> Draft:
    """The draft with what the runs have shown that somebody has to fix."""
    raised = tuple(Problem("raised", f"{_one_line(trial.error)}: the draft is not green", trial.raised_at)
                   for trial in trials if trial.error)  # fmt: skip
    differing = tuple(Problem("unrepeatable", text, None) for text in _differences(trials))
    code = draft.code
    hollow = tuple(
        Problem("hollow", text, None) for text in dict.fromkeys(each.hollow for each in trials if each.hollow)
    )
    return replace(draft, code=replace(code, problems=code.problems + raised + differing + hollow))


def _differences(trials: Sequence[FirstRuns]) -> Iterator[str]:
    for reason in dict.fromkeys(trial.unrepeatable for trial in trials if trial.unrepeatable):
        yield f"a run does not repeat ({reason}): the draft is not green"


def _one_line(text: str) -> str:
    return " ".join(text.split())
