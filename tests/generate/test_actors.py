"""Tests with several actors: lines that say who acts, lanes, causes, interleavings; with one, nothing has changed."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import (
    AbstractDraft,
    AbstractTest,
    canonical_command,
    command_from_action,
    identify,
)
from pytest_hricdv.generate.actors import TURN, TURN_WAIT_S, actor_of, interleave
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, abstract_from, concretize
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import METHODS
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.sampler import Constant, Uniform
from pytest_hricdv.generate.suite_files import dump_tests, parse_tests

LINES = ("nurse: call", "child: run fast", "nurse: set_lift floor = 2", "child: stop")
SPACE = Concretization({line: {"after_s": Uniform(0.0, 1.0, "s")} for line in LINES}).with_turns(("nurse", "child"))


def test_who_acts_is_part_of_a_command() -> None:
    assert canonical_command(" nurse :set_lift floor=2 ") == "nurse: set_lift floor = 2"
    assert command_from_action("set_lift(floor, 2)", "nurse") == "nurse: set_lift floor = 2"


def drafted(after: dict[int, tuple[int, ...]]) -> AbstractTest:
    (made,) = identify("s", 1, [AbstractDraft("t", (), LINES, after=after)])
    return made


def test_what_comes_after_what_is_part_of_the_id_and_of_the_text() -> None:
    free, ordered = drafted({}), drafted({4: (1,)})
    assert free.id != ordered.id
    assert "# after 4: 1\n" in dump_tests([ordered])
    assert parse_tests(dump_tests([free, ordered]), file="f", suite="s") == (free, ordered)
    assert AbstractTest.from_data(ordered.to_data()) == ordered
    assert "after" not in free.to_data()


@pytest.mark.parametrize(
    ("header", "complaint"),
    [
        ("# after 4: 9", "f:1:1: after 4: 9 is not an action of an actor; expected its number, from 1"),
        ("# after 2: 3", "f:1:1: after 2: 3 comes later in the text; expected actions above it"),
        ("# after 3: 1", "f:1:1: after 3: 1 is an action of nurse, too, and in order; expected of others"),
        ("# after 4: first", "f:1:1: after: 'first'; expected the number of an action, from 1"),
        ("# after 4:", "f:1:1: after 4: nothing; expected at least one action, or no entry"),
        ("# after 0: 1", "f:1:1: after: '0'; expected the number of an action, from 1"),
    ],
)
def test_an_order_that_cannot_be_is_refused_with_its_place(header: str, complaint: str) -> None:
    with pytest.raises(GenerateError) as refused:
        parse_tests("\n".join([header, *LINES]), file="f", suite="s")
    assert str(refused.value) == complaint


def test_a_turn_is_drawn_for_each_action_and_a_wait_for_the_run() -> None:
    test = concretize(drafted({4: (1,)}), SPACE)
    assert all(set(action.parameters) == {"after_s", TURN} for action in test.actions)
    assert set(test.run) == {TURN_WAIT_S}
    assert test.after == {4: (1,)}
    assert ConcreteTest.from_json(test.to_json()) == test
    again = abstract_from(test, "again")
    assert concretize(again, SPACE).actions == test.actions
    assert again.after == {4: (1,)}


MANY = st.lists(st.sampled_from(["a: x", "b: x", "c: x", "disturb slip"]), max_size=12)


@given(lines=MANY, data=st.data())
def test_an_interleaving_keeps_lanes_and_causes(lines: list[str], data: st.DataObject) -> None:
    turns = data.draw(st.lists(st.floats(0, 1), min_size=len(lines), max_size=len(lines)))
    after: dict[int, tuple[int, ...]] = {}
    for number, line in enumerate(lines, 1):
        others = [n for n in range(1, number) if actor_of(lines[n - 1]) not in ("", actor_of(line))]
        if others and actor_of(line) and data.draw(st.booleans()):
            after[number] = (data.draw(st.sampled_from(others)),)
    order = interleave(lines, turns, after)
    assert sorted(order) == [number for number, line in enumerate(lines, 1) if actor_of(line)]
    for actor in "abc":
        lane = [number for number in order if actor_of(lines[number - 1]) == actor]
        assert all(before < number for before, number in pairwise(lane))
    assert all(order.index(cause) < order.index(number) for number, causes in after.items() for cause in causes)
    assert interleave(lines, [0.5] * len(lines), after) == tuple(sorted(order)), "equal turns: the text's order"


def test_a_command_that_does_not_say_who_does_it_is_refused() -> None:
    with pytest.raises(GenerateError, match=r"of 'call': who does it\? Expected 'nurse: call' or 'child: call'"):
        Concretization({"call": {}}).with_turns(("nurse", "child"))


@pytest.mark.parametrize("name", [TURN, TURN_WAIT_S])
def test_the_names_of_turns_are_taken(name: str) -> None:
    own = {name: Constant(1.0)}
    space = Concretization({"nurse: call": own if name == TURN else {}}, own)
    with pytest.raises(GenerateError, match=f"{name!r} is the name of a parameter of tests with several actors"):
        space.with_turns(("nurse",))


@pytest.mark.parametrize("actors", ["nurse", ("nurse", "nurse"), ("Nurse",), ("the nurse", "child")])
def test_actors_are_names_of_agents(actors: tuple[str, ...]) -> None:
    with pytest.raises(GenerateError, match="actors = "):
        Model(Path("m.mas2j"), actors=actors)


def test_a_pseudorandom_test_has_a_sequence_of_each_actor() -> None:
    suite = METHODS["pseudorandom"].generate(GenerationContext(commands=LINES, tests=30, lengths=(2, 5)))
    for test in suite.tests:
        for actor in ("nurse", "child"):
            assert 2 <= sum(actor_of(line) == actor for line in test.lines) <= 5
    assert len({test.lines for test in suite.tests}) > 20
