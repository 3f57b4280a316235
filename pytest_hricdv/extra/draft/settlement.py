"""`Settlement`: a draft between its first runs, with steps to run it and remove what failed; `settling` calls them."""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code.sources import find_around
from pytest_hricdv.extra.draft.code_model import CodeLine, CodeModel, Question
from pytest_hricdv.extra.draft.first_runs import TOO_LONG, FirstRuns, run
from pytest_hricdv.extra.draft.observe.observations import Observations, merge_observations
from pytest_hricdv.extra.draft.project.draft import ENDS, Draft
from pytest_hricdv.extra.draft.project.requirements import ENDS_VISIT, requirement_ids

FIRST_TESTS = 8
"""Tests of the first suite, with each start belief and most other beliefs."""

MIN_TESTS = 12
"""Tests of a suite, however little time there is: in fewer, what people do may well reach nothing by chance."""

NO_COMMANDS = ("wait_", "stay")
"""Prefixes of commands at which a person does nothing."""

KEPT = frozenset(("transitions", "statemachine", "py_trees", "pydantic", "attrs", "attr", "msgspec"))
"""Libraries without stand-ins: declarations of the code are read from their objects."""

MAX_ENTRIES = 3
"""Most entries that are tried, if nothing that people do reaches the likeliest one."""

MAX_LOOKS = 6
"""Most drafts in a row that are made from what runs of the one before have shown."""

MAX_LISTED = 6
"""Most items that a question lists."""

MIN_RUN_S = 10.0
"""Processor time that a run may always take: pytest itself and the imports of the code are part of it."""

BUDGET_S = 60.0
"""Processor time of all first runs."""

Reread = Callable[[Observations | None, frozenset[str]], CodeModel]
"""Reads the code again, with what was observed, and with the libraries that failed."""


@dataclass
class Settlement:
    """A draft between its first runs, and what they have shown.

    Args:
        draft: as it is now.
        reread: reads the code again; None where nothing more can be known of it.
        budget_s: processor time that is left. reserve_s: of it, for the two suites.
        asked: cause and subject -> the question, of what was taken out.
    """

    draft: Draft
    reread: Reread | None
    budget_s: float = BUDGET_S
    reserve_s: float = 0.0
    asked: dict[tuple[str, str], Question] = field(default_factory=dict)
    seen: Observations = field(default_factory=Observations)
    faulty: frozenset[str] = frozenset()
    trials: int = 0
    looks: int = 0
    isolated_for: str = ""
    """The error for which each test got a process of its own."""

    def try_out(self, suite: str = "rl", tests: int | None = FIRST_TESTS, limit_s: float = 20.0) -> FirstRuns:
        """Run the draft as it is, until all ends of its runs are allowed; requirements are told by their subjects."""
        while True:
            self.draft = with_some_requirement(self.draft)
            subjects = {name: subject for subject, name in requirement_ids(self.draft).items()}
            trial = run(self.draft, suite, max(MIN_RUN_S, min(limit_s, self.budget_s)), tests)
            failed, rare = ([subjects[name] for name in names if name in subjects]
                            for names in (trial.failed, trial.rare))  # fmt: skip
            trial = replace(trial, failed=tuple(failed), rare=tuple(rare))
            self.trials += 1
            self.budget_s -= trial.used_s
            if trial.seen is not None:
                self.seen = merge_observations((self.seen, trial.seen))
            new = set(trial.ends) - set(self.draft.allowed_endings)
            if not new:
                return trial
            ends = tuple(end for end in ENDS if end in (*self.draft.allowed_endings, *new))
            self.draft = replace(self.draft, allowed_endings=ends)

    def hurry(self, trial: FirstRuns) -> bool:
        """Let calls take time where few tests ended; returns whether they do so from now on."""
        return self._is_slow(trial) and self._take_time(trial)

    def _is_slow(self, trial: FirstRuns) -> bool:
        return trial.is_ended and trial.tests < MIN_TESTS

    def reduce(self, trial: FirstRuns) -> bool:
        """Take out what fails; returns whether anything was."""
        self._end_isolation(trial)
        if trial.error.startswith("ERROR"):  # no test began
            steps = [self._drop_name, self._run_in_root, self._replace_libraries,
                     self._drop_entry, self._drop_code]  # fmt: skip
        elif trial.raising and not trial.calm and not any(trial.last):  # before anybody does anything
            steps = [self._run_in_root, self._take_time, self._isolate, self._replace_libraries, self._end_at_error,
                     self._drop_state, self._try_entry, self._drop_entry]  # fmt: skip
        elif trial.error and trial.error != TOO_LONG:
            steps = [self._run_in_root, self._take_time, self._isolate, self._accept_differences,
                     self._replace_libraries, self._end_at_error, self._leave_out, self._drop_state,
                     self._drop_calls, self._try_entry, self._fall_silent]  # fmt: skip
        elif trial.is_hollow or trial.error:
            steps = [self._take_time, self._try_entry, self._fall_silent]
        else:
            steps = [self._isolate, self._accept_differences]
        return any(step(trial) for step in steps) or self.give_up(trial)

    def give_up(self, trial: FirstRuns) -> bool:
        """Take out all that may fail, the most harmless first; returns whether anything was."""
        self._end_isolation(trial)
        steps = [self._run_in_root, self._take_time, self._leave_out_all, self._fall_silent,
                 self._drop_entry, self._drop_code]  # fmt: skip
        return any(step(trial) for step in steps)

    def _drop_name(self, trial: FirstRuns) -> bool:
        """Leave out what the testbench refuses by its name: a message, or what a device returns."""
        if not trial.error.startswith("ERROR"):
            return False
        for message in self.draft.code.messages:
            if re.search(rf"['`\"]({message.name}|{message.topic})\b", trial.error):
                return self._take_out(trial, message.name, f"`{message.name}` is left out")
        for sensor in self.draft.sensors:
            if f"'{sensor.name}'" in trial.error:
                levels = tuple(f"set_{word(sensor.name)} {level}" for level, _ in sensor.levels)
                self.draft = replace(self.draft, left_out=(*self.draft.left_out, *levels))
                return True
        return False

    def _run_in_root(self, trial: FirstRuns) -> bool:
        """Run the code in its folder, or the one above, where an error names a file there by a relative path.

        What is not Python's own says so in words of its own, as `Error opening file 'scenes/room.xml'`.
        """
        root = Path(self.draft.code.root)
        names = re.findall(r"['\"]([^'\"/\s][^'\"\n]*)['\"]", trial.error)
        files = [name for name in names if "/" in name or "." in name]
        folder = next((parent for parent in (root, root.parent) for name in files if (parent / name).is_file()), None)
        if self.draft.working_folder or folder is None:
            return False
        self.draft = replace(self.draft, working_folder=str(folder))
        return True

    def _take_time(self, trial: FirstRuns) -> bool:
        """Let calls of devices and polls take time, where the code asks without waiting, or is slow as it does."""
        is_still = "no simulated time" in trial.error or "without time passing" in trial.error
        if not (is_still or self._is_slow(trial)) or self.draft.takes_time:
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

    def _end_isolation(self, trial: FirstRuns) -> None:
        """Run tests in one process again, if what they were isolated for happens in processes of their own, too."""
        if self.isolated_for and self.isolated_for == trial.error:
            self.draft = replace(self.draft, isolates=False)

    def _replace_libraries(self, trial: FirstRuns) -> bool:
        """Give what is made from a library that failed a stand-in."""
        own = class_at(Path(self.draft.code.root), trial.raised_at)
        new = (trial.libraries - KEPT | ({f".{own}"} if own else frozenset())) - self.faulty
        if self.reread is None or not new or not trial.error:
            return False
        self.faulty |= new
        model = self.reread(self.seen, self.faulty)
        if model.inner == self.draft.declared.inner:
            return False
        names = ", ".join(port.name for port in model.inner)
        self._ask(f"{one_line(trial.error)}: `{names}` has a stand-in now. What does it do?", "inner", trial)
        self.draft = replace(self.draft, declared=model)
        return True

    def _end_at_error(self, trial: FirstRuns) -> bool:
        """Let the code end where it lacks a file, a connection or a module, whatever somebody did before."""
        name = trial.error.partition(":")[0].rpartition(".")[2]
        kind = getattr(builtins, name, None)
        is_lacking = isinstance(kind, type) and issubclass(kind, OSError | ImportError)
        if not is_lacking or name in self.draft.may_raise or self.draft.ros is not None:
            return False
        self._ask(f"{one_line(trial.error)}: the code ends there. What does it need?", "run", trial)
        self.draft = replace(self.draft, may_raise=(*self.draft.may_raise, name))
        return True

    def _try_entry(self, trial: FirstRuns) -> bool:
        """Take the next entry that gets something from outside, where nothing reaches the one that there is."""
        entry = self.draft.declared.entry
        tried = [name for name in self.faulty if ":" in name]
        if self.reread is None or entry is None or len(tried) + 1 >= MAX_ENTRIES:
            return False
        faulty = self.faulty | {f"{entry.module}:{entry.name}"}
        model = self.reread(self.seen, faulty)
        if model.entry is None or (model.entry.module, model.entry.name) == (entry.module, entry.name):
            return False
        reason = one_line(trial.cause)
        self._ask(f"Does `{model.entry.name}` run the robot, and not `{entry.name}`? {reason}", "entry", trial)
        self.faulty = faulty
        self.draft = replace(self.draft, declared=model, left_out=(), taken_out=frozenset())
        return True

    def _accept_differences(self, trial: FirstRuns) -> bool:
        """Do without the audit, where a test does not repeat."""
        if not trial.unrepeatable or not self.draft.audits:
            return False
        self._ask(f"A test does not repeat: {trial.unrepeatable}. What of it comes from outside a run?", "run", trial)
        self.draft = replace(self.draft, audits=False)
        return True

    def _leave_out(self, trial: FirstRuns) -> bool:
        """Leave out the commands at which tests ended that raise, or the one that they have and the others have not."""
        shares = {command: share for command, share in _shares(trial).items() if command not in self.draft.left_out}
        only = [
            command for command, (_, calm) in shares.items() if trial.calm and calm == 0.0 and command in trial.last
        ]
        if only or not shares:
            return self._leave(trial, only)
        shares = {command: share for command, share in shares.items() if command in trial.last} or shares
        worst = max(shares, key=lambda command: (shares[command][0] - shares[command][1], trial.last.count(command)))
        is_evident = shares[worst][0] > shares[worst][1] or worst in trial.last
        return self._leave(trial, [worst] if is_evident else [])

    def _leave_out_all(self, trial: FirstRuns) -> bool:
        """Leave out all commands that are only in tests that raise, or at which these ended."""
        return self._leave(trial, [command for command, (_, calm) in _shares(trial).items()
                                   if calm == 0.0 or command in trial.last])  # fmt: skip

    def _leave(self, trial: FirstRuns, commands: Sequence[str]) -> bool:
        new = [command for command in commands if command not in self.draft.left_out]
        if not new:
            return False
        names = _list(new)
        self._ask(f"{names}: {one_line(trial.error)}: a bug in the code, or nothing that anybody does?", new[0], trial)
        self.draft = replace(self.draft, left_out=(*self.draft.left_out, *new))
        return True

    def _drop_state(self, trial: FirstRuns) -> bool:
        is_observed = any(message.form == "state" for message in self.draft.code.messages)
        is_told = self.draft.ros is not None and bool(self.draft.code.state)
        return (is_observed or is_told) and self._take_out(trial, "state", "its state is not observed")

    def _drop_calls(self, trial: FirstRuns) -> bool:
        is_called = any(message.form == "call" for message in self.draft.code.messages)
        return is_called and self._take_out(trial, "calls", "nobody calls it")

    def _fall_silent(self, trial: FirstRuns) -> bool:
        """Let the person only be there, where what it does reaches nothing, or stops the code."""
        if self.draft.is_alone:
            return False
        does = [thing.name for thing in self.draft.inputs] + [sensor.name for sensor in self.draft.sensors]
        listed = _list(does)
        reason = one_line(trial.error)
        text = f"{reason}: is {listed} what people do?" if reason else f"How does {listed} get to the code? Nothing did"
        self._ask(text, "messages", trial)
        self.draft = replace(self.draft, is_silent=True)
        return True

    def _drop_entry(self, trial: FirstRuns) -> bool:
        is_run = self.draft.code.entry is not None and self.draft.ros is None
        return is_run and self._take_out(trial, "entry", "it is only imported")

    def _drop_code(self, trial: FirstRuns) -> bool:
        is_imported = self.draft.imports_code and self.draft.ros is None
        return is_imported and self._take_out(trial, "import", "it is not imported")

    def _take_out(self, trial: FirstRuns, what: str, how: str) -> bool:
        self._ask(
            f"The code could not be run as it is: {one_line(trial.cause)}; {how}. What does it need?", "run", trial
        )
        needed = {"entry"} if what == "import" else set()
        self.draft = replace(self.draft, taken_out=self.draft.taken_out | {what} | needed)
        return True

    def _ask(self, text: str, about: str, trial: FirstRuns) -> None:
        """Ask about what was removed: one question for each cause, as more of it is removed."""
        entry = self.draft.declared.entry
        location = trial.raised_at or (entry.location if entry is not None else None)
        self.asked[trial.cause, about] = Question(text[:400], about, location)

    def look_again(self) -> bool:
        """Remake the draft from the observations; returns whether it differs."""
        if self.reread is None or self.seen.is_empty or self.looks >= MAX_LOOKS:
            return False
        model = self.reread(self.seen, self.faulty)
        if model == self.draft.declared:
            return False
        self.looks += 1
        self.draft = replace(self.draft, declared=model)
        return True


def class_at(root: Path, location: CodeLine | None) -> str:
    """The class of the code around a line; empty if there is none."""
    around = find_around(root / location.file, location.line) if location is not None else []
    return next((node.name for node in reversed(around) if isinstance(node, ast.ClassDef)), "")


def _shares(trial: FirstRuns) -> dict[str, tuple[float, float]]:
    """Each command of tests that raise -> the share of these that have it, and of the others; alike without any."""
    commands = sorted({command for names in trial.raising for command in names if not command.startswith(NO_COMMANDS)})

    def share(command: str, tests: Sequence[frozenset[str]]) -> float:
        return sum(command in test for test in tests) / len(tests)

    return {command: (share(command, trial.raising), share(command, trial.calm or trial.raising))
            for command in commands}  # fmt: skip


def _list(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names[:MAX_LISTED]) + (" and more" if len(names) > MAX_LISTED else "")


def with_some_requirement(draft: Draft) -> Draft:
    """The draft, with the requirement that a visit ends where no other one is left."""
    is_none = {*requirement_ids(draft)} <= {*draft.dropped}
    dropped = tuple(subject for subject in draft.dropped if subject != ENDS_VISIT)
    return replace(draft, has_dropped_all=True, dropped=dropped) if is_none else draft


def without(draft: Draft, subjects: Sequence[str]) -> Draft:
    """The draft, in which the requirements on these subjects are questions."""
    return with_some_requirement(replace(draft, dropped=tuple(dict.fromkeys((*draft.dropped, *subjects)))))


def one_line(text: str) -> str:
    return " ".join(text.split())
