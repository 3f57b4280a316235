"""Small reports with real figures: derived from tests that Hypothesis generates."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

from hypothesis import strategies as st

from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.coverage.cross_product import Coordinate, ExplorationRecord, ImpossibleBin, ProductDeclaration, Proof
from pytest_hricdv.coverage.records import MappedFile, ReportedCode, WaiverRecord
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.results.derivation import NO_CLOSURE, declare_suite, derive
from pytest_hricdv.results.model import (
    SCHEMA,
    ConcreteParameters,
    ModelSource,
    Report,
    RequirementText,
    RerunOptions,
    TestResult,
)
from pytest_hricdv.results.origin import Diversity, GenerationResult, LastNewPlan

STATEMENTS = 5
SIZE = 6
CODE = ReportedCode(
    packages=("robot",),
    sha256="5e" * 32,
    waivers=(WaiverRecord(file="robot/b.py", line=2, reason="the port never closes"),),
    map=(
        MappedFile(
            file="robot/a.py",
            statements=(1, 2, 4),
            branches=((2, 4), (2, -1)),
            source="def f():\n  g()\n\n  h()",
        ),
        MappedFile(file="robot/b.py", statements=(1, 2), branches=(), source="k()\nm()"),
    ),
    measured=False,
    reason="switched off",
    files=(),
)
PRODUCTS = {
    "turn": ProductDeclaration(
        coordinates=(Coordinate(name="leg", bins=("1", "2")), Coordinate(name="outcome", bins=("kept", "given"))),
        impossible=(ImpossibleBin(bin=("2", "kept"), reason="?", by="declared"),),
        illegal=(),
        proof=Proof(),
    )
}


def report(tests: Iterable[TestResult], wall_s: float = 1.0, shard: str = "") -> Report:
    """A derived report of some of the six tests of suite `rl`."""
    diagnosis = Diversity(
        distinct_subsets=1,
        belief_entropy_bits=0.5,
        belief_entropy_most_bits=1.0,
        plans_executed={"human": 3},
        last_new_plan=LastNewPlan(iteration=None, test=1),
    )
    generation = GenerationResult(
        wall_s=wall_s / 4,
        cached=False,
        bdi_runs=3,
        iterations=1,
        converged_at=None,
        q_delta=(),
        distinct_texts=6,
        reward="",
        diagnosis=diagnosis,
        notes=(),
    )
    return derive(
        Report(
            schema=SCHEMA,
            version="0.1.0",
            testbench="toy",
            selected=0,
            reported=0,
            not_run=0,
            not_run_tests=(),
            wall_s=wall_s,
            workers=1,
            known_violations={"R2": "no brakes"},
            known_until={},
            strict=False,
            shard=shard,
            state="",
            rerun_options=RerunOptions(suite="rl", options=()),
            requirements={name: RequirementText(title=name, source="", text="") for name in ("R1", "R2")},
            code_under_test=CODE,
            models={"human": ModelSource(file="human.asl", source="@p +!g.", plans={"p": 1})},
            cross_products=PRODUCTS,
            exploration=ExplorationRecord(),
            suites=(declare_suite("rl", 0, SIZE, generation, {"human": ("p", "q", "r")}),),
            closure=NO_CLOSURE,
            tests=tuple(tests),
        )
    )


def verdict(outcome: Literal["Passed", "Failed", "NC"]) -> RequirementResult:
    """A verdict and its counts."""
    triggers, passes, failures, vacuous = {"Passed": (1, 1, 0, 0), "Failed": (2, 1, 1, 0), "NC": (0, 0, 0, 1)}[outcome]
    return RequirementResult(
        verdict=outcome,
        triggers=triggers,
        passes=passes,
        failures=failures,
        untriggered=vacuous,
        pending=0,
        violations=(),
        margin=None,
    )


def result(number: int, **changes: Any) -> TestResult:
    """The test of this number; not run, unless `changes` say otherwise."""
    fields: dict[str, Any] = {
        "nodeid": f"test_toy.py::test_toy[rl-leg{number}]",
        "suite": "rl",
        "id": f"rl-leg{number}",
        "target": f"leg{number}",
        "name": "",
        "beliefs": (f"leg{number}",),
        "abstract": ("wave",) * number,
        "concrete": ConcreteParameters(actions=(), run={}),
        "seed": number,
        "outcome": "not-run",
        "wall_s": 0.0,
        "sim_s": 0.0,
        "skipped_s": 0.0,
        "fidelity": "",
        "end_reason": "",
        "outcomes": (),
        "plans": {},
        "code": None,
        "timeline": None,
        "requirements": {"R1": verdict("NC"), "R2": verdict("NC")},
        "failure": "",
        "unmeasured": "",
    }
    return TestResult(**(fields | changes))


@st.composite
def tests(draw: st.DrawFn, number: int) -> TestResult:
    """The test of this number: run, and perhaps measured; or not run."""
    if draw(st.booleans()) and draw(st.booleans()):
        return result(number, failure=draw(st.sampled_from(["", "crashed"])))
    # A run is determined by its record: two runs with equal records are equal in all but time and measurement.
    run = draw(st.integers(0, 2))
    bits = Bits((number * 7 + run * 3) % 8 | 8, draw(st.sampled_from([None, number % 4, number % 4])))
    measured = bits.share(STATEMENTS)
    outcome = ("passed", "known-violation", "failed")[run]
    return result(
        number,
        outcome=outcome,
        wall_s=draw(st.sampled_from([0.25, 0.5, 1.0])),
        sim_s=10.0 * number + run,
        end_reason="done",
        record_sha256=f"{number}-{run}",
        outcomes=("kept",),
        cross={"turn": (("1", "kept"), ("2", "given"))[: run + 1]},
        plans={"human": ("p", "q")[: 1 + number % 2]},
        code=draw(st.sampled_from([None, measured, measured])),
        requirements={
            "R1": verdict("Failed" if outcome == "failed" else "Passed"),
            "R2": verdict("NC" if outcome == "passed" else "Failed"),
        },
        failure=draw(st.sampled_from(["", "E  it failed"])),
    )


@st.composite
def reports(draw: st.DrawFn) -> Report:
    """A report of some of the tests, of a separate session."""
    numbers = draw(st.sets(st.integers(1, SIZE), max_size=4))
    shard = draw(st.sampled_from(["", "1/3", "2/3"]))
    return report([draw(tests(number)) for number in sorted(numbers)], draw(st.sampled_from([1.0, 2.5, 0.1])), shard)
