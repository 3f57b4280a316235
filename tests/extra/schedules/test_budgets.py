"""Time budgets: the largest delay with which no requirement breaks."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.schedules.budgets import PRECISION_S, measure_budgets
from pytest_hricdv.extra.schedules.records import BudgetRecord
from pytest_hricdv.extra.schedules.schedule_run import ScheduleRun
from pytest_hricdv.extra.schedules.search import ScheduleCandidate
from pytest_hricdv.extra.schedules.view import MAX_BUDGETS, budget_lines
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization
from pytest_hricdv.generate.schedule import EACH_TIME


def candidate(name: str, *executed: str) -> ScheduleCandidate:
    test = ConcreteTest(name, "suite", 0, ())
    usual = ScheduleRun(violated=("R9",), executed=dict.fromkeys(executed, 3))
    return ScheduleCandidate(f"t.py::{name}", test, Concretization(commands={}), usual)


@given(st.dictionaries(st.sampled_from("abc"), st.floats(0.01, 9.0), min_size=1))
def test_a_budget_is_that_of_the_test_that_breaks_first(limits: dict[str, float]) -> None:
    def run(test: ConcreteTest) -> ScheduleRun:
        (decision,) = test.schedule
        assert (decision.kind, decision.place, decision.occurrence) == ("delay", "arm.py:3", EACH_TIME)
        return ScheduleRun(violated=("R1", "R9") if decision.delay_s > limits[test.id] else ("R9",))

    candidates = [candidate(name, "arm.py:3") for name in limits]
    (budget,) = measure_budgets(run, candidates, {"arm.py:3": "Arm.move", "arm.py:9": "Arm.rest"})
    least_s = min(limits.values())
    assert least_s - PRECISION_S <= budget.budget_s <= least_s + 1e-6
    assert (budget.name, budget.requirement) == ("Arm.move", "R1")
    assert limits[str(budget.test)] - least_s <= PRECISION_S


def test_functions_without_a_budget_are_counted_apart() -> None:
    fails = BudgetRecord(place="arm.py:1", name="move", budget_s=0.1, requirement="R1", test="t")
    broken = [fails] * (MAX_BUDGETS + 2)
    budgets = [*broken, BudgetRecord(place="arm.py:20", name="rest", budget_s=10.0)]
    texts = [line.text for line in budget_lines(budgets, ())]
    assert texts[0] == "time budgets of 15 functions and loops until a requirement breaks:"
    assert texts[-2:] == ["  2 more: see the report", "  1 of them: no requirement breaks up to 10 s"]
