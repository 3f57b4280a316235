"""Small reports with real figures: closed from tests that Hypothesis makes up."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from pytest_hricdv.closure.closing import close
from pytest_hricdv.cover.listing import list_bits
from pytest_hricdv.cover.source import Bits

Report = dict[str, Any]

CODE = {
    "packages": ["robot"],
    "sha256": "5e" * 32,
    "waivers": [{"file": "robot/b.py", "line": 2, "reason": "the port never closes"}],
    "map": [
        {
            "file": "robot/a.py",
            "statements": [1, 2, 4],
            "branches": [[2, 4], [2, -1]],
            "source": "def f():\n  g()\n\n  h()",
        },
        {"file": "robot/b.py", "statements": [1, 2], "branches": [], "source": "k()\nm()"},
    ],
}
PRODUCTS = {
    "turn": {
        "coordinates": [{"name": "leg", "bins": ["1", "2"]}, {"name": "outcome", "bins": ["kept", "given"]}],
        "impossible": [{"bin": ["2", "kept"], "reason": "?", "by": "declared"}],
        "illegal": [],
        "proof": {},
    }
}
SIZE = 6


def report(tests: list[Report], wall_s: float = 1.0, **more: Any) -> Report:
    """A closed report of some of the six tests of suite `rl`."""
    return close(
        {
            "schema": "hricdv-report/1",
            "version": "0.1.0",
            "testbench": "toy",
            "wall_s": wall_s,
            "workers": 1,
            "known_violations": {"R2": "no brakes"},
            "known_until": {},
            "strict": False,
            "state": "",
            "rerun": {"suite": "rl", "options": []},
            "requirements": {name: {"title": name, "source": "", "text": ""} for name in ("R1", "R2")},
            "code_under_test": CODE,
            "models": {"human": {"file": "human.asl", "source": "@p +!g.", "plans": {"p": 1}}},
            "cross_products": PRODUCTS,
            "suites": [
                {
                    "name": "rl",
                    "seed": 0,
                    "size": SIZE,
                    "generation": {
                        "wall_s": wall_s / 4,
                        "cached": False,
                        "bdi_runs": 3,
                        "iterations": 1,
                        "converged_at": None,
                        "q_delta": [],
                    },
                    "plans": {"human": {"declared": ["p", "q", "r"]}},
                }
            ],
            "tests": tests,
        }
        | more,
        "switched off",
    )


def verdict(outcome: str) -> Report:
    """A verdict and its counts."""
    counts = {"Passed": (1, 1, 0, 0), "Failed": (2, 1, 1, 0), "NC": (0, 0, 0, 1)}[outcome]
    named = dict(zip(("triggers", "passes", "failures", "vacuous"), counts, strict=True))
    return {"verdict": outcome, **named, "pending": 0, "violations": [], "margin": None}


@st.composite
def tests(draw: st.DrawFn, number: int) -> Report:
    """The test of this number: run, and perhaps measured; or not run."""
    fixed = {
        "nodeid": f"test_toy.py::test_toy[rl-leg{number}]",
        "suite": "rl",
        "id": f"rl-leg{number}",
        "aim": f"leg{number}",
        "name": "",
        "beliefs": [f"leg{number}"],
        "abstract": ["wave"] * number,
        "concrete": {"actions": [], "run": {}},
        "seed": number,
        "fidelity": "",
        "unmeasured": "",
    }
    if draw(st.booleans()) and draw(st.booleans()):
        return fixed | {
            "outcome": "not-run",
            "wall_s": 0.0,
            "sim_s": 0.0,
            "frozen_s": 0.0,
            "ended": "",
            "legs": [],
            "plans": {},
            "code": None,
            "requirements": {"R1": verdict("NC"), "R2": verdict("NC")},
            "failure": draw(st.sampled_from(["", "crashed"])),
        }
    # A run is a function of what came about: two runs with equal records are equal in all but time and measurement.
    run = draw(st.integers(0, 2))
    bits = Bits((number * 7 + run * 3) % 8 | 8, draw(st.sampled_from([None, number % 4, number % 4])))
    statements = bits.statements.bit_count()
    measured = {"statements": statements, "percent": 100 * statements / 5, "bits": list_bits(bits)}
    outcome = ("passed", "known-violation", "failed")[run]
    return fixed | {
        "outcome": outcome,
        "wall_s": draw(st.sampled_from([0.25, 0.5, 1.0])),
        "sim_s": 10.0 * number + run,
        "frozen_s": 0.0,
        "ended": "done",
        "record_sha256": f"{number}-{run}",
        "legs": ["kept"],
        "cross": {"turn": [["1", "kept"], ["2", "given"]][: run + 1]},
        "plans": {"human": ["p", "q"][: 1 + number % 2]},
        "code": draw(st.sampled_from([None, measured, measured])),
        "requirements": {
            "R1": verdict("Failed" if outcome == "failed" else "Passed"),
            "R2": verdict("NC" if outcome == "passed" else "Failed"),
        },
        "failure": draw(st.sampled_from(["", "E  it failed"])),
    }


@st.composite
def reports(draw: st.DrawFn) -> Report:
    """A report of some of the tests, of a session of its own."""
    numbers = draw(st.sets(st.integers(1, SIZE), max_size=4))
    shard = draw(st.sampled_from(["", "1/3", "2/3"]))
    more = {"shard": shard} if shard else {}
    return report([draw(tests(number)) for number in sorted(numbers)], draw(st.sampled_from([1.0, 2.5, 0.1])), **more)
