"""An agent that is ready for many acts at a time: what is expected of the run stays right, and costs no more."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.bdi.agent.intentions import Intention
from pytest_hricdv.coupling.ready_acts import ReadyAct, ReadyActs
from pytest_hricdv.declarations.model_oracle import ActionMapping
from pytest_hricdv.extra.oracle.conformance_monitor import ConformanceMonitor
from tests.extra.oracle.toy import TOY, Toy, violation
from tests.steps import steps_of

TAKES = """
@fetch  +wanted(Thing)[source(person)] <- -wanted(Thing)[source(person)]; take(Thing).
"""


def taking(folder: Path) -> Toy:
    """A robot that takes whatever is ordered, within 100 s."""
    does = (ActionMapping("take(Thing)", "on(taken)", within_s=(0.0, 100.0)),)
    return Toy(folder, TAKES, percepts=TOY.percepts[:1], actions=does, limits={})


def test_the_act_that_is_ready_longest_is_the_one_that_is_observed_and_that_is_due(tmp_path: Path) -> None:
    orders = [(float(number), "order", {"thing": "cup" if number % 2 else "plate"}) for number in range(1, 41)]
    taken = [(50.0 + number, "taken", {"thing": "plate"}) for number in range(20)]
    verdict = taking(tmp_path).follow(*orders, *taken, end_s=200.0)
    plates = [(2.0 * number + 2.0, 50.0 + number) for number in range(20)]
    assert [(act.begin_s, act.end_s) for act in verdict.history if act.outcome == "passed"] == plates
    assert violation(verdict).startswith("101 s: expected take(cup) within 100 s of 1.0 s")


def test_an_event_takes_as_many_steps_with_many_open_acts_as_with_few(tmp_path: Path) -> None:
    monitor = ConformanceMonitor(taking(tmp_path).oracle, {})
    fields = {"thing": "cup"}
    steps = [steps_of(partial(monitor.message, number / 50, "order", fields)) for number in range(1, 600)]
    assert max(steps[500:]) <= 1.5 * max(steps[50:80])
    steps = [steps_of(partial(monitor.message, 13 + number / 50, "taken", fields)) for number in range(500)]
    assert max(steps[:50]) <= 1.5 * max(steps[450:])
    verdict = monitor.finish(50.0)
    assert (verdict.verdict, verdict.passes, verdict.pending) == ("Passed", 500, 99)


def act(kind: tuple[int, ...], text: str) -> ReadyAct:
    """An act."""
    return ReadyAct(text, None, "", 0.0, Intention(0), kind)


kinds = st.sampled_from([(0,), (1,), (0, 1), (2,)])
steps = st.lists(st.one_of(st.tuples(kinds, st.sampled_from("abc")), st.integers(0, 9)), max_size=40)


@given(steps=steps, numbers=st.sets(st.integers(0, 2)))
def test_open_acts_are_those_of_a_list(steps: list[tuple[tuple[int, ...], str] | int], numbers: set[int]) -> None:
    """With a number, the act at that place is removed; else one is added."""
    acts, in_order = ReadyActs(), list[ReadyAct]()
    for step in steps:
        if isinstance(step, int):
            for removed in in_order[step : step + 1]:
                acts.remove(removed)
                in_order.remove(removed)
        else:
            in_order.append(act(*step))
            acts.add(in_order[-1])
        assert list(acts) == in_order
        by_text = {(open_act.acts, open_act.text): open_act for open_act in reversed(in_order)}
        first = [open_act for open_act in in_order if open_act in by_text.values() and numbers & {*open_act.acts}]
        assert list(acts.different(numbers)) == first
        by_kind = {open_act.acts: open_act for open_act in reversed(in_order)}
        assert acts.longest_ready() == [open_act for open_act in in_order if open_act in by_kind.values()]
        assert len(acts) == len(in_order)
