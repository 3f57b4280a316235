"""Definitions that requirements of a file share: what they stand for, and errors that point into them."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.monitor import RequirementError, load_definitions, load_requirements, parse_condition, parse_formula
from tests.monitor.vocabulary import SMALL

FORMULA = '[R1]\ntitle = "One"\nformula = "always({})"\n'


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "requirements.toml"


def written(file: Path, definitions: str, formula: str = "p -> q") -> Path:
    file.write_text(f"[definitions]\n{definitions}\n{FORMULA.format(formula)}")
    return file


@pytest.mark.parametrize(
    ("definitions", "formula", "meaning"),
    [
        (
            'big = "x > 1 [hysteresis 0.5]"',
            "big & p -> !big",
            "x > 1 [hysteresis 0.5] & p -> !(x > 1 [hysteresis 0.5])",
        ),
        ('either = "p | q"', "either & q -> !either", "(p | q) & q -> !(p | q)"),
        ("limit = 3\ncold = -2.5", "x < limit -> y > cold + 1", "x < 3 -> y > -2.5 + 1"),
        ('sum = "x + y"', "sum < 3 -> 2 * sum < 9", "x + y < 3 -> 2 * (x + y) < 9"),
        ('first = "\'i\'"\nname = "w"', "on(w) & name == first -> q", "on(w) & w.name == 'i' -> q"),
        (
            'idle = "time_since(on(a))"\nmany = "count(on(a)) > 2"',
            "many -> idle < 3",
            "count(on(a)) > 2 -> time_since(on(a)) < 3",
        ),
        ('both = "left & right"\nleft = "p"\nright = "q | left"', "both -> q", "p & (q | p) -> q"),
    ],
)
def test_a_definition_stands_for_its_expression(file: Path, definitions: str, formula: str, meaning: str) -> None:
    [requirement] = load_requirements(written(file, definitions, formula), SMALL)
    assert requirement.formula == parse_formula(f"always({meaning})", SMALL)


def test_the_text_of_a_requirement_has_the_definitions_that_explain_it(file: Path) -> None:
    definitions = 'both = "left & right"\nleft = "p"\nunused = "q"\nright = "q | left"'
    [requirement] = load_requirements(written(file, definitions, "both -> left"), SMALL)
    assert (
        requirement.text == "always(both -> left)\nwhere both = left & right;\n      right = q | left;\n      left = p"
    )
    [requirement] = load_requirements(written(file, definitions), SMALL)
    assert requirement.text == "always(p -> q)"


def test_conditions_outside_of_the_file_use_its_definitions(file: Path) -> None:
    vocabulary = load_definitions(written(file, 'big = "x > 1"'), SMALL)
    assert str(parse_condition("big & !p", vocabulary)) == "x > 1 & !p"
    assert load_definitions([], SMALL) is SMALL
    file.write_text(FORMULA.format("p -> q"))
    assert load_definitions(file, SMALL) == SMALL


@pytest.mark.parametrize(
    ("definitions", "formula", "says"),
    [
        ('big = "x > "', "p -> q", ":2:11: definition big, column 4 of the formula: the definition ends too early"),
        ('big = ""', "p -> q", "definition big, column 1 of the formula: the definition is empty"),
        ('big = "x > z"', "p -> q", ":2:12: definition big, column 5 of the formula: unknown name 'z'"),
        ('big = "always(p -> q)"', "p -> q", "a definition is about the present and the past"),
        (
            'a1 = "b1 & p"\nb1 = "q | c1"\nc1 = "!a1"',
            "p -> q",
            ":4:8: definition c1, column 2 of the formula: definitions use each other in a circle: a1 -> b1 -> c1",
        ),
        ('a1 = "a1"', "p -> q", "definitions use each other in a circle: a1 -> a1"),
        ('p = "q"', "p -> q", "definition 'p': there is a signal of this name; choose another one"),
        ('m = "q"', "p -> q", "definition 'm': there is a topic of this name; choose another one"),
        ('since = "q"', "p -> q", "definition 'since': this is a keyword"),
        ('"b-g" = "q"', "p -> q", "definition 'b-g': a name consists of letters, digits and _"),
        ("big = true", "p -> q", "definition big: expected a string or a number, got True"),
        ('big = ["p"]', "p -> q", "definition big: expected a string or a number, got ['p']"),
        ('big = "x > 1"', "bigg -> q", "requirement R1, column 8 of the formula: unknown name 'bigg'; nearest: big"),
        ('big = "x > 1"', "big > 2 -> q", "expected a number, but big is a bool"),
        ('big = "x"', "big -> q", "expected a condition, but big is a float"),
        ('big = "x"', "on(big) -> q", "big is a definition; on(...) takes a topic"),
        ('big = "x"', "last(big) < 2 -> q", "expected a field of a message, but big is a definition"),
        ('idle = "time_since(p)"', "idle + 1 < 2 -> q", "a time_since is compared with a number of seconds"),
        ('come = "on(a)"', "p -> come", "this is true for single instants only"),
        ("first = \"'l'\"", "w == first -> q", "w.name is never 'l'"),
    ],
)
def test_a_definition_that_is_wrong_or_wrongly_used_is_refused(
    file: Path, definitions: str, formula: str, says: str
) -> None:
    with pytest.raises(RequirementError) as caught:
        load_requirements(written(file, definitions, formula), SMALL)
    assert says in str(caught.value)
    assert str(file) in str(caught.value)


def test_definitions_that_are_no_table_are_refused(file: Path) -> None:
    file.write_text('definitions = "p"\n' + FORMULA.format("p -> q"))
    with pytest.raises(RequirementError, match="definitions is not a table; expected"):
        load_requirements(file, SMALL)


def test_a_file_with_definitions_only_has_no_requirement(file: Path) -> None:
    file.write_text('[definitions]\nbig = "p"\n')
    with pytest.raises(RequirementError, match="no requirement in this file"):
        load_requirements(file, SMALL)
