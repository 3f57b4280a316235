"""Commands, actions, and abstract tests as data, with ids and seeds from their content."""

from __future__ import annotations

import re
from collections.abc import Callable

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
from tests.generate.strategies import commands, words


@pytest.mark.parametrize(
    ("action", "command"),
    [
        ("tell(leg)", "tell leg"),
        ("receivesignal", "receivesignal"),
        ("set_param(gaze, 1)", "set_param gaze = 1"),
        ("set_param(gaze,1)", "set_param gaze = 1"),
        ("tell( humanReady )", "tell humanReady"),
    ],
)
def test_the_command_of_an_action(action: str, command: str) -> None:
    assert command_from_action(action) == command


@given(commands)
def test_every_command_is_that_of_an_action(command: str) -> None:
    name, *arguments = command.replace(" = ", " ").split()
    action = f"{name}({', '.join(arguments)})" if arguments else name
    assert command_from_action(action) == command


@given(commands)
def test_a_command_has_one_canonical_spelling(command: str) -> None:
    assert canonical_command(f"  {command.replace(' = ', '=')}\t") == command == canonical_command(command)


@pytest.mark.parametrize("action", ["go(a,b,c)", "say(hello(world))", 'say("hi")', "go(", "go)", "", "go()"])
def test_an_action_without_a_text_form_is_an_error(action: str) -> None:
    with pytest.raises(GenerateError, match="has no text form; expected a name with at most two arguments"):
        command_from_action(action)


@pytest.mark.parametrize("text", ["", "tell leg now", "set_param gaze =", "= 1", "tell(leg)", "1", "tell leg;"])
def test_other_text_is_no_command(text: str) -> None:
    with pytest.raises(GenerateError, match="is not a command"):
        canonical_command(text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"id": "a.b"}, "expected letters"),
        ({"id": ""}, "expected letters"),
        ({"seed": -1}, "out of range"),
        ({"seed": 2**63}, "out of range"),
        ({"name": "two\nlines"}, "one line"),
        ({"suite": ""}, "suite name '': expected letters"),
        ({"suite": "../../escaped"}, "suite name '../../escaped': expected letters"),
        ({"suite": "a" * 101}, "at most 100"),
        ({"target": ""}, "one line"),
        ({"beliefs": ("leg 1",)}, "one word"),
        ({"plans": {"human": ("a b",)}}, "one word"),
        ({"lines": ("set_param gaze=1",)}, "expected the spelling 'set_param gaze = 1'"),
        ({"values": {1: {"x_m": 1.0}}}, "test a: values of command 1: the test has 0 commands only"),
        ({"values": {-1: {"x_m": 1.0}}}, "values of command -1"),
        ({"values": {0: {}}}, "values of the run: there are none; expected at least one"),
        ({"values": {0: {"x m": 1.0}}}, "parameter 'x m': expected one word without a comma"),
        ({"values": {0: {"x_m": True}}}, "x_m is True; expected a finite number"),
        ({"values": {0: {"x_m": float("nan")}}}, "x_m is nan; expected a finite number"),
    ],
)
def test_a_test_without_a_text_form_is_an_error(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"id": "a", "suite": "s", "target": "x", "beliefs": (), "lines": ()}
    with pytest.raises(GenerateError, match=message):
        AbstractTest(**{**good, **change})  # type: ignore[arg-type]


drafts = st.builds(
    AbstractDraft,
    target=st.text(max_size=10).map(lambda text: " ".join(text.split()) or "x"),
    beliefs=st.lists(words, max_size=3).map(tuple),
    lines=st.lists(commands, max_size=3).map(tuple),
)
BY_CONTENT: Callable[[AbstractDraft], object] = lambda draft: (draft.beliefs, draft.lines)  # noqa: E731


def test_ids_and_seeds_are_those_of_earlier_versions() -> None:
    """If this fails, every id and recorded seed has changed: raise GENERATOR_VERSION and note it in the changelog."""
    (test,) = identify("by-hand", 0, [AbstractDraft("leg4", ("leg4", "m111l4"), ("tell leg", "receivesignal"))])
    assert (test.id, test.seed) == ("by-hand-leg4-5444b870", 8698345077810159687)


@given(st.lists(drafts, max_size=6), st.integers(0, 99))
def test_ids_are_distinct_and_fit_for_a_command_line(listed: list[AbstractDraft], seed: int) -> None:
    tests = identify("some-suite", seed, listed)
    assert len({test.id for test in tests}) == len(listed)
    assert all(re.fullmatch(r"some-suite-[A-Za-z0-9_-]+-[0-9a-f]{8}", test.id) for test in tests)
    assert all(0 <= test.seed < 2**63 for test in tests)


@given(st.lists(drafts, max_size=6, unique_by=BY_CONTENT), st.randoms())
def test_ids_do_not_depend_on_the_order(listed: list[AbstractDraft], random: object) -> None:
    mixed = list(listed)
    random.shuffle(mixed)  # type: ignore[attr-defined]
    assert set(identify("s", 1, mixed)) == set(identify("s", 1, listed))


def test_chosen_values_distinguish_drafts_but_keep_the_seed() -> None:
    drafts = [
        AbstractDraft("a", (), ("go",), values=values)
        for values in ({}, {1: {"x_m": 1}}, {1: {"x_m": 2}}, {0: {"x_m": 1}})
    ]
    tests = identify("s", 0, drafts)
    assert len({test.id for test in tests}) == 4
    assert len({test.seed for test in tests}) == 1
    assert [test.values for test in tests] == [draft.values for draft in drafts]
    assert identify("s", 0, [AbstractDraft("a", (), ("go",), values={1: {"x_m": 1.0}})])[0].id == tests[1].id
    first, second = identify("s", 0, [drafts[1]] * 2)
    assert first == tests[1]
    assert first.seed != second.seed
