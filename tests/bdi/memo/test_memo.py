"""The memo: runs of agents that are steered, as in learning, have the same results as without it."""

from __future__ import annotations

import random
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.bdi import MultiAgentSystem
from pytest_hricdv.bdi.memo import Memo
from tests.bdi.generated import PROPOSITIONS, systems
from tests.bdi.models import BELIEFS, LEG_STARTS, TABLE, system_of
from tests.bdi.run.test_runs import BRIEF
from tests.bdi.test_programs import PROGRAMS, REFERENCE_PROGRAMS

SPINNING = Path(__file__).parents[3] / "benchmarks" / "spinning" / "spinning.mas2j"

STEER = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B) }; .send(a, achieve, g0); .send(b, tell, p2)."
STEER_TWO = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B); .send(b, tell, B) }; .send(b, achieve, g1)."
STEER_AGAIN = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B) }; .send(a, achieve, g0); .wait(2); !steer."
STEER_BY_VALUE = "!steer. +!steer <- for (chosen(B)) { .send(a, tell, B); .print(B) }; .send(a, achieve, g0)."
CHOSEN = st.lists(st.sets(st.sampled_from((*PROPOSITIONS, "other", "p9"))), min_size=2, max_size=6)


def assert_memo_agrees(system: MultiAgentSystem, choices: Iterable[Iterable[str]]) -> None:
    """Runs on the memo have the results of runs without it, whatever was run before."""
    memo = Memo(system)
    for chosen in choices:
        percepts = {"steer": [f"chosen({belief})" for belief in sorted(chosen)]}
        for max_rounds in (200, 20):
            expected = system.run(max_rounds=max_rounds, percepts=percepts)
            assert memo.run(max_rounds=max_rounds, percepts=percepts) == expected


def assert_memo_agrees_on(sources: dict[str, str], steer: str, choices: list[set[str]]) -> None:
    with TemporaryDirectory() as folder:
        assert_memo_agrees(system_of(Path(folder), **sources, steer=steer), choices)


def random_sets(count: int, seed: int) -> Iterable[list[str]]:
    """Sets of beliefs as methods choose them, and every fifth one without any rule."""
    drawn = random.Random(seed)
    for number in range(count):
        if number % 5:
            yield [drawn.choice(LEG_STARTS), *drawn.sample(BELIEFS[4:], drawn.randint(0, 12))]
        else:
            yield drawn.sample(BELIEFS, drawn.randint(0, len(BELIEFS)))


def assert_memo_agrees_on_model(model: Path, count: int, seed: int) -> None:
    system = MultiAgentSystem.load(model)
    memo = Memo(system)
    for beliefs in random_sets(count, seed):
        percepts = {"meta": [f"chosen({belief})" for belief in beliefs]}
        assert memo.run(percepts=percepts) == system.run(percepts=percepts), beliefs


@pytest.mark.parametrize("model", [TABLE, SPINNING], ids=lambda model: model.stem)
def test_memo_agrees_on_random_beliefs_of_the_table_models(model: Path) -> None:
    assert_memo_agrees_on_model(model, 200, seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("model", [TABLE, SPINNING], ids=lambda model: model.stem)
def test_memo_agrees_on_many_random_beliefs_of_the_table_models(model: Path) -> None:
    assert_memo_agrees_on_model(model, 3000, seed=2)


@pytest.mark.parametrize("max_rounds", [10_000, 31, 7])
@pytest.mark.parametrize("folder", [*PROGRAMS, *REFERENCE_PROGRAMS], ids=lambda folder: folder.name)
def test_memo_agrees_on_whole_programs(folder: Path, max_rounds: int) -> None:
    system = MultiAgentSystem.load(folder / "mas.mas2j")
    memo = Memo(system)
    expected = system.run(max_rounds=max_rounds)
    assert memo.run(max_rounds=max_rounds) == expected
    assert memo.run(max_rounds=max_rounds) == expected


STEERS = st.sampled_from([STEER, STEER, STEER_TWO, STEER_AGAIN, STEER_BY_VALUE])


@pytest.mark.slow
@BRIEF
@given(systems(), STEERS, CHOSEN)
def test_memo_agrees_on_made_up_programs_that_are_steered(
    sources: dict[str, str], steer: str, choices: list[set[str]]
) -> None:
    assert_memo_agrees_on(sources, steer, choices)


NEUTRAL = st.lists(st.sets(st.sampled_from(("p2", "p3", "other", "p9"))), min_size=3, max_size=8)
"""Beliefs that no plan reacts to when they come."""


def without_goals(source: str) -> str:
    """A program that does nothing before it is sent a goal: most of its runs can be reused in part."""
    return "\n".join(line for line in source.splitlines() if not line.startswith("!"))


@pytest.mark.slow
@BRIEF
@given(systems(), STEERS, NEUTRAL)
def test_memo_agrees_on_made_up_programs_that_begin_when_they_are_steered(
    sources: dict[str, str], steer: str, choices: list[set[str]]
) -> None:
    assert_memo_agrees_on({name: without_goals(source) for name, source in sources.items()}, steer, choices)


QUERIES = {
    "test": "+!g0 : p0 <- .print(held). +!g0 <- .print(not_held).",
    "not": "+!g0 : not p0 <- .print(not_held). +!g0 <- .print(held).",
    "known source": "+!g0 : p0[source(steer)] <- .print(held). +!g0 <- .print(not_held).",
    "any source": "+!g0 : p0[source(S)] <- .print(S). +!g0 <- .print(not_held).",
    "annotated": "q(1)[k]. q(2)[m]. +!g0 : q(X)[m] & p0[source(S)] <- .print(X, S). +!g0 : q(X)[m] <- .print(X).",
    "condition": "+!g0 <- if (p0) { .print(held) } else { .print(not_held) }; .print(end).",
    "add": "+!g0 <- +p0; +p2; !h. +!h : p0[source(steer)] <- .print(both). +!h <- .print(own).",
    "remove": "+!g0 <- -p0[source(steer)]; +p2; !h. +!h <- .print(end). -p0 <- .print(gone).",
    "replace": "+!g0 <- -+p0; +p2; !h. +!h : p0[source(steer)] <- .print(both). +!h <- .print(own).",
    "abolish": "+!g0 <- .abolish(p0); +p2; !h. +!h <- .print(end). -p0 <- .print(gone).",
}
"""Ways to query what is forwarded, or to change it."""


@pytest.mark.parametrize("plans", QUERIES.values(), ids=QUERIES.keys())
def test_memo_notes_every_way_to_query_what_is_forwarded(plans: str) -> None:
    choices: list[set[str]] = [set(), {"p0"}, {"p1"}, {"p0", "p1"}, {"p9"}, {"p0", "p9"}]
    for order in (choices, choices[::-1]):
        assert_memo_agrees_on({"a": plans, "b": "b."}, STEER, order)


UNREPEATABLE = {
    "clock": "+!g0 : p0 <- .print(held); system.time < 9. +!g0 <- .wait(1); ?(system.time < 99); .print(no).",
    "chance": "+!g0 <- .random(X); .print(X); !h. +!h : p0 <- .random(X); .print(X). +!h.",
    "new variables": "+!g0 <- +p2; !h(X); .print(X). +!h(X) : p0 <- !k(Y); .print(Y). +!h(X) <- .print(X). +!k(_).",
    "intentions": "+!g0 <- !h. +!h : p0 & .intend(g0) <- .current_intention(I); .print(I). +!h.",
    "plans": '+!g0 : p0 <- .add_plan("+!h <- .print(new)."); !h. +!g0 <- !h. +!h <- .print(old).',
    "questions": "+!g0 <- .send(b, askOne, q(X), A); .print(A); !h. +!h : p0 <- .print(held). +!h.",
    "event awaited": '!g0. +!g0 <- .wait("+p0", 5); .print(come). -!g0 <- .print(never).',
    "condition awaited": "+!g0 <- .wait(p0, 5); .print(held). -!g0 <- .print(never).",
    "rule": "r(X) :- p0 & q(X). q(1). +!g0 : r(X) <- .print(X). +!g0 <- .print(no).",
    "atomic": "@x[atomic] +!g0 <- +p2; !h; .print(end). +!h : p0 <- +p3; .print(h). +!h. +p3 <- .print(p3).",
    "loop": "q(1). q(2). q(3). +!g0 <- for (q(X)) { !h; +p2; -p2; .print(X) }. +!h : p0 <- .print(held). +!h.",
    "failure": "+!g0 <- !h; .print(no). +!h : p0 <- .fail. +!h. -!g0[code(C)] <- .print(C).",
}
"""What other runs cannot rely on, or what makes states hard to compare."""


@pytest.mark.parametrize("plans", UNREPEATABLE.values(), ids=UNREPEATABLE.keys())
def test_memo_agrees_where_runs_are_hard_to_repeat(plans: str) -> None:
    choices: list[set[str]] = [set(), {"p0"}, {"p1"}, {"p0", "p1"}, {"p9"}, {"p0", "p9"}]
    for order in (choices, choices[::-1]):
        assert_memo_agrees_on({"a": plans, "b": "q(7). b."}, STEER, order)
