"""Commands, actions, and abstract tests as data."""

from __future__ import annotations

import pytest
from hypothesis import given

from pytest_hricdv.generate.abstract import AbstractTest, canonical_command, command_from_action
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
    with pytest.raises(GenerateError, match="is no command"):
        canonical_command(text)


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
def test_a_test_without_a_text_form_is_an_error(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"id": "a", "suite": "s", "target": "x", "beliefs": (), "lines": ()}
    with pytest.raises(GenerateError, match=message):
        AbstractTest(**{**good, **change})  # type: ignore[arg-type]
