"""Shrinking on the table: a failure of a whole assembly comes down to the one thing that the person has to do."""

from __future__ import annotations

import pytest

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.failure_signature import failure_signature, has_signature
from pytest_hricdv.experiments.shrink import shrink
from pytest_hricdv.generate.concrete import ConcreteTest
from tests.hri import bench

CRUSHED = "rl-leg1-0e72cf23"


@pytest.mark.slow
def test_a_crushed_hand_in_a_table_of_four_legs_takes_no_more_than_asking_for_one() -> None:
    (test,) = [each for each in bench.suite("rl") if each.id == CRUSHED]
    assert [action.command for action in test.actions].count("tell leg") == 4
    (requirement,) = [each for each in bench.requirements() if each.id == "R3"]
    verdict = bench.run(test).verdict("R3")
    wanted = failure_signature(requirement, verdict, verdict.violations[0])

    def fails(candidate: ConcreteTest) -> bool:
        return has_signature(requirement, wanted, bench.run(candidate).verdict("R3"))

    found = shrink(test, bench.testbench().concretization, fails, Budget(runs=60))
    assert found.ended == "done"
    (asked,) = found.test.actions
    assert asked.command == "tell leg"
    assert (asked.parameters["voice_s"], dict(found.test.run)) == (4.0, {"sensing_timeout_s": 55.0, "outage_turn": 0.0})
