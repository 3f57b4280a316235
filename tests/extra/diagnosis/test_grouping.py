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
