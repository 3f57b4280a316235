"""Gaps of code, plans and bins: named by their place, with the nearest test or the beliefs that would close them."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.coverage.code_map import Bits, CodeMap, SourceFile
from pytest_hricdv.coverage.cross_product import ExplorationRecord, PlannedBin, ProductDeclaration, Proof
from pytest_hricdv.coverage.gaps import bin_gaps, code_gaps, plan_gaps
from pytest_hricdv.coverage.records import Gap, WaiverRecord
from pytest_hricdv.coverage.suite_coverage import RunCoverage

SOURCE = """\
class Arm:
    def move(self, way):
        if way:
            self.go()
        return self

    def stop(self):
        raise OSError  # unreachable: nothing stops it

def spare():
    def inner():
        return 1
    return inner
"""
FILE = SourceFile(
    "arm.py",
    Path("arm.py"),
    (1, 2, 3, 4, 5, 7, 8, 10, 11, 12, 13),
    ((3, 4), (3, 5)),
    (WaiverRecord(file="arm.py", line=8, reason="nothing stops it"),),
    SOURCE,
)
CODE = CodeMap(("arm",), (FILE,), "0")
LOADED = (1, 2, 7, 10)


def bits(*lines: int, arcs: tuple[tuple[int, int], ...] = ()) -> Bits:
    return CODE.bits({"arm.py": [*LOADED, *lines]}, {"arm.py": arcs})


def run(name: str, covered: Bits) -> RunCoverage:
    return RunCoverage(name, covered, {})


def found(*runs: RunCoverage, total: Bits) -> list[Gap]:
    return list(code_gaps(CODE, total, runs))


def test_an_uncalled_function_and_a_waived_line_are_different_gaps() -> None:
    whole = bits(3, 4, 5, arcs=((3, 4), (3, 5)))
    assert found(run("t", whole), total=whole) == [
        Gap("statements", "arm.py", ("8",), "waived as unreachable: nothing stops it", "", "", ()),
        Gap("statements", "arm.py spare.inner", ("12",), "no test reaches this function", "", "", ()),
        Gap("statements", "arm.py spare", ("11", "13"), "no test reaches this function", "", "", ()),
    ]


def test_objects_that_are_made_where_nothing_is_measured_are_no_unreached_code() -> None:
    source = "class Arm:\n    def __init__(self):\n        self.at = 0\n\n    def move(self):\n        self.at = 1\n"
    file = SourceFile("arm.py", Path("arm.py"), (1, 2, 3, 5, 6), (), (), source)
    code = CodeMap(("arm",), (file,), "0")
    moved, loaded = (code.bits({"arm.py": [1, 2, 5, *lines]}, {"arm.py": ()}) for lines in ([6], []))
    (gap,) = code_gaps(code, moved, [run("t", moved)])
    assert (gap.location, gap.items) == ("arm.py Arm.__init__", ("3",))
    assert "made outside of run.measured" in gap.reason
    gaps = [*code_gaps(code, loaded, [run("t", loaded)])]
    assert {gap.reason for gap in gaps} == {"no test reaches this function"}


def test_a_part_of_a_function_names_the_test_that_ran_most_of_it_and_the_way_in() -> None:
    near, far = bits(3, 5, arcs=((3, 5),)), bits(3)
    gap = next(gap for gap in found(run("far", far), run("near", near), total=near) if "move" in gap.location)
    assert (gap.kind, gap.items, gap.test) == ("statements", ("4",), "near")
    assert gap.suggestion == "vary near: line 3 has to continue to line 4 (`if way:`)"


def test_a_branch_between_lines_that_run_is_a_gap_of_its_own() -> None:
    always = bits(3, 4, 5, arcs=((3, 4),))
    gap = next(gap for gap in found(run("t", always), total=always) if gap.kind == "branches")
    assert gap == Gap(
        "branches",
        "arm.py Arm.move",
        ("3->5",),
        "line 3 runs, but never continues to 5",
        "vary t: line 3 has to continue to line 5 (`if way:`)",
        "t",
        (),
    )


def test_a_plan_gap_names_the_beliefs_that_reach_it_or_says_that_none_do() -> None:
    declared = {"human": ("p1", "p2", "p3")}
    runs = [RunCoverage("t", None, {"human": frozenset({"p1"})})]
    plans = {"human": {"p1": ("a",), "p2": ("a", "b")}}
    explored = ExplorationRecord(status="proven", reason="", runs=9, plans=plans, bins={})
    second, third = plan_gaps(declared, runs, explored)
    assert (second.items, second.beliefs) == (("p2",), ("a", "b"))
    assert second.suggestion == "the beliefs a b reach it"
    assert third.reason == "no set of beliefs triggers it: all 9 runs of the model were explored"
    unknown = ExplorationRecord(status="not proven", reason="too large")
    assert "is not proven (too large)" in list(plan_gaps(declared, runs, unknown))[-1].reason


def test_a_bin_gap_names_the_beliefs_that_aim_at_it() -> None:
    products = {
        name: ProductDeclaration(coordinates=(), impossible=(), illegal=(), proof=proof)
        for name, proof in {"turn": Proof(status="proven", reason="", runs=9), "read": Proof()}.items()
    }
    missing: dict[str, list[tuple[str, ...]]] = {"turn": [("1", "bored", "kept")], "read": [("x",)]}
    explored = ExplorationRecord(bins={"turn": (PlannedBin(bin=("1", "bored"), beliefs=("leg4", "bored")),)})
    turn, read = bin_gaps(products, missing, explored)
    assert turn.beliefs == ("leg4", "bored")
    assert turn.suggestion == "the beliefs leg4 bored aim at 1 x bored; the rest is up to the run"
    assert (read.beliefs, read.suggestion) == ((), "")
