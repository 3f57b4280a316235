"""The models of the table assembly: the abstract tests they give, their coverage plans, and that they end."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.bdi.models import LEG_STARTS, POSES, abstract_test, labels, run_table, table

# Belief sets run on the original models with Jason 1.4.2; "ended" is false where those never ended.
RUNS: list[dict[str, Any]] = [
    json.loads(line) for line in (Path(__file__).parent / "data" / "table_runs.jsonl").read_text().splitlines()
]
subsets = st.builds(
    lambda start, others: [start, *others],
    st.sampled_from(LEG_STARTS),
    st.lists(st.sampled_from(("bored", "not_bored", *POSES)), unique=True, max_size=12),
)


@pytest.mark.parametrize("run", [run for run in RUNS if run["ended"]], ids=lambda run: "-".join(run["beliefs"]))
def test_ended_reference_runs_are_reproduced(run: dict[str, Any]) -> None:
    result = run_table(run["beliefs"])
    assert abstract_test(result) == run["abstract"]
    assert sorted(set(labels(result, "human"))) == run["plans"]
    assert result.ended == "idle"
    assert result.warnings == []


@pytest.mark.parametrize("run", [run for run in RUNS if not run["ended"]], ids=lambda run: "-".join(run["beliefs"]))
def test_reference_runs_that_never_ended_go_on_from_there_and_end(run: dict[str, Any]) -> None:
    result = run_table(run["beliefs"])
    assert abstract_test(result)[: len(run["abstract"])] == run["abstract"]
    assert result.ended == "idle"


def test_every_coverage_plan_of_human_and_robot_is_reachable() -> None:
    sets = [["leg1", *(f"m{pose:03b}l{leg}" for leg in range(1, 5))] for pose in range(8)]
    sets += [["leg1", "bored"]]
    human: set[str] = set()
    robot: set[str] = set()
    for beliefs in sets:
        result = run_table(beliefs)
        human.update(labels(result, "human"))
        robot.update(labels(result, "robot_code"))
    assert human == set(table().plan_labels("human"))
    assert robot == set(table().plan_labels("robot_code"))


@given(subsets, st.randoms(use_true_random=False))
def test_any_subset_ends_by_itself_and_does_not_depend_on_the_order(beliefs: list[str], random: Any) -> None:
    result = run_table(beliefs)
    assert result.ended in ("idle", "spin")
    assert result.rounds < 400
    assert result.warnings == []
    assert run_table(beliefs) == result
    shuffled = list(beliefs)
    random.shuffle(shuffled)
    again = run_table(shuffled)
    assert (again.actions, again.plans, again.rounds) == (result.actions, result.plans, result.rounds)


@given(st.sampled_from((1, 2, 3, 4)), st.lists(st.integers(0, 7), min_size=4, max_size=4), st.booleans())
def test_robot_serves_every_request_and_counts_its_turns(start: int, poses: list[int], bored: bool) -> None:
    beliefs = [f"leg{start}", *(f"m{pose:03b}l{leg}" for leg, pose in enumerate(poses, start=1))]
    result = run_table([*beliefs, "bored"] if bored else beliefs)
    requests = abstract_test(result).count("tell leg")
    robot = labels(result, "robot_code")
    assert requests == 5 - start + bored
    assert robot.count("p2") == robot.count("p11") == requests
    assert robot.count("p1") == 1 + requests // 4
    assert robot.count("p10") == poses[start - 1 :].count(7)
