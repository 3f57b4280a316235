"""Commands, actions, and abstract tests as data."""

from __future__ import annotations

import pytest
from hypothesis import given

from pytest_hricdv.generate.abstract import AbstractTest, action_from_command, command_from_action, command_of
from pytest_hricdv.generate.error import GenerateError
from tests.generate.strategies import commands


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
def test_an_action_and_its_command(action: str, command: str) -> None:
    assert command_from_action(action) == command
    assert command_from_action(action_from_command(command)) == command


@given(commands)
def test_command_to_action_and_back(command: str) -> None:
    assert command_from_action(action_from_command(command)) == command


@given(commands)
def test_a_command_has_one_spelling(command: str) -> None:
    assert command_of(f"  {command.replace(' = ', '=')}\t") == command == command_of(command)


@pytest.mark.parametrize("action", ["go(a,b,c)", "say(hello(world))", 'say("hi")', "go(", "go)", "", "go()"])
def test_an_action_without_a_text_form_is_an_error(action: str) -> None:
    with pytest.raises(GenerateError, match="has no text form; expected a name with at most two arguments"):
        command_from_action(action)


@pytest.mark.parametrize("text", ["", "tell leg now", "set_param gaze =", "= 1", "tell(leg)", "1", "tell leg;"])
def test_what_is_no_command_is_an_error(text: str) -> None:
    with pytest.raises(GenerateError, match="is no command"):
        command_of(text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"id": "a.b"}, "expected letters"),
        ({"id": ""}, "expected letters"),
        ({"seed": -1}, "out of range"),
        ({"seed": 2**63}, "out of range"),
        ({"name": "two\nlines"}, "one line"),
        ({"suite": ""}, "one line"),
        ({"beliefs": ("leg 1",)}, "one word"),
        ({"plans": {"human": ("a b",)}}, "one word"),
        ({"lines": ("set_param gaze=1",)}, "expected the spelling 'set_param gaze = 1'"),
    ],
)
def test_a_test_that_could_not_be_written_down_is_an_error(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"id": "a", "suite": "s", "aim": "x", "beliefs": (), "lines": ()}
    with pytest.raises(GenerateError, match=message):
        AbstractTest(**{**good, **change})  # type: ignore[arg-type]
