"""Formulas of any length, and limits of what nests or grows: an error with its place, and soon."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.monitor import RequirementError, Vocabulary, check_requirement, load_requirements
from pytest_hricdv.monitor.build import always, eventually, on, signal
from pytest_hricdv.monitor.dsl import TruthValue
from pytest_hricdv.monitor.program import compile_formula
from pytest_hricdv.monitor.requirement import Requirement

SMALL = Vocabulary(signals={"p": bool, "x": float}, messages={"m": {}})


def loaded(folder: Path, formula: str, definitions: str = "") -> Requirement:
    """The one requirement of a file."""
    path = folder / "r.toml"
    path.write_text(f'[definitions]\n{definitions}\n[R1]\ntitle = "t"\nformula = "{formula}"\n')
    (requirement,) = load_requirements(path, SMALL)
    compile_formula(requirement.formula, requirement.names)
    return requirement


def chain(count: int, operator: str) -> str:
    """A formula of so many comparisons."""
    return f" {operator} ".join(f"x > {number}" for number in range(count))


@pytest.mark.parametrize("operator", ["&", "|"])
@pytest.mark.parametrize("formula", ["always({} -> p)", "always(p -> {})", "always(p -> always[0:1]({}))"])
def test_a_long_formula_does_not_nest(tmp_path: Path, operator: str, formula: str) -> None:
    text = formula.format(chain(3000, operator))
    assert str(loaded(tmp_path, text).formula) == text


def test_operands_of_a_long_formula_are_all_evaluated(tmp_path: Path) -> None:
    program = compile_formula(loaded(tmp_path, f"always(p -> {chain(300, '&')})").formula)
    values = {"p": True, "x": 299.5}
    assert program.condition(values, {}, {})  # type: ignore[arg-type]
    assert program.robustness is not None
    assert program.robustness(values, {}, {}) == 0.5  # type: ignore[arg-type]
    assert not program.condition(values | {"x": 298.5}, {}, {})  # type: ignore[arg-type]


DOUBLING = 'd0 = "p"\n' + "\n".join(f'd{n} = "d{n - 1} & d{n - 1}"' for n in range(1, 31))
LINE = 'd0 = "p"\n' + "\n".join(f'd{n} = "!d{n - 1}"' for n in range(1, 900))


@pytest.mark.parametrize(
    ("formula", "definitions", "message"),
    [
        ("p & " + "!" * 3000 + "p", "", "r.toml:5:90: requirement R1, column 79 of the formula: nested too deeply"),
        ("(" * 30_000 + "p" + ")" * 30_000, "", "nested too deeply: more than 64 levels of operators or parentheses"),
        ("once(" * 3000 + "p" + ")" * 3000, "", "nested too deeply"),
        (" + ".join(["x"] * 3000) + " > 1", "", "nested too deeply"),
        ("!" * 40 + "(" * 40 + "p" + ")" * 40, "", "nested too deeply"),
        (chain(20_000, "&"), "", "characters; expected at most 100,000"),
        ("d30", DOUBLING, "definition d11, column 7 of the formula: with what the definitions stand for"),
        ("d899", LINE, "nested too deeply: with the definitions in it"),
        ("d899", "\n".join(reversed(LINE.split("\n"))), "more than 64 definitions that use each other"),
        ("eventually[0:1e300](p)", "", "expected a time of at most 1e+09 s\n"),
        ("once[0:1e300](p)", "", "expected a time of at most 1e+09 s\n"),
        ("x > 1 [for 1e300]", "", "expected a time of at most 1e+09 s\n"),
        ("time_since(p) < 1e300", "", "expected a time of at most 1e+09 s\n"),
        ("1e300 > time_since(p)", "", "expected a time of at most 1e+09 s\n"),
        ("eventually[0:1e8 h](p)", "", "expected a time of at most 1e+09 s\n"),
        ("x > 1 mm^999999999", "", "unknown unit 'mm^999999999'"),
        ("x > 1 " + "*".join(["m"] * 10_000), "", "unknown unit 'm*m*m"),
        ("x > " + "9" * 5000, "", "this number is too large for a float"),
        ("y" * 50_000, "", "unknown name 'yyyy"),
    ],
    ids=lambda value: value[:20],
)
def test_what_grows_is_refused_with_its_place(tmp_path: Path, formula: str, definitions: str, message: str) -> None:
    with pytest.raises(RequirementError) as raised:
        loaded(tmp_path, f"always(p -> {formula})", definitions)
    assert message in str(raised.value)
    assert "r.toml:" in str(raised.value)
    assert len(str(raised.value)) <= 1000


@pytest.mark.parametrize(("depth", "is_accepted"), [(63, True), (64, False), (150, False)])
def test_a_formula_built_in_python_nests_twice_as_deep(depth: int, is_accepted: bool) -> None:
    condition: TruthValue = signal("p")
    for _ in range(depth):
        condition = ~condition
    formula = always(on("m") >> eventually(condition, 0, 1))
    built = Requirement("R1", "", "", str(formula), formula)
    if is_accepted:
        check_requirement(built, SMALL)
        compile_formula(formula)
    else:
        with pytest.raises(RequirementError, match="more than 128 levels of operators or parentheses"):
            check_requirement(built, SMALL)


def test_no_invisible_character_of_a_formula_is_printed(tmp_path: Path) -> None:
    with pytest.raises(RequirementError) as raised:
        loaded(tmp_path, r"always(p -> \u001b[31m\u202e)")
    assert "always(p -> ?[31m?)" in str(raised.value)
    assert str(raised.value).replace("\n", "").isprintable()
