"""Greedy selection of model runs: which are chosen, and that the heap chooses the same as a plain loop."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.methods import GreedySelector
from pytest_hricdv.generate.model import ModelRun

model_runs = st.lists(
    st.builds(
        lambda name, line, plans, other: ModelRun((name,), (line,), {"a": frozenset(plans), "b": frozenset(other)}),
        st.sampled_from("pqrstu"),
        st.sampled_from(["wave", "leave", "wait"]),
        st.sets(st.sampled_from("12345")),
        st.sets(st.sampled_from("12"), max_size=1),
    ),
    max_size=30,
)


def _chosen_by_plain_loop(rounds: Sequence[tuple[Sequence[ModelRun], int]]) -> list[ModelRun]:
    """The reference: each step compares all remaining candidates."""
    executed: Counter[tuple[str, str]] = Counter()
    chosen: list[ModelRun] = []

    def plans(run: ModelRun) -> list[tuple[str, str]]:
        return [(agent, plan) for agent, own in run.plans.items() for plan in own]

    for candidates, count in rounds:
        left = dict(enumerate(candidates))

        def rank(place: int, left: dict[int, ModelRun] = left) -> tuple[float, bool, int]:
            rarest = min((executed[plan] for plan in plans(left[place])), default=math.inf)
            return rarest, left[place].lines in {each.lines for each in chosen}, place

        for _ in range(min(count, len(candidates))):
            best = left.pop(min(left, key=rank))
            chosen.append(best)
            executed.update(plans(best))
    return chosen


@given(st.lists(st.tuples(model_runs, st.integers(0, 32)), max_size=3))
def test_the_heap_chooses_the_same_as_a_plain_greedy_loop(rounds: list[tuple[list[ModelRun], int]]) -> None:
    selector = GreedySelector()
    for candidates, count in rounds:
        selector.choose(candidates, count)
    # By identity: equal runs at different places are different choices.
    assert [id(each) for each in selector.chosen] == [id(each) for each in _chosen_by_plain_loop(rounds)]
