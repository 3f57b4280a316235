"""Decision points and their archive: pure data, without runs."""

from __future__ import annotations

import math
from array import array
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from random import Random

import pytest

from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.extra.closing.decision_points import (
    Cell,
    CellArchive,
    DecisionPoint,
    Neighbourhood,
    cell_of,
    decision_points,
)
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import weighted
from pytest_hricdv.monitor.verdict import Trigger, Verdict
from pytest_hricdv.runtime import Record, RecordedMessage
from pytest_hricdv.testbench import Outcome


def _planned(lines: Sequence[str]) -> list[Bin]:
    """An interaction begins with `ask`; it is planned to be quick unless the person waits."""
    begins = [place for place, line in enumerate(lines) if line == "ask"]
    parts = [lines[begin:end] for begin, end in pairwise([*begins, len(lines)])]
    return [(str(len(parts)), "slow" if "wait" in part else "quick") for part in parts]


CROSS = {
    "handover": CrossProduct(
        {"asked": ("1", "2"), "pace": ("quick", "slow"), "outcome": ("given", "kept")}, planned=_planned
    ),
    "decision": CrossProduct({"outcome": ("given", "kept")}),
}


def cell(
    state: str = "Idle", interaction: int = 1, planned: Bin = ("1", "quick"), awaited: tuple[str, ...] = ()
) -> Cell:
    return Cell(state, interaction, (("handover", planned),), awaited)


def _verdict(requirement: str, *triggers: tuple[float, float]) -> Verdict:
    history = tuple(Trigger(begin_s, end_s, "passed") for begin_s, end_s in triggers)
    return Verdict(
        requirement=requirement,
        verdict="Passed",
        triggers=len(history),
        passes=len(history),
        failures=0,
        vacuous=0,
        pending=0,
        violations=(),
        margin=None,
        margin_time_s=None,
        history=history,
    )


def test_a_decision_point_has_the_state_and_the_open_triggers_of_its_time() -> None:
    states = [(0.0, "Idle"), (2.0, "Fetch"), (2.5, "Offer"), (7.0, "Idle")]
    messages = [RecordedMessage(time_s, "robot", "state", {"name": name}) for time_s, name in states]
    messages.insert(2, RecordedMessage(2.1, "robot", "leg_ready", {"turn": 1}))
    result = CaseResult(
        test=ConcreteTest("t", "s", 1, ()),
        outcome=Outcome("done"),
        record=Record(tuple(messages), {"held": (array("d"), array("d"))}, "hash"),
        sim_s=9.0,
        verdicts=(_verdict("R2", (2.0, 6.0)), _verdict("R1", (1.0, 2.5), (2.5, 3.0))),
        code=None,
        acted_s=(0.0, 2.5, 6.0),
    )
    assert decision_points(result, "state.name") == (
        DecisionPoint(0, 0.0, "Idle"),
        DecisionPoint(1, 2.5, "Offer", ("R1", "R2")),
        DecisionPoint(2, 6.0, "Offer"),
    )
    assert [point.state for point in decision_points(result)] == ["", "", ""]


@pytest.mark.parametrize(
    ("taken", "interaction", "planned"),
    [
        (0, 0, ()),
        (1, 1, (("handover", ("1", "quick")),)),
        (2, 1, (("handover", ("1", "slow")),)),
        (3, 2, (("handover", ("2", "quick")),)),
    ],
)
def test_a_cell_has_what_the_present_interaction_plans_up_to_now(
    taken: int, interaction: int, planned: tuple[tuple[str, Bin], ...]
) -> None:
    lines = ("ask", "wait", "ask", "wait")
    assert cell_of(DecisionPoint(taken, 1.0, "Offer"), lines, CROSS) == Cell("Offer", interaction, planned, ())


def test_without_cross_products_and_a_state_all_is_one_cell() -> None:
    assert {cell_of(DecisionPoint(taken, 1.0), ("ask", "wait"), {}) for taken in range(3)} == {Cell("", 0, (), ())}


def test_open_points_are_near_to_a_state_a_plan_and_an_open_trigger() -> None:
    near = Neighbourhood(
        [
            ("transition", "Idle", "Fetch"),
            ("transition", "Fetch", "Idle"),
            ("bin", "handover", "1", "quick", "given"),
            ("bin", "handover", "2", "quick", "given"),
            ("bin", "handover", "2", "slow", "given"),
            ("bin", "decision", "kept"),
            ("verdict", "R1", "Passed"),
            ("antecedent", "R2", "true"),
            ("statement", "robot.py", "3"),
        ]
    )
    assert near.size(cell()) == 3, "the step, the planned bin, and one that differs in one coordinate"
    assert near.size(cell(state="Fetch", planned=("2", "slow"))) == 3
    assert near.size(cell(state="Offer", awaited=("R1", "R2"))) == 4
    assert near.size(Cell("Offer", 0, (), ())) == 0


def test_the_archive_keeps_the_earliest_way_to_a_cell_and_counts_a_run_once() -> None:
    archive = CellArchive()
    idle, offer = cell(), cell("Offer")
    archive.add(0, [(idle, DecisionPoint(0, 0.0)), (offer, DecisionPoint(1, 5.0)), (offer, DecisionPoint(2, 6.0))])
    archive.add(1, [(idle, DecisionPoint(0, 0.0)), (offer, DecisionPoint(2, 4.0))])
    archive.add(2, [(offer, DecisionPoint(1, 4.0))])
    way = archive.cells[offer]
    assert (way.visits, way.run, way.taken, way.time_s) == (3, 1, 2, 4.0)
    way = archive.cells[idle]
    assert (way.visits, way.run, way.taken) == (2, 0, 0)


def test_a_cell_weighs_more_with_open_points_near_and_less_with_visits() -> None:
    archive = CellArchive()
    rare, common, lonely = cell(), cell("Offer"), cell("Rest", planned=("2", "slow"))
    for run in range(8):
        archive.add(run, [(common, DecisionPoint(1, 1.0))])
    archive.add(8, [(rare, DecisionPoint(1, 1.0)), (lonely, DecisionPoint(2, 2.0))])
    near = Neighbourhood([("bin", "handover", "1", "quick", outcome) for outcome in ("given", "kept")])
    assert archive.weight(rare, near) == pytest.approx(3 / math.sqrt(2))
    assert archive.weight(common, near) == pytest.approx(3 / math.sqrt(9))
    assert archive.weight(lonely, near) == pytest.approx(1 / math.sqrt(2))


def test_cells_come_without_repetition_in_an_order_from_the_seed_and_their_weights_alone() -> None:
    archive = CellArchive()
    cells = [cell(str(number)) for number in range(20)]
    for number, each in enumerate(cells):
        for _ in range(100 if number < 10 else 1):
            archive.add(number, [(each, DecisionPoint(1, 1.0))])
    chosen = [*archive.choices([], Random(3))]
    assert chosen == [*archive.choices([], Random(3))]
    assert chosen != [*archive.choices([], Random(4))]
    assert sorted(chosen, key=str) == sorted(cells, key=str)
    assert sum(int(each.state) < 10 for each in chosen[:5]) <= 1, "those that many runs came through are late"
    assert [*CellArchive().choices([], Random(1))] == []


def test_what_is_drawn_is_in_proportion_to_its_weight() -> None:
    rng = Random(1)
    found = Counter(weighted(rng, {"never": 0.0, "seldom": 1.0, "often": 3.0}) for _ in range(4000))
    assert found["never"] == 0
    assert found["often"] / found["seldom"] == pytest.approx(3.0, rel=0.15)
