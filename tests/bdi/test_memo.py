"""The memo: agents that are steered, as in learning, do the same on it as on the other engines."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.bdi import MultiAgentSystem
from tests.bdi.generated import PROPOSITIONS, systems
from tests.bdi.models import TABLE, system_of
from tests.bdi.test_engines import BRIEF, ENGINES, LONG, traced

STEER = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B) }; .send(a, achieve, g0); .send(b, tell, p2)."
STEER_TWO = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B); .send(b, tell, B) }; .send(b, achieve, g1)."
STEER_AGAIN = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B) }; .send(a, achieve, g0); .wait(2); !steer."
STEER_BY_VALUE = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B); .print(B) }; .send(a, achieve, g0)."
CHOSEN = st.lists(st.sets(st.sampled_from((*PROPOSITIONS, "other", "p9"))), min_size=2, max_size=6)


def assert_steered_engines_agree(sources: dict[str, str], steer: str, choices: list[set[str]]) -> None:
    with TemporaryDirectory() as folder:
        system_of(Path(folder), **sources, steer=steer)
        systems = [MultiAgentSystem.load(Path(folder) / "mas.mas2j", engine=engine) for engine in ENGINES]
        for chosen in choices:
            percepts = {"steer": [f"chosen({belief})" for belief in sorted(chosen)]}
            for max_rounds in (200, 20):
                expected = traced(systems[0], max_rounds=max_rounds, percepts=percepts)
                for system in systems:
                    assert system.run(max_rounds=max_rounds, percepts=percepts) == expected


STEERS = st.sampled_from([STEER, STEER, STEER_TWO, STEER_AGAIN, STEER_BY_VALUE])


@BRIEF
@given(systems(), STEERS, CHOSEN)
def test_engines_agree_on_made_up_programs_that_are_steered(
    sources: dict[str, str], steer: str, choices: list[set[str]]
) -> None:
    assert_steered_engines_agree(sources, steer, choices)


LOOKS = {
    "test": "+!g0 : p0 <- .print(held). +!g0 <- .print(not_held).",
    "not": "+!g0 : not p0 <- .print(not_held). +!g0 <- .print(held).",
    "known source": "+!g0 : p0[source(steer)] <- .print(held). +!g0 <- .print(not_held).",
    "any source": "+!g0 : p0[source(S)] <- .print(S). +!g0 <- .print(not_held).",
    "condition": "+!g0 <- if (p0) { .print(held) } else { .print(not_held) }; .print(end).",
    "add": "+!g0 <- +p0; +p2; !h. +!h : p0[source(steer)] <- .print(both). +!h <- .print(own).",
    "remove": "+!g0 <- -p0[source(steer)]; +p2; !h. +!h <- .print(end). -p0 <- .print(gone).",
    "replace": "+!g0 <- -+p0; +p2; !h. +!h : p0[source(steer)] <- .print(both). +!h <- .print(own).",
    "abolish": "+!g0 <- .abolish(p0); +p2; !h. +!h <- .print(end). -p0 <- .print(gone).",
}
"""Ways to look at what is forwarded, or to change it."""


@pytest.mark.parametrize("plans", LOOKS.values(), ids=LOOKS.keys())
def test_the_memo_notes_every_way_to_look_at_what_is_forwarded(plans: str) -> None:
    choices: list[set[str]] = [set(), {"p0"}, {"p1"}, {"p0", "p1"}, {"p9"}, {"p0", "p9"}]
    for order in (choices, choices[::-1]):
        assert_steered_engines_agree({"a": plans, "b": "b."}, STEER, order)


@pytest.mark.slow
@LONG
@given(systems(), STEERS, CHOSEN)
def test_engines_agree_on_many_made_up_programs_that_are_steered(
    sources: dict[str, str], steer: str, choices: list[set[str]]
) -> None:
    assert_steered_engines_agree(sources, steer, choices)


def test_engines_agree_on_one_that_spins_through_segments_of_a_run() -> None:
    sources = {"a": "+!g0 : p0 <- +x; +y; .print(a). +!g0.", "b": "!w. +!w : not x <- !w. +!w."}
    assert_steered_engines_agree(sources, STEER, [set(), {"p0"}, {"p1"}, {"p0", "p1"}])


def test_memo_gives_every_caller_lists_of_its_own() -> None:
    system = MultiAgentSystem.load(TABLE, engine="memo")
    first = system.run(percepts={"meta": ["chosen(leg4)"]})
    first.actions.clear()
    first.plans["human"].clear()
    again = system.run(percepts={"meta": ["chosen(leg4)"]})
    assert again.actions
    assert again.plans["human"]
