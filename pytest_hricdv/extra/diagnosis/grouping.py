"""Groups failures by probable cause, from their association with disturbances and statements over all tests.

`Subject.groups` calls `group_failures`, which returns a `Group` for each cause:

1. Each failure is assigned the preceding disturbance that is most associated with failures of its requirement (Ochiai's
   coefficient). It is assigned none if such failures also occur without that disturbance and not clearly less often
   (Fisher's exact test).
2. Failures of one test with the same disturbance are one incident: the later ones follow from the first. Failures of
   several tests that violate the same requirement with the same disturbance, or without one, have one cause, in any
   state of the code: how far it had come depends on the rest of the test. They have two causes only if both kinds occur
   in several tests and differ in their suspicious statements.
3. Among kinds of failures without a disturbance, a rarer one follows from another one if nearly all of its tests also
   have the other one, never later, and this is unlikely to be chance (Fisher's exact test; either order is equally
   probable), unless an experiment has refuted it. Kinds of different tests have one cause if they violate the same
   requirement and share their most suspicious statements.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from itertools import combinations
from math import exp, lgamma

from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.spectrum import ExecutionCounts, Spectra, ochiai

BY_CHANCE = 0.3
"""Significance level at which a kind of failure is taken to follow from another one. High, because a kind that occurs
only in tests that also fail otherwise is usually a consequence: with 0.01, a bug seeded in the tutorials was split
into several causes in 4 of 19 cases; with 0.3 in none, while of pairs of simultaneous bugs one more in four was
merged."""

BESIDE_OTHERS = 0.05
"""Significance level at which a disturbance is associated with failures of a requirement, if some of these occur
without it. The usual level: a bug that makes seven tests fail, three of which have a disturbance each, is then one
cause."""

SAME_TESTS = 0.8
"""Share of the tests with the rarer kind that must also have the other one. Chosen: the end of a run can prevent a
consequence (0.5 and 1.0: not measured)."""

SEVERAL = 2
"""Number of tests in which a kind must occur before suspicious statements can separate it from another one: what a
single test executes alone is mostly unrelated to its failure. Chosen."""

Change = str
"""The name of the disturbance without which failures are expected to go away; empty for none."""
Kind = tuple[Change, str, str, str]
"""A kind of failure: change, requirement, state, and message."""


@dataclass(frozen=True)
class ExperimentEvidence:
    """Evidence from experiments: node id and requirement of failures -> changes.

    With `asks`, disturbances that may come with failures by chance count, too, as hypotheses for further experiments.
    `apart` has a node id and two requirements: when the first passed, the second still failed, so it does not follow
    from the first. `together` has pairs that one reversed decision lets pass, also in different tests.
    """

    confirmed: Mapping[tuple[str, str], Change] = field(default_factory=dict)
    refuted: Mapping[tuple[str, str], Collection[Change]] = field(default_factory=dict)
    asks: bool = False
    apart: frozenset[tuple[str, str, str]] = frozenset()
    together: frozenset[tuple[str, str, str]] = frozenset()


@dataclass(frozen=True)
class Group:
    """Failures that have probably one cause.

    Args:
        change: the disturbance without which they do not come; empty for none.
        failures: the failures, in the order of tests, then of time.
    """

    change: Change
    failures: tuple[Failure, ...]

    @cached_property
    def nodeids(self) -> tuple[str, ...]:
        """The ids of the tests, each once."""
        return tuple(dict.fromkeys(failure.nodeid for failure in self.failures))

    @cached_property
    def telling(self) -> frozenset[str]:
        """The ids of the tests that show it: tests with unknown violations, or else all."""
        return frozenset(failure.nodeid for failure in self.failures if self.is_known or not failure.is_known)

    @cached_property
    def requirements(self) -> tuple[str, ...]:
        """The failing requirements, those of most tests first."""
        counts = Counter(failure.requirement for failure in self.failures)
        return tuple(sorted(counts, key=lambda name: (-counts[name], name)))

    @cached_property
    def first(self) -> tuple[str, str, str]:
        """Requirement, state and message of the first failure of most tests; new failures take precedence."""
        firsts: dict[str, tuple[str, str, str]] = {}
        for failure in self.failures:
            if self.is_known or not failure.is_known:
                firsts.setdefault(failure.nodeid, failure.kind)
        counts = Counter(firsts.values())
        return max(counts, key=lambda kind: (counts[kind], kind))

    @property
    def is_known(self) -> bool:
        """Whether all of its violations are known."""
        return all(failure.is_known for failure in self.failures)


def group_failures(
    tests: Mapping[str, Sequence[str]], failures: Sequence[Failure], spectra: Spectra, evidence: ExperimentEvidence
) -> tuple[Group, ...]:
    """Groups of failures, those with new violations first, then those of most tests.

    Args:
        tests: node id -> the disturbances of each test that was run, failing or not.
        failures: the failures, in the order of tests, then of time.
        spectra: what tests execute.
        evidence: the evidence of experiments.
    """
    changes = _Association(tests, failures, evidence)
    kinds: dict[Kind, list[Failure]] = {}
    for failure in failures:
        kinds.setdefault((changes.of(failure), *failure.kind), []).append(failure)
    sets = _DisjointSets(kinds)
    _unite_incidents(kinds, sets)
    _unite_states(kinds, sets, spectra)
    _unite_nominal({kind: kinds[kind] for kind in kinds if not kind[0]}, sets, spectra, len(tests), evidence)
    place = {failure: number for number, failure in enumerate(failures)}
    groups = [
        Group(
            _change_of(same),
            tuple(sorted((failure for kind in same for failure in kinds[kind]), key=place.__getitem__)),
        )
        for same in sets.sets()
    ]
    return tuple(sorted(groups, key=lambda group: (group.is_known, -len(group.nodeids), group.change, group.first)))


class _Association:
    """The association of disturbances with failures."""

    def __init__(
        self, tests: Mapping[str, Sequence[str]], failures: Iterable[Failure], evidence: ExperimentEvidence
    ) -> None:
        self._having: dict[str, set[str]] = {}
        for nodeid, disturbances in tests.items():
            for name in disturbances:
                self._having.setdefault(name, set()).add(nodeid)
        self._failing: dict[str, set[str]] = {}
        self._of_kind: dict[tuple[str, str, str], set[str]] = {}
        for failure in failures:
            self._failing.setdefault(failure.requirement, set()).add(failure.nodeid)
            self._of_kind.setdefault(failure.kind, set()).add(failure.nodeid)
        self._tests = len(tests)
        self._evidence = evidence
        self._without: dict[tuple[str, Change], set[str]] = {}
        for (nodeid, requirement), changes in evidence.refuted.items():
            for change in changes:
                self._without.setdefault((requirement, change), set()).add(nodeid)
        self._score = cache(self._score_of)

    def of(self, failure: Failure) -> Change:
        """The change without which a failure does not come, as far as is known."""
        key = failure.nodeid, failure.requirement
        if key in self._evidence.confirmed:
            return self._evidence.confirmed[key]
        refuted = self._evidence.refuted.get(key, ())
        scores = {name: self._score(name, failure.kind) for name in failure.disturbances if name not in refuted}
        best = max(scores, key=lambda name: (scores[name], failure.disturbances.index(name)), default="")
        return best if scores.get(best, 0.0) > 0.0 else ""

    def _score_of(self, name: str, kind: tuple[str, str, str]) -> float:
        """0 if tests without it fail as often, or nearly.

        A test that has failed all the same without the disturbance is one without it.
        """
        requirement = kind[0]
        failing = self._failing[requirement]
        having = self._having.get(name, set()) - self._without.get((requirement, name), set())
        both, others = len(having & failing), self._tests - len(having)
        without = len(failing) - both
        if others and both * others <= without * len(having):
            return 0.0
        is_sure = self._of_kind[kind] <= having or self._evidence.asks
        if is_sure or _by_chance(both, len(having), len(failing), self._tests) < BESIDE_OTHERS:
            return ochiai(ExecutionCounts(both, len(having) - both, len(failing)))
        return 0.0


class _DisjointSets:
    """Kinds in sets, which are united (R. Tarjan: Efficiency of a Good But Not Linear Set Union Algorithm, 1975)."""

    def __init__(self, kinds: Iterable[Kind]) -> None:
        self._parents = {kind: kind for kind in kinds}

    def _root(self, kind: Kind) -> Kind:
        while self._parents[kind] != kind:
            kind = self._parents[kind]
        return kind

    def unite(self, kind: Kind, other: Kind) -> None:
        """Make one set of those that have them."""
        self._parents[self._root(other)] = self._root(kind)

    def sets(self) -> list[list[Kind]]:
        """The sets."""
        members: dict[Kind, list[Kind]] = {}
        for kind in self._parents:
            members.setdefault(self._root(kind), []).append(kind)
        return [*members.values()]


def _unite_incidents(kinds: Mapping[Kind, Iterable[Failure]], sets: _DisjointSets) -> None:
    """Unite the failures of one test that go away with the same disturbance."""
    first: dict[tuple[str, Change], Kind] = {}
    for kind, members in kinds.items():
        for failure in members if kind[0] else ():
            sets.unite(first.setdefault((failure.nodeid, kind[0]), kind), kind)


def _unite_states(kinds: Mapping[Kind, Sequence[Failure]], sets: _DisjointSets, spectra: Spectra) -> None:
    """Unite failures of several tests with the same disturbance, or none, and the same violation, in whatever state."""
    same: dict[tuple[Change, str, str, bool], list[Kind]] = {}
    for kind, members in kinds.items():
        is_known = all(failure.is_known for failure in members)
        same.setdefault((kind[0], kind[1], kind[3], is_known), []).append(kind)
    for kind, other in (pair for alike in same.values() for pair in combinations(alike, 2)):
        one, two = ({failure.nodeid for failure in kinds[which]} for which in (kind, other))
        if min(len(one), len(two)) < SEVERAL or not _elsewhere(one, two, spectra):
            sets.unite(kind, other)


def _elsewhere(one: Collection[str], two: Collection[str], spectra: Spectra) -> bool:
    """Whether quite other statements are suspicious of some tests than of others."""
    places = [spectra.specific(tests, {*one, *two}) for tests in (one, two)]
    return all(places) and places[0].isdisjoint(places[1])


def _change_of(kinds: Iterable[Kind]) -> Change:
    """The disturbance that all of them have; none if they have several."""
    changes = {kind[0] for kind in kinds}
    return changes.pop() if len(changes) == 1 else ""


def _unite_nominal(
    kinds: Mapping[Kind, Sequence[Failure]],
    sets: _DisjointSets,
    spectra: Spectra,
    tests: int,
    evidence: ExperimentEvidence,
) -> None:
    """Unite failures without a disturbance that follow from another failure, or violate the same at the same places in
    the code.

    Requirements that fail in different tests are one cause only if an experiment has shown it. One overrules what comes
    in the same tests, too.

    What is known explains nothing that is new: a known violation in many tests would hide it.
    """
    times_s = {kind: {failure.nodeid: failure.time_s for failure in members} for kind, members in kinds.items()}
    failing = {failure.nodeid for members in kinds.values() for failure in members}
    places = {kind: spectra.specific(names.keys(), failing) for kind, names in times_s.items()}
    known = {kind for kind, members in kinds.items() if all(failure.is_known for failure in members)}
    apart, together = ({(first, second) for _, first, second in shown} for shown in (evidence.apart, evidence.together))
    for kind, other in combinations(kinds, 2):
        if (kind in known) != (other in known):
            continue
        one, two = times_s[kind], times_s[other]
        if (
            {(kind[1], other[1]), (other[1], kind[1])} & together
            or (kind[1] == other[1] and places[kind] and places[kind] == places[other])
            or ((other[1], kind[1]) not in apart and _follows(one, two, tests))
            or ((kind[1], other[1]) not in apart and _follows(two, one, tests))
        ):
            sets.unite(kind, other)


def _follows(some: Mapping[str, float], others: Mapping[str, float], tests: int) -> bool:
    """Whether some failures follow from others: nearly all of their tests have these, earlier, and hardly by chance.

    Args:
        some: node id -> when (s).
        others: the same.
        tests: how many there are.
    """
    both = some.keys() & others.keys()
    if len(some) > len(others) or len(both) < SAME_TESTS * len(some):
        return False
    if any(some[nodeid] < others[nodeid] for nodeid in both):
        return False
    later = sum(some[nodeid] > others[nodeid] for nodeid in both)
    return _by_chance(len(both), len(some), len(others), tests) * 0.5**later < BY_CHANCE


def _by_chance(both: int, some: int, others: int, tests: int) -> float:
    """The probability that two sets of these sizes have this many tests in common, or more.

    By Fisher's exact test, one-sided (R. Fisher: Statistical Methods for Research Workers, 1934).
    """
    fewer, more = sorted((some, others))
    all_ways = _log_comb(tests, fewer)
    return sum(
        exp(_log_comb(more, common) + _log_comb(tests - more, fewer - common) - all_ways)
        for common in range(max(both, fewer + more - tests), fewer + 1)
    )


def _log_comb(size: int, chosen: int) -> float:
    return lgamma(size + 1) - lgamma(chosen + 1) - lgamma(size - chosen + 1)
