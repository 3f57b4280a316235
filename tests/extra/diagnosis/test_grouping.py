"""Failures in groups: by the disturbance that they come with, by the tests that have them, by places in the code."""

from __future__ import annotations

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.code_map import Bits, CodeMap, SourceFile
from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group, group_failures
from pytest_hricdv.extra.diagnosis.spectrum import Spectra

NO_SPECTRA = Spectra()
TIMES = (("R1", 1.0), ("R2", 2.0))


def failure(
    test: str,
    requirement: str,
    *disturbances: str,
    state: str = "",
    time_s: float = 1.0,
    is_known: bool = False,
    said: str = "",
) -> Failure:
    return Failure(test, requirement, said, state, time_s, disturbances, is_known, said)


def of(
    tests: dict[str, tuple[str, ...]],
    failures: list[Failure],
    spectra: Spectra = NO_SPECTRA,
    evidence: ExperimentEvidence | None = None,
) -> list[tuple[str, set[str], set[str]]]:
    groups = group_failures(tests, failures, spectra, evidence or ExperimentEvidence())
    return [(group.change, set(group.nodeids), set(group.requirements)) for group in groups]


def passing(number: int) -> dict[str, tuple[str, ...]]:
    return {f"passing{place}": () for place in range(number)}


def test_failures_after_one_disturbance_have_one_cause() -> None:
    tests = {"a": ("shut",), "b": ("shut",), "c": ("step",), "d": ("step",), **passing(8)}
    failures = [
        failure("a", "R21", "shut"),
        failure("a", "R29", "shut"),
        failure("b", "R29", "shut"),
        failure("c", "R16", "step"),
        failure("c", "R2", "step"),
        failure("d", "R16", "step"),
    ]
    assert of(tests, failures) == [("shut", {"a", "b"}, {"R21", "R29"}), ("step", {"c", "d"}, {"R16", "R2"})]


def test_a_disturbance_that_passing_tests_have_as_often_is_no_cause() -> None:
    tests = {"a": ("noise", "shut"), "b": ("noise", "shut"), **{f"p{n}": ("noise",) for n in range(9)}, **passing(2)}
    assert of(tests, [failure("a", "R1", "noise", "shut"), failure("b", "R1", "noise", "shut")]) == [
        ("shut", {"a", "b"}, {"R1"})
    ]


def test_two_disturbances_in_one_test_have_each_their_own_failures() -> None:
    tests = {
        "a": ("shut",),
        "b": ("step",),
        "both": ("shut", "step"),
        **passing(6),
    }
    failures = [
        failure("a", "R29", "shut"),
        failure("b", "R16", "step"),
        failure("both", "R29", "shut", time_s=1.0),
        failure("both", "R16", "shut", "step", time_s=2.0),
    ]
    assert of(tests, failures) == [("shut", {"a", "both"}, {"R29"}), ("step", {"b", "both"}, {"R16"})]


def test_experiments_overrule_association() -> None:
    tests = {"a": ("shut", "step"), **passing(4)}
    failures = [failure("a", "R29", "shut", "step")]
    assert of(tests, failures)[0][0] == "step"
    refuted = ExperimentEvidence(refuted={("a", "R29"): {"step"}})
    assert of(tests, failures, evidence=refuted)[0][0] == "shut"
    confirmed = ExperimentEvidence(confirmed={("a", "R29"): "shut"})
    assert of(tests, failures, evidence=confirmed)[0][0] == "shut"
    nothing_left = ExperimentEvidence(refuted={("a", "R29"): {"step", "shut"}})
    assert of(tests, failures, evidence=nothing_left)[0][0] == ""


def test_a_fault_that_shows_in_tests_with_and_without_disturbances_is_one_cause() -> None:
    """As a robot that never releases: a disturbance of its own in three of the seven tests is no cause."""
    tests = {**{f"a{n}": () for n in range(4)}, "b": ("shut",), "c": ("late",), "d": ("leg",), **passing(15)}
    failures = [failure(test, "R1", *names) for test, names in tests.items() if not test.startswith("passing")]
    assert of(tests, failures) == [("", {*tests} - {*passing(15)}, {"R1"})]


def test_a_disturbance_is_a_cause_beside_another_one_if_it_goes_with_clearly_more_failures() -> None:
    shut: dict[str, tuple[str, ...]] = {f"s{n}": ("shut",) for n in range(4)}
    tests = {"a": (), "b": (), **shut, **passing(16)}
    failures = [failure(test, "R1", *tests[test]) for test in ("a", "b", *shut)]
    assert of(tests, failures) == [("shut", {*shut}, {"R1"}), ("", {"a", "b"}, {"R1"})]


def test_a_test_that_fails_without_the_disturbance_counts_against_it_in_other_tests() -> None:
    tests = {"a": ("shut",), "b": ("shut",), **passing(8)}
    failures = [failure("a", "R1", "shut"), failure("b", "R1", "shut")]
    assert of(tests, failures) == [("shut", {"a", "b"}, {"R1"})]
    refuted = ExperimentEvidence(refuted={("a", "R1"): {"shut"}})
    assert of(tests, failures, evidence=refuted) == [("", {"a", "b"}, {"R1"})]


def test_without_disturbances_what_the_same_tests_have_has_one_cause() -> None:
    tests = {**{f"a{n}": () for n in range(5)}, **{f"b{n}": () for n in range(5)}, **passing(20)}
    failures = [failure(f"a{n}", name) for n in range(5) for name in ("R1", "R2")]
    failures += [failure(f"b{n}", "R3") for n in range(5)]
    assert of(tests, failures) == [
        ("", {f"a{n}" for n in range(5)}, {"R1", "R2"}),
        ("", {f"b{n}" for n in range(5)}, {"R3"}),
    ]


def test_what_only_comes_in_tests_that_fail_otherwise_follows_from_that() -> None:
    tests = {**{f"a{n}": () for n in range(6)}, **passing(16)}
    failures = [*(failure(f"a{n}", "R1") for n in range(6)), failure("a0", "R2")]
    assert of(tests, failures) == [("", {f"a{n}" for n in range(6)}, {"R1", "R2"})]


def test_what_comes_before_does_not_follow() -> None:
    tests = {**{f"a{n}": () for n in range(9)}, **passing(13)}
    failures = [failure(f"a{n}", "R1", time_s=2.0) for n in range(9)]
    later = [*failures, *(failure(f"a{n}", "R2", time_s=3.0) for n in range(4))]
    sooner = [*failures, *(failure(f"a{n}", "R2", time_s=1.0) for n in range(4))]
    assert [requirements for _, _, requirements in of(tests, later)] == [{"R1", "R2"}]
    assert [requirements for _, _, requirements in of(tests, sooner)] == [{"R1"}, {"R2"}]


def test_the_order_is_evidence_where_the_tests_alone_are_little() -> None:
    """As a vacuum cleaner that waits blindly: it stays where it is, and its brush turns on."""
    tests = {**{f"a{n}": () for n in range(7)}, **passing(5)}
    failures = [failure(f"a{n}", "R2", time_s=2.0) for n in range(7)]
    assert len(of(tests, [*failures, *(failure(f"a{n}", "R3", time_s=2.0) for n in (0, 1))])) == 2
    assert len(of(tests, [*failures, *(failure(f"a{n}", "R3", time_s=3.0) for n in (0, 1))])) == 1


def test_places_that_all_tests_execute_are_no_common_cause() -> None:
    file = SourceFile("robot.py", Path("robot.py"), (1, 2), (), ())
    bits = {name: Bits(0b11) for name in ("a", "b", *passing(4))}
    spectra = Spectra(CodeMap(("robot",), (file,), ""), bits)
    tests: dict[str, tuple[str, ...]] = {"a": (), "b": (), **passing(4)}
    assert len(of(tests, [failure("a", "R1"), failure("b", "R2")], spectra)) == 2


def test_what_differs_from_a_model_in_two_ways_has_two_causes() -> None:
    tests = {**{f"a{n}": () for n in range(8)}, **passing(8)}
    failures = [
        *(failure(f"a{n}", "MODEL", said="expected pour; observed nothing") for n in range(4)),
        *(failure(f"a{n}", "MODEL", said="expected nothing; observed pour") for n in range(4, 8)),
    ]
    assert [nodeids for _, nodeids, _ in of(tests, failures)] == [
        {f"a{n}" for n in range(4, 8)},
        {f"a{n}" for n in range(4)},
    ]


def test_failures_in_all_tests_say_nothing_of_each_other() -> None:
    tests: dict[str, tuple[str, ...]] = {f"a{n}": () for n in range(10)}
    failures = [failure(f"a{n}", name) for n in range(10) for name in ("R1", "R2")]
    assert len(of(tests, failures)) == 2


def test_without_disturbances_the_same_places_are_one_cause() -> None:
    file = SourceFile("robot.py", Path("robot.py"), (1, 2), (), ())
    bits = {"a": Bits(0b11), "b": Bits(0b11), **{name: Bits(0b01) for name in passing(4)}}
    spectra = Spectra(CodeMap(("robot",), (file,), ""), bits)
    tests: dict[str, tuple[str, ...]] = {"a": (), "b": (), **passing(4)}
    assert of(tests, [failure("a", "R1", said="x"), failure("b", "R1", said="y")], spectra) == [
        ("", {"a", "b"}, {"R1"})
    ]
    different = [failure("a", "R1"), failure("b", "R2")]
    assert of(tests, different, spectra) == [("", {"a"}, {"R1"}), ("", {"b"}, {"R2"})]
    together = ExperimentEvidence(together=frozenset({("b", "R2", "R1")}))
    assert of(tests, different, spectra, together) == [("", {"a", "b"}, {"R1", "R2"})]


def test_what_is_still_violated_where_another_one_passes_does_not_follow_from_it() -> None:
    tests: dict[str, tuple[str, ...]] = {"a": (), "b": (), "c": (), **passing(9)}
    failures = [failure(name, requirement, time_s=time_s) for name in "abc" for requirement, time_s in TIMES]
    assert of(tests, failures) == [("", {"a", "b", "c"}, {"R1", "R2"})]
    apart = ExperimentEvidence(apart=frozenset({("a", "R1", "R2")}))
    assert of(tests, failures, evidence=apart) == [("", {"a", "b", "c"}, {"R1"}), ("", {"a", "b", "c"}, {"R2"})]
    reversed_pair = ExperimentEvidence(apart=frozenset({("a", "R2", "R1")}))  # R2 may well follow from R1
    assert of(tests, failures, evidence=reversed_pair) == [("", {"a", "b", "c"}, {"R1", "R2"})]


def test_what_goes_away_with_one_disturbance_and_violates_the_same_is_one_cause_in_whatever_state() -> None:
    """As the decision on a reading that flips: the violation is noticed 10 s later, wherever the robot is by then."""
    tests = {"a": ("flips",), "b": ("flips",), **passing(8)}
    failures = [failure("a", "R1", "flips", state="Receive"), failure("b", "R1", "flips", state="Release")]
    assert of(tests, failures) == [("flips", {"a", "b"}, {"R1"})]
    find_divergence = ExperimentEvidence(refuted={("b", "R1"): {"flips"}})
    assert [nodeids for _, nodeids, _ in of(tests, failures, evidence=find_divergence)] == [{"b"}, {"a"}]


def test_other_requirements_or_other_words_are_other_causes_of_a_disturbance() -> None:
    tests = dict.fromkeys(("a", "b", "c", "d"), ("flips",)) | passing(8)
    failures = [
        failure("a", "R1", "flips"),
        failure("b", "R2", "flips"),
        failure("c", "fault", "flips", said="no end"),
        failure("d", "fault", "flips", said="an exception"),
    ]
    assert len(of(tests, failures)) == 4


def test_in_another_state_and_at_other_places_of_several_tests_it_is_another_cause() -> None:
    file = SourceFile("robot.py", Path("robot.py"), (1, 2, 3), (), ())
    bits = {"a": Bits(0b011), "b": Bits(0b101), **{name: Bits(0b001) for name in passing(8)}}
    tests = {"a": ("flips",), "b": ("flips",), **passing(8)}
    failures = [failure("a", "R1", "flips", state="Receive"), failure("b", "R1", "flips", state="Release")]
    spectra = Spectra(CodeMap(("robot",), (file,), ""), bits)
    assert len(of(tests, failures, spectra)) == 1  # what one test executes alone is mostly what else it does
    twice = Spectra(spectra.code, bits | {"c": bits["a"], "d": bits["b"]})
    more = [failure("c", "R1", "flips", state="Receive"), failure("d", "R1", "flips", state="Release")]
    assert len(of(tests | {"c": ("flips",), "d": ("flips",)}, failures + more, twice)) == 2


def test_new_causes_come_first_then_those_of_most_tests() -> None:
    tests = {"a": ("x",), "b": ("x",), "c": ("y",), "d": ("z",), "e": ("z",), "f": ("z",), **passing(9)}
    failures = [
        *(failure(name, "R1", "x") for name in "ab"),
        failure("c", "R2", "y"),
        *(failure(name, "R3", "z", is_known=True) for name in "def"),
    ]
    assert [change for change, _, _ in of(tests, failures)] == ["x", "y", "z"]


@given(st.lists(st.sampled_from(["", "one", "two", "three"]), min_size=4, max_size=40))
def test_each_disturbance_that_makes_a_requirement_fail_is_one_cause(drawn: list[str]) -> None:
    tests = {f"t{number}": (name,) if name else () for number, name in enumerate(drawn)}
    failures = [failure(test, f"R-{names[0]}", *names) for test, names in tests.items() if names]
    if all(drawn) and len(set(drawn)) == 1:  # nothing to compare with: it may be anything that all tests have
        return
    groups: tuple[Group, ...] = group_failures(tests, failures, NO_SPECTRA, ExperimentEvidence())
    assert {group.change: len(group.nodeids) for group in groups} == {
        name: drawn.count(name) for name in set(drawn) if name
    }


def test_what_is_known_explains_nothing_that_is_new() -> None:
    """As a robot that is known to stand still in most tests, and answers nobody in some of them."""
    tests: dict[str, tuple[str, ...]] = {**{f"a{n}": () for n in range(6)}, **passing(3)}
    known = [failure(f"a{n}", "A4", time_s=1.0, is_known=True) for n in range(6)]
    new = [failure(f"a{n}", "N1", time_s=2.0) for n in range(3)]
    assert of(tests, [*known, *new]) == [
        ("", {"a0", "a1", "a2"}, {"N1"}),
        ("", {f"a{n}" for n in range(6)}, {"A4"}),
    ]


def test_a_cause_is_called_by_what_is_new_of_it() -> None:
    failures = (failure("a", "A4", "shut", is_known=True), failure("a", "N1", "shut", time_s=2.0))
    assert Group("shut", failures).first[0] == "N1"
    assert Group("shut", failures[:1]).first[0] == "A4"


def test_what_violates_the_same_without_a_disturbance_is_one_cause_in_whatever_state() -> None:
    """As a robot that answers no order, wherever it drives by then."""
    states = ("Fridge", "Human", "Sink")
    tests: dict[str, tuple[str, ...]] = dict.fromkeys(states, ()) | passing(6)
    assert of(tests, [failure(state, "N1", state=state) for state in states]) == [("", {*states}, {"N1"})]
    both = [failure(state, "N1", state=state, is_known=state == "Sink") for state in states]
    assert [nodeids for _, nodeids, _ in of(tests, both)] == [{"Fridge", "Human"}, {"Sink"}]
