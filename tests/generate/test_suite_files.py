"""Tests read from files and folders, and their text format."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import Pseudorandom
from pytest_hricdv.generate.suite_files import Files, dump_tests, parse_tests
from tests.generate.strategies import abstract_tests
from tests.generate.table import COMMANDS


@given(st.lists(abstract_tests, max_size=4, unique_by=lambda test: test.id))
def test_written_tests_read_back_unchanged(tests: list[AbstractTest]) -> None:
    assert list(parse_tests(dump_tests(tests), file="f", suite="other", master_seed=7)) == tests


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tell leg\n\n  tell legs\n", "f.txt:3:3: unknown command 'tell legs'; nearest: tell leg"),
        ("tell leg now\n", "f.txt:1:1: 'tell leg now' is not a command; expected .*; nearest: tell leg"),
        ("set_param gaze == 1\n", "f.txt:1:1: 'set_param gaze == 1' is not a command.*nearest: set_param gaze = "),
        ("# seed: soon\nbored\n", "f.txt:1:1: seed 'soon': expected a whole number"),
        ("# target: a\n# target: b\nbored\n", "f.txt:2:1: a second '# target:' in one test"),
        ("# id: x\n# suite: s\n# target: a\nbored\n", "f.txt:1:1: test 'x' has an id but no seed"),
        (
            "# id: x\n# suite: s\n# target: a\n# seed: 1\nbored\n\n\n# id: x\n# suite: s\n# target: a\n# seed: 2\n",
            "f.txt:8:1: a second test with the id 'x', which is at f.txt:1:1 already; expected each id once",
        ),
        ("# values 2: x_m 1\nbored\n", "f.txt:1:1: values of command 2: the test has 1 commands only"),
        ("# values 0: x_m 1\nbored\n", "f.txt:1:1: values of '0': expected 'run' or the number of a command, from 1"),
        ("# values 1: x_m\nbored\n", "f.txt:1:1: 'x_m' is not a value; expected a parameter and a number"),
        ("# values 1:\nbored\n", "f.txt:1:1: '' is not a value"),
        ("# values 1: x_m 1, x_m 2\nbored\n", "f.txt:1:1: a second value of 'x_m'"),
        (
            "# values 1: x_m inf\n# values run: y_s 1\nbored\n",
            "f.txt:1:1: values of command 1: x_m is inf; expected a f",
        ),
        ("# values 1: x_m 1\n# values 1: y_m 1\nbored\n", "f.txt:2:1: a second '# values 1:' in one test"),
        ("# id: x.y\n# suite: s\n# target: a\n# seed: 1\nbored\n", "f.txt:1:1: test id 'x.y': expected letters"),
    ],
)
def test_an_error_of_a_text_names_file_line_and_column(text: str, message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        parse_tests(text, file="f.txt", suite="f", commands=COMMANDS)


CONTEXT = GenerationContext(commands=COMMANDS)


def test_an_exported_suite_reads_back_with_the_same_ids(tmp_path: Path) -> None:
    suite = Pseudorandom().generate(CONTEXT)
    (tmp_path / "exported.txt").write_text(dump_tests(suite.tests), encoding="utf-8")
    for path in (tmp_path, tmp_path / "exported.txt"):
        back = Files(path).generate(replace(CONTEXT, seed=99))
        assert back.tests == suite.tests
        assert back.name == "pseudorandom"


def test_a_test_in_two_files_of_a_folder_is_an_error_that_names_both(tmp_path: Path) -> None:
    suite = Pseudorandom().generate(replace(CONTEXT, tests=2))
    for name in ("one.txt", "two.txt"):
        (tmp_path / name).write_text(dump_tests(suite.tests), encoding="utf-8")
    with pytest.raises(GenerateError, match=r"two.txt: test 'pseudorandom-.*' is in .*one.txt already"):
        Files(tmp_path).generate(CONTEXT)


def test_a_file_has_a_largest_number_of_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.generate.suite_files.MAX_TESTS", 3)
    assert len(parse_tests("bored\n\n\n\n# note\n\n" * 3, file="f.txt", suite="s")) == 3
    with pytest.raises(GenerateError, match=r"f\.txt:7:1: more than 3 tests up to here"):
        parse_tests("bored\n\n" * 4, file="f.txt", suite="s")


def test_a_folder_and_recorded_runs_have_a_largest_number_of_tests(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.generate.suite_files.MAX_TESTS", 3)
    (tmp_path / "one").mkdir()
    for name in "ab":
        (tmp_path / "one" / f"{name}.txt").write_text("bored\n\n" * 2)
    (tmp_path / "r.json").write_text(json.dumps({"s": [{"steps": ["bored"]}] * 4}))
    for path in (tmp_path / "one", tmp_path / "r.json"):
        with pytest.raises(GenerateError, match="more than 3 tests; expected fewer in one file or folder"):
            Files(path).generate(CONTEXT)


@pytest.mark.parametrize(
    ("comment", "form"),
    [("# valeus 1: leg_m 0.5", "values NUMBER"), ("# sed: 7", "seed"), ("# Beliefs: bored", "beliefs")],
)
def test_a_misspelt_field_is_no_comment(comment: str, form: str) -> None:
    with pytest.raises(GenerateError, match=f"t.txt:1:1: .*nearest: '# {form}: ...'"):
        parse_tests(f"{comment}\nbored\n", file="t.txt", suite="t")
    assert len(parse_tests("# note 1: the person is slow\nbored\n", file="t.txt", suite="t")) == 1


def test_fewer_tests_are_evenly_spaced_and_more_give_a_note(tmp_path: Path) -> None:
    path = tmp_path / "t.txt"
    path.write_text("\n\n".join(COMMANDS))
    few = Files(path).generate(replace(CONTEXT, tests=5))
    assert [test.lines[0] for test in few.tests] == list(COMMANDS[::2])
    many = Files(path).generate(replace(CONTEXT, tests=99))
    assert len(many.tests) == len(COMMANDS)
    assert many.generation.notes == ("99 tests asked for, but t.txt has 10 only",)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.txt", "tell leg\ntell legs\n", r"a.txt:2:1: unknown command 'tell legs'; nearest: tell leg"),
        ("a.txt", "# nothing\n", "no tests in it"),
        ("a.json", "{", r"a.json:1:2: not JSON, perhaps cut off \(Expecting"),
        ("a.json", "[]", "Expected `object`, got `array`; expected an object of suites"),
        ("a.json", '{"x": 3}', "suite 'x': Expected `array`, got `int`; .* each a list of tests"),
        ("a.json", '{"x": [{}]}', r"suite 'x': Object missing required field `steps` - at `\$\[0\]`"),
        ("a.json", '{"x": [{"steps": "bored"}]}', r"got `str` - at `\$\[0\].steps`; expected .* a list of commands"),
        (
            "a.json",
            '{"x": [{"steps": ["bored", "tell legs"]}]}',
            "entry 1, step 2: unknown command 'tell legs'; nearest",
        ),
        ("a.json", '{"x": [{"steps": ["tell leg now"]}]}', "entry 1, step 1: 'tell leg now' is not a command"),
        ("a.json", '{"x": [{"steps": null}]}', "no tests in it"),
    ],
)
def test_an_error_of_a_file_names_file_line_and_column(tmp_path: Path, name: str, text: str, message: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(GenerateError, match=message):
        Files(tmp_path / name).generate(CONTEXT)


def test_a_folder_without_tests_and_a_missing_file_are_errors(tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match=r"no text file \(\*.txt\)"):
        Files(tmp_path).generate(CONTEXT)
    with pytest.raises(GenerateError, match="expected a file of abstract tests"):
        Files(tmp_path / "gone.txt").generate(CONTEXT)
