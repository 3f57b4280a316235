"""`hricdv report triage`: proposes entries of `hri_known_violations`, each with a condition of one cause's violations.

The command in `feature` calls `proposals`, and prints the `lines` of the result. An entry also names the cause: a
violation under the condition that has another cause is new, and fails the session. `compare_with_entries` reports such
causes at the end of a session.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from pytest_hricdv._base import own_json as json
from pytest_hricdv.extra.diagnosis.causes import id_of
from pytest_hricdv.extra.diagnosis.conditions import Examples, LearnedCondition, RunMoment, condition_for
from pytest_hricdv.extra.diagnosis.experiments import evidence_of
from pytest_hricdv.extra.diagnosis.failures import FAULT, Failure
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group
from pytest_hricdv.extra.diagnosis.records import DIAGNOSIS, Diagnosis
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.monitor import Log, Vocabulary
from pytest_hricdv.report.formatting import by_requirement, plural
from pytest_hricdv.results.gates import Exemption
from pytest_hricdv.results.model import Report, TestResult, Timeline

_KINDS: Mapping[str, type[bool] | type[float] | type[str]] = {"bool": bool, "float": float, "str": str}


@dataclass(frozen=True)
class LoggedMessage:
    """A message in the timeline of a report."""

    time_s: float
    topic: str
    fields: Mapping[str, object]


def round_time(time_s: float) -> float:
    """A time (s) with the resolution of timelines."""
    return round(time_s, 3)


def vocabulary_of(diagnosis: Diagnosis) -> Vocabulary:
    """The names that conditions may use."""
    messages = {
        topic: {name: _KINDS[kind] for name, kind in fields.items()} for topic, fields in diagnosis.messages.items()
    }
    return Vocabulary({name: _KINDS[kind] for name, kind in diagnosis.signals.items()}, messages)


def log_of(test: TestResult, vocabulary: Vocabulary) -> Log:
    """The log of a test, from its timeline. Raises ValueError if none of its runs ended."""
    timeline = test.timeline
    if timeline is None:
        raise ValueError(f"{test.id}: no run of it came to an end")
    signals = {name: _series(text) for name, text in timeline.signals.items() if name in vocabulary.signals}
    texts = {
        name: ([time_s for time_s, _ in changes], [text for _, text in changes])
        for name, changes in timeline.texts.items()
        if name in vocabulary.signals
    }
    return Log({**signals, **texts}, _messages(timeline, vocabulary), timeline.end_s)


def _series(text: str) -> tuple[list[float], list[float]]:
    numbers = [float(word) for word in text.split()]
    return numbers[::2], numbers[1::2]


def _messages(timeline: Timeline, vocabulary: Vocabulary) -> list[LoggedMessage]:
    made = []
    for message in timeline.messages:
        time_s, _, topic, fields = message.split("\t", 3)
        kinds = vocabulary.messages.get(topic)
        if kinds is not None:
            values = json.loads(fields)
            made.append(LoggedMessage(float(time_s), topic, {name: kind(values[name]) for name, kind in kinds.items()}))
    return made


REASON = "why is this tolerated? [owner?]"
"""Placeholder for reason and owner, which people have to fill in."""

MAX_PASSING = 20
"""Number of passing tests on which a condition is checked. Chosen: each costs a pass of the monitors."""


@dataclass(frozen=True)
class TriageEntry:
    """A proposal for one requirement of a cause.

    Args:
        requirement: its id.
        condition: the condition that holds in its violations; None if none could be learned.
        line: the line to paste; empty if no condition separates the cause.
        replaces: the condition of the entry that the requirement has now; empty if it has none.
        note: what is to be said of it; may be empty.
    """

    requirement: str
    condition: LearnedCondition | None
    line: str = ""
    replaces: str = ""
    note: str = ""


@dataclass(frozen=True)
class TriageProposal:
    """The proposal for a cause: its failures, and an entry for each of its requirements."""

    group: Group
    entries: tuple[TriageEntry, ...]


def proposals(report: Report, diagnosis: Diagnosis) -> tuple[TriageProposal, ...]:
    """A proposal for each unknown cause of a report with failing tests."""
    subject = Subject.of(report)
    # Known violations take no experiments: a later session compares causes by association alone.
    ids = {failure: id_of(group) for group in subject.groups(ExperimentEvidence()) for failure in group.failures}
    triage = _Triage(report, vocabulary_of(diagnosis), ids)
    evidence = evidence_of(diagnosis.experiments)
    groups = [group for group in subject.groups(evidence) if not group.is_known]
    return tuple(TriageProposal(group, tuple(triage.entries(group))) for group in groups)


@dataclass
class _Triage:
    report: Report
    vocabulary: Vocabulary
    ids: Mapping[Failure, str]
    """Failures -> the causes that an entry names for them."""
    _logs: dict[str, Log] = field(default_factory=dict)

    @cached_property
    def _tests(self) -> Mapping[str, TestResult]:
        return {test.nodeid: test for test in self.report.tests if test.timeline is not None}

    def entries(self, group: Group) -> Iterator[TriageEntry]:
        """The entries, one for each requirement that fails for the cause."""
        for requirement in sorted(group.requirements, key=by_requirement):
            if requirement == FAULT:
                yield TriageEntry(FAULT, None, note="a fault of a run is not a violation: it cannot be declared known")
            else:
                yield self._entry(
                    requirement, [failure for failure in group.failures if failure.requirement == requirement]
                )

    def _entry(self, requirement: str, failures: Sequence[Failure]) -> TriageEntry:
        examples = self._examples(requirement, {failure.nodeid for failure in failures})
        condition = condition_for(examples, self._logs_of(examples), self.vocabulary)
        if condition is None or condition.wrong:
            return TriageEntry(requirement, condition, note=self._inseparable(requirement, examples, condition))
        replaces = "" if self.report.strict else self.report.known_when.get(requirement, "")
        text = f"({replaces}) | ({condition.text})" if replaces else condition.text
        reason = f"{self.report.known_violations[requirement]}; {REASON}" if replaces else REASON
        causes = ",".join(
            dict.fromkeys(
                (
                    *(self._violations(requirement) if replaces else ()),
                    *(self.ids[failure] for failure in failures),
                )
            )
        )
        return TriageEntry(requirement, condition, f"{requirement} of {causes} when {text}: {reason}", replaces)

    def _violations(self, requirement: str) -> Iterator[str]:
        """The causes of what the entry of a requirement tolerates by now."""
        for failure, name in self.ids.items():
            if failure.requirement == requirement and failure.is_known:
                yield name

    def _examples(self, requirement: str, tests: set[str]) -> Examples:
        """Moments of new violations of the requirement in these tests, of those in others, and without a violation."""
        has_entry = not self.report.strict and requirement in self.report.known_when
        inside: list[RunMoment] = []
        outside: list[RunMoment] = []
        elsewhere: list[RunMoment] = []
        passing = 0
        for nodeid, test in self._tests.items():
            result = test.requirements.get(requirement)
            if result is None:
                continue
            is_inside = nodeid in tests
            violated = (
                RunMoment(nodeid, round_time(violation.time_s))
                for violation in result.violations
                if violation.outside or not (is_inside and has_entry)
            )
            (inside if is_inside else outside).extend(violated)
            if result.verdict == "Passed" and passing < MAX_PASSING:
                passing += 1
                elsewhere += [RunMoment(nodeid, time_s) for time_s in _decide(test, requirement)]
        unique = (tuple(dict.fromkeys(moments)) for moments in (inside, outside, elsewhere))
        return Examples(*unique)

    def _logs_of(self, examples: Examples) -> Mapping[str, Log]:
        for nodeid in dict.fromkeys(moment.nodeid for moment in examples.all):
            if nodeid not in self._logs:
                self._logs[nodeid] = log_of(self._tests[nodeid], self.vocabulary)
        return self._logs

    def _inseparable(self, requirement: str, examples: Examples, condition: LearnedCondition | None) -> str:
        count = plural(len(examples.inside), "violation")
        if condition is None:
            return f"no signal, message or state is the same at its {count}"
        ids = dict.fromkeys(self._tests[moment.nodeid].id for moment in condition.wrong)
        where = f"`{condition.text}` holds at its {count}, and at {len(condition.wrong)} of other causes"
        return f"no condition separates it; {where}, first in {next(iter(ids))}"


def _decide(test: TestResult, requirement: str) -> Iterator[float]:
    """The times at which triggers of a requirement were decided (s)."""
    for trigger in (test.timeline.triggers.get(requirement, "") if test.timeline else "").split():
        yield float(trigger.rstrip("!?").rpartition("-")[2])


def lines(report: Report, made: Sequence[TriageProposal]) -> Iterator[str]:
    """The proposals, for people: what each cause is, and then what to paste."""
    ids = {test.nodeid: test.id for test in report.tests}
    for number, proposal in enumerate(made, 1):
        group = proposal.group
        state = f", first in the state {group.first[1]}" if group.first[1] else ""
        names = f"{', '.join(group.requirements)} in {plural(len(group.nodeids), 'test')}"
        yield f"cause {number}: {names}{state}, as in {ids[group.nodeids[0]]}"
        for entry in proposal.entries:
            yield from _entry_lines(entry)
    entries = [entry for proposal in made for entry in proposal.entries if entry.line]
    twice = sorted({entry.requirement for entry in entries if _count(entries, entry.requirement) > 1})
    if twice:
        yield ""
        names = ", ".join(twice)
        yield f"A requirement has one entry: to tolerate several causes of {names}, name all, and join conditions by |."
    if entries:
        yield ""
        yield "An entry goes into the list hri_known_violations, with a reason and an owner."


def _count(entries: Sequence[TriageEntry], requirement: str) -> int:
    return sum(entry.requirement == requirement for entry in entries)


def _entry_lines(entry: TriageEntry) -> Iterator[str]:
    if entry.line:
        yield f"    {entry.line}"
        if entry.replaces:
            yield f"      instead of the entry {entry.requirement} when {entry.replaces}"
    if entry.note:
        yield f"    {entry.requirement}: {entry.note}"


def compare_with_entries(report: Report, entries: Mapping[str, Exemption]) -> Iterator[tuple[bool, str]]:
    """Differences between the causes of known violations and their entries: whether the cause is new, and a sentence.

    Args:
        report: the report of all tests: association over a part of them may give other causes.
        entries: requirement -> its entry; those that name no causes say nothing of them.
    """
    subject = Subject.of(report)
    diagnosis = DIAGNOSIS.of(report)
    evidence = ExperimentEvidence() if diagnosis is None else evidence_of(diagnosis.experiments)
    groups = subject.groups(evidence)
    # Experiments are made only while something is new: what is named by association alone is meant, too.
    associated = groups if evidence == ExperimentEvidence() else subject.groups(ExperimentEvidence())
    otherwise = {failure: id_of(group) for group in associated for failure in group.failures}
    ids = {id_of(group) for group in groups} | {*otherwise.values()}
    for requirement, entry in entries.items():
        if not entry.causes:
            continue
        for group in groups:
            failing = [
                failure.nodeid
                for failure in group.failures
                if failure.requirement == requirement and failure.is_known and otherwise[failure] not in entry.causes
            ]
            if failing and id_of(group) not in entry.causes:
                tests = f"{plural(len(failing), 'test')} {'violates' if len(failing) == 1 else 'violate'}"
                yield (
                    True,
                    f"{requirement} is known of {_list(entry)}, but {tests} it for cause {id_of(group)}, first "
                    f"{subject.tests[failing[0]].id}: fix it, or name it in hri_known_violations",
                )
        for name in entry.causes:
            if name not in ids:
                yield (
                    False,
                    f"{requirement} is known of cause {name}, which is gone: no test fails for it; take it out of "
                    "hri_known_violations",
                )


def _list(entry: Exemption) -> str:
    word = "cause" if len(entry.causes) == 1 else "causes"
    return f"{word} {', '.join(entry.causes)}"
