"""Files of abstract tests."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.text_format import dump_tests, parse_tests
from tests.generate.strategies import abstract_tests
from tests.generate.table import COMMANDS

TWO = """\
# Recorded on the second day; this block is commentary only.
# name: not a test

# name: a greeting
tell leg
  receivesignal   # and wait

set_param gaze=1
bored
"""


@given(st.lists(abstract_tests, max_size=4, unique_by=lambda test: test.id))
def test_written_tests_read_back_unchanged(tests: list[AbstractTest]) -> None:
    assert list(parse_tests(dump_tests(tests), file="f", suite="other", master_seed=7)) == tests


def test_plain_texts_get_ids_from_their_content() -> None:
    greeting, second = parse_tests(TWO, file="two.txt", suite="two", known=COMMANDS)
    assert greeting.lines == ("tell leg", "receivesignal")
    assert greeting.name == "a greeting"
    assert re.fullmatch(r"two-a-greeting-[0-9a-f]{8}", greeting.id)
    assert second.lines == ("set_param gaze = 1", "bored")
    assert re.fullmatch(r"two-2-actions-[0-9a-f]{8}", second.id)


def test_a_test_without_commands_has_an_id() -> None:
    (test,) = parse_tests("# id: x\n# suite: s\n# aim: a\n# seed: 5\n", file="f", suite="other")
    assert test == AbstractTest(id="x", suite="s", target="a", beliefs=(), lines=(), seed=5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tell leg\n\n  tell legs\n", "f.txt:3:3: unknown command 'tell legs'; nearest: tell leg"),
        ("tell leg now\n", "f.txt:1:1: 'tell leg now' is no command; expected .*; nearest: tell leg"),
        ("set_param gaze == 1\n", "f.txt:1:1: 'set_param gaze == 1' is no command.*nearest: set_param gaze = "),
        ("# seed: soon\nbored\n", "f.txt:1:1: seed 'soon': expected a whole number"),
        ("# aim: a\n# aim: b\nbored\n", "f.txt:2:1: a second '# aim:' in one test"),
        ("# id: x\n# suite: s\n# aim: a\nbored\n", "f.txt:1:1: test 'x' has an id but no seed"),
        (
            "# id: x\n# suite: s\n# aim: a\n# seed: 1\nbored\n\n\n# id: x\n# suite: s\n# aim: a\n# seed: 2\n",
            "f.txt:8:1: a second test with the id 'x', which is at f.txt:1:1 already; expected each id once",
        ),
        ("# id: x.y\n# suite: s\n# aim: a\n# seed: 1\nbored\n", "f.txt:1:1: test id 'x.y': expected letters"),
    ],
)
def test_errors_name_file_line_and_column(text: str, message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        parse_tests(text, file="f.txt", suite="f", known=COMMANDS)
