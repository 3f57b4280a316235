"""Patterns as text in a file of requirements: the same formula as in Python, and errors that point at the argument."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from pytest_hricdv.monitor import FormulaSource, Requirement, RequirementError, load_requirements
from pytest_hricdv.monitor.build import fall, field, on, signal
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.pattern_parser import parse_pattern
from pytest_hricdv.monitor.patterns import (
    absence,
    contact_pressure,
    existence,
    hand_guiding,
    power_and_force,
    precedence,
    protective_stop,
    response,
    speed_and_separation,
    universality,
)
from tests.monitor.vocabulary import SMALL, marked

p, q, x, y = signal("p"), signal("q"), signal("x"), signal("y")
a, b, m = on("a"), on("b"), on("m")
v, d = signal("v"), signal("d")
MEASURED = replace(
    SMALL, signals={**SMALL.signals, "v": float, "d": float, "mm": float}, units={"v": "rad/s", "d": "m", "mm": "mm"}
)


def read(text: str) -> Formula:
    return parse_pattern(FormulaSource(text, owner="pattern"), SMALL)


def load(tmp_path: Path, document: str) -> Requirement:
    file = tmp_path / "requirements.toml"
    file.write_text(document)
    [requirement] = load_requirements(file, SMALL)
    return requirement


@pytest.mark.parametrize(
    ("text", "built"),
    [
        ("response(on(a), on(b), within_s=30)", response(a, b, within_s=30)),
        ("response(a, b, within_s=30)", response(a, b, within_s=30)),  # a topic alone is its arrival
        ("response(reaction = w, within_s = 3e1, trigger = (p | on(a)))", response(p | a, on("w"), within_s=30)),
        ("precedence(m & m.ok, fall(p), within_s=2)", None),
        ("precedence(on(m) & m.ok, fall(p), within_s=2)", precedence(m & field("m.ok"), fall(p), within_s=2)),
        ("absence(p, after=a, until=b)", absence(p, after=a, until=b)),
        ("universality(n.level < 1, during=p)", universality(field("n.level") < 1, during=p)),
        ("existence(a, at_most=2, within_s=9)", existence(a, at_most=2, within_s=9)),
        (
            "speed_and_separation(x, y, stop_distance_m=0.2 + x, slow_distance_m=1, slow_speed=.25)",
            speed_and_separation(x, y, stop_distance_m=0.2 + x, slow_distance_m=1, slow_speed=0.25),
        ),
        ("power_and_force(x, limit_n=y)", power_and_force(x, limit_n=y)),
        ("protective_stop(p, x + y, within_s=0)", protective_stop(p, x + y, within_s=0)),
        ("hand_guiding(p,\n  q)", hand_guiding(p, q)),
    ],
)
def test_a_pattern_in_a_file_is_that_of_python(text: str, built: Formula | None) -> None:
    if built is None:
        with pytest.raises(RequirementError, match="m is a topic"):  # within a formula the language's own rules hold
            read(text)
    else:
        assert read(text) == built


@pytest.mark.parametrize(
    ("text", "mark", "says"),
    [
        ("", "", "the pattern is empty"),
        ("respons(a, b, within_s=3)", "respons", "unknown pattern 'respons'; nearest: response"),
        ("response", "", "the pattern ends too early"),
        ("response()", "response", "response needs trigger\n"),
        ("response(a, b)", "response", "response needs within_s"),
        ("response(a, b, 3)", "3", "2 arguments by position"),
        ("response(a, b, within=3)", "within", "no argument 'within'; nearest: within_s"),
        ("response(a, b, p = 1)", "p", "expected response(trigger, reaction, within_s=..., [after_s=...])"),
        ("response(a, b, within_s=3, within_s=4)", "within_s", "within_s is given twice"),
        ("response(a, b, trigger=q, within_s=4)", "trigger", "trigger is given twice"),
        ("response(a, b, within_s=-3)", "-3", "within_s: expected a finite number of at least 0, got -3"),
        ("response(a, b, within_s=x)", "x", "within_s: expected a number, without signals and fields"),
        ("response(a, b, within_s=p)", "p", "expected a number, but p is a bool"),
        ("response(a, b, within_s=3 - 1 * x)", "3 - 1 * x", "without signals and fields"),
        ("response(a, 30, within_s=3)", "30", "expected a condition, but this is a number"),
        (
            "response(a, c, within_s=3)",
            "c",
            "unknown name 'c'; known: p, q, x, y, s, m.ok, m.level, n.level, w.name, a, b",
        ),
        ("response(a, p & qq, within_s=3)", "qq", "unknown name 'qq'; nearest: q"),
        ("response(a b, within_s=3)", "b", "unexpected 'b'"),
        ("response(a, always(p), within_s=3)", "always", "an argument of a pattern is about the present and the past"),
        ("always(p -> q)", "always", "for a formula, write the key formula"),
        ("response(a, b, within_s=3) & p", "&", "expected the end of the formula"),
        ("absence(a)", "absence", "no scope; expected `during=condition` or `after=event`"),
        ("absence(a, during=p, until=on(b))", "on(b)", "until: does not go with `during`"),
        ("universality(a, during=p)", "a", "`on(a)` is true for single instants only"),
        ("existence(a, at_most=1.5)", "1.5", "expected a whole number, got 1.5"),
        ("power_and_force(x, limit_n=time_since(p))", "time_since(p)", "is compared with a number of seconds"),
        ("power_and_force(3, limit_n=x)", "3", "force: expected a signal or a field"),
        ("power_and_force(x)", "power_and_force", "needs limit_n"),
    ],
)
def test_an_error_points_at_the_argument(text: str, mark: str, says: str) -> None:
    with pytest.raises(RequirementError) as caught:
        read(text)
    assert says in str(caught.value)
    assert not mark or marked(caught.value) == mark


def test_a_requirement_shows_its_pattern_and_what_it_means(tmp_path: Path) -> None:
    requirement = load(tmp_path, '[P]\ntitle = "One"\npattern = " response(a, b, within_s=30)"\n')
    assert requirement.formula == response(a, b, within_s=30)
    assert requirement.text == "response(a, b, within_s=30)\nmeans always(on(a) -> eventually[0:30](on(b)))"


def test_arguments_may_be_definitions(tmp_path: Path) -> None:
    definitions = '[definitions]\nhot = "x > limit"\nlimit = 3\n'
    requirement = load(tmp_path, f'{definitions}[P]\ntitle = "One"\npattern = "response(hot, q, within_s=limit)"\n')
    assert requirement.formula == response(x > 3, q, within_s=3)


@pytest.mark.parametrize(
    ("text", "built"),
    [
        ("response(a, b, within_s=250 ms)", response(a, b, within_s=0.25)),
        ("universality(q, after=a, for_s=2 min)", universality(q, after=a, for_s=120)),
        (
            "speed_and_separation(v, d, stop_distance_m=50 mm, slow_distance_m=d, slow_speed=10 deg/s * 18)",
            speed_and_separation(v, d, stop_distance_m=0.05, slow_distance_m=d, slow_speed=math.pi),
        ),
        ("protective_stop(p, v, within_s=1, standstill=1 mrad/s)", protective_stop(p, v, within_s=1, standstill=0.001)),
        (
            "power_and_force(x, limit_n=0.14 kN, transient_limit_n=280, transient_s=500 ms)",
            power_and_force(x, limit_n=140, transient_limit_n=280, transient_s=0.5),
        ),
        ("contact_pressure(x, limit_n_cm2=1.9 MPa)", contact_pressure(x, limit_n_cm2=190)),
    ],
)
def test_an_argument_with_a_unit_is_converted(text: str, built: Formula) -> None:
    assert parse_pattern(FormulaSource(text), MEASURED) == built


@pytest.mark.parametrize(
    ("text", "mark", "says"),
    [
        ("response(a, b, within_s=3 m)", "3 m", "expected a number in s, got one in m"),
        ("existence(a, at_most=3 s)", "3 s", "expected a number without a unit, got one in s"),
        ("speed_and_separation(v, mm, stop_distance_m=1)", "mm", "multiply it by 0.001"),
        ("speed_and_separation(v, d, stop_distance_m=1, slow_distance_m=2, slow_speed=1 m/s)", "1 m/s", "in rad/s"),
        ("protective_stop(p, x, within_s=1, standstill=1 m/s)", "x", "no unit is declared for this"),
    ],
)
def test_an_argument_in_another_unit_is_refused(text: str, mark: str, says: str) -> None:
    with pytest.raises(RequirementError, match=re.escape(says)) as caught:
        parse_pattern(FormulaSource(text), MEASURED)
    assert text[caught.value.position or 0 :].startswith(mark)


def test_an_error_in_a_file_names_line_and_column_of_the_pattern(tmp_path: Path) -> None:
    with pytest.raises(RequirementError) as caught:
        load(tmp_path, '[P]\ntitle = "One"\npattern = """\nresponse(a, b,\n         within_s=-1)"""\n')
    assert str(caught.value) == (
        f"{tmp_path}/requirements.toml:5:19: requirement P, line 2, column 19 of the pattern: "
        "within_s: expected a finite number of at least 0, got -1\n"
        "             within_s=-1)\n"
        "                      ^^"
    )


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ('pattern = "hand_guiding(p, q)"\nformula = "always(p -> q)"', "both 'formula' and 'pattern'"),
        ("pattern = 3", "'pattern' has to be a string, got 3"),
        ('patern = "hand_guiding(p, q)"', "unknown key 'patern'; nearest: pattern"),
        ('pattern = ""', "the pattern is empty"),
    ],
)
def test_a_requirement_has_either_a_formula_or_a_pattern(keys: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(RequirementError, match=says):
        load(tmp_path, f'[P]\ntitle = "One"\n{keys}\n')


@pytest.mark.parametrize("call", ["power_and_force(x, limit_n=30)", "contact_pressure(x, limit_n_cm2=30)"])
def test_a_limit_of_force_or_pressure_needs_a_source(call: str, tmp_path: Path) -> None:
    keys = f'[P]\ntitle = "One"\npattern = "{call}"\n'
    with pytest.raises(RequirementError, match="expected the key source, which says where the limit comes from"):
        load(tmp_path, keys)
    assert load(tmp_path, f'{keys}source = "Our risk assessment, table 3"\n').source
