"""The order in which repairs are tried, and the tests they are held to; causes that one repair mends are one."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from msgspec.structs import replace

from pytest_hricdv.coverage.code_map import Bits, CodeMap, SourceFile
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.grouping import Group, Spectra, grouped
from pytest_hricdv.extra.diagnosis.hints import Hint
from pytest_hricdv.extra.diagnosis.locating import Locating, ordered, share_of_first
from pytest_hricdv.extra.diagnosis.repairs import Repair
from pytest_hricdv.extra.diagnosis.runs import Ran
from pytest_hricdv.extra.diagnosis.spectrum import Suspect
from pytest_hricdv.generate.concrete import ConcreteTest
from tests.report import sample

REPAIR = Repair("robot.py", 3, "act", "left out", "without `x`", "")
TESTS = {name: ConcreteTest(name, "suite", 1, (), {}) for name in ("a", "b", "c")}
FAILURES = [
    Failure(name, requirement, "", "", 1.0, (), is_known=False)
    for name, requirement in (("a", "R1"), ("b", "R2"), ("c", "R3"))
]
RESULT = sample.report(tests=1).tests[0]


def groups_of(experiments: Experiments) -> tuple[Group, ...]:
    tests: dict[str, tuple[str, ...]] = dict.fromkeys((*TESTS, "passing"), ())
    return grouped(tests, FAILURES, Spectra(), experiments.evidence)


def robot(repair: Repair, test: ConcreteTest) -> Ran:
    """With the repair, all but the test c pass."""
    return Ran(violated=("R3",) if test.id == "c" else (), checked=("R1", "R2"))


@pytest.mark.parametrize(("budget", "unchanged", "left"), [(9, 1, 2), (9, 0, 3), (0, 1, 3)])
def test_causes_that_one_repair_mends_are_one(budget: int, unchanged: int, left: int) -> None:
    experiments = Experiments(lambda evidence: (), TESTS, lambda test: None, budget)
    locating = Locating(cast("Any", None), experiments, Spectra(), dict.fromkeys(TESTS, RESULT), robot)
    groups = groups_of(experiments)
    assert len(groups) == 3
    first = next(number for number, group in enumerate(groups) if group.nodeids == ("a",))
    hints = [[Hint(REPAIR, 1, unchanged)] if number == first else [] for number in range(3)]
    experiments.mended += locating.joined(groups, hints)
    assert experiments.used == (2 if budget and unchanged else 0)
    assert len(groups_of(experiments)) == left
    assert {entry.nodeid for entry in experiments.mended} == ({"a", "b"} if left == 2 else set())


LOOKING = """\
NEAR_M = 0.5


def look(base):
    while base.ahead_m() > NEAR_M:
        base.turn()
    base.stop()


def rest(base):
    base.stop()
"""
LINES = (1, 5, 6, 7, 11)
CODE = CodeMap(("robot",), (SourceFile("robot.py", Path("robot.py"), LINES, (), (), LOOKING),), "")
RANKED = [Suspect("robot.py", line, 1.0 - 0.1 * number, 0) for number, line in enumerate((5, 6, 7, 1))]


def test_repairs_come_by_place_and_kind_and_a_constant_with_what_reads_it() -> None:
    made = ordered(CODE, RANKED)
    assert [(repair.line, repair.operator) for repair in made[:9]] == [
        (5, "condition changed"),
        *[(1, "number changed")] * 6,
        (5, "comparison changed"),
        (6, "left out"),
    ]
    numbers = [repair.words.split("`")[1] for repair in made if repair.line == 1]
    assert numbers == ["0.4", "0.625", "0.25", "1.0", "0.05", "5.0"]


@pytest.mark.parametrize(
    ("runs", "failing", "share"),
    [(20, [22, 1], 14), (20, [1], 20), (20, [5, 5], 10), (0, [3, 1], 0), (9, [1, 1, 7], 2)],
)
def test_causes_of_more_failing_tests_get_more_runs(runs: int, failing: list[int], share: int) -> None:
    assert share_of_first(runs, failing) == share


def test_one_program_is_tried_once_whatever_statement_it_repairs() -> None:
    texts = [repair.text for repair in ordered(CODE, RANKED)]
    assert len({*texts}) == len(texts)


@pytest.mark.parametrize(("breaks", "lines"), [("looks", [5]), ("rests", [1, 5])])
def test_a_constant_is_held_to_tests_that_execute_what_reads_it(breaks: str, lines: list[int]) -> None:
    """The test `rests` is shorter, and executes the constant, as all tests do, and nothing that reads it."""
    bits = {"a": Bits(0b01111), "rests": Bits(0b10001), "looks": Bits(0b01111)}
    tests = {
        name: replace(RESULT, nodeid=name, abstract=("x",) * length, requirements={})
        for name, length in (("a", 1), ("rests", 1), ("looks", 2))
    }
    chosen = {name: SimpleNamespace(concrete=ConcreteTest(name, "suite", 1, (), {})) for name in tests}
    session = SimpleNamespace(context=SimpleNamespace(code=CODE), aggregation=SimpleNamespace(chosen=chosen))

    def run(repair: Repair, test: ConcreteTest) -> Ran:
        is_broken = repair.line == 1 and test.id == breaks
        return Ran(violated=("R9",) if is_broken else (), checked=("R1",))

    experiments = Experiments(lambda evidence: (), {"a": chosen["a"].concrete}, lambda test: None, 40)
    locating = Locating(cast("Any", session), experiments, Spectra(CODE, bits), tests, run)
    group = next(group for group in grouped(dict.fromkeys(tests, ()), FAILURES[:1], Spectra(), experiments.evidence))
    hints = locating.hints(group, [RANKED[3], RANKED[0]], 40)
    assert sorted(hint.repair.line for hint in hints) == lines
