"""Numbers with units in formulas: what they are converted to, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.monitor import RequirementError, Vocabulary, load_requirements, parse_condition
from pytest_hricdv.monitor.past_formula import NumberComparison
from pytest_hricdv.monitor.terms import NumberTerm
from pytest_hricdv.monitor.units import unit_names, unit_of
from tests.monitor.vocabulary import marked

MEASURED = Vocabulary(
    signals=dict.fromkeys(("x", "y_mm", "v", "w", "force", "angle", "lamp", "amount", "plain"), float)
    | {"p": bool, "q": bool},
    messages={"done": {"after": float}, "done_at": {"x": float, "t": float}},
    units={
        "x": "m", "y_mm": "mm", "v": "m/s", "w": "rad/s", "force": "N", "angle": "rad", "lamp": "%", "amount": "legs",
        "done.after": "s", "done_at.t": "ms",
    },
)  # fmt: skip


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("x < 50 mm", "x < 0.05"),
        ("50mm > x", "0.05 > x"),
        ("x < 5e1 mm", "x < 0.05"),
        ("x < 1e-3m", "x < 0.001"),
        ("y_mm < 5 cm", "y_mm < 50"),
        ("x > -2.5 cm", "x > -0.025"),
        ("w < 0.25 rad/s", "w < 0.25"),
        ("v >= 90 m/min", "v >= 1.5"),
        ("force < 0.14 kN", "force < 140"),
        ("force < 140 kg*m/s^2", "force < 140"),
        ("lamp > 80 %", "lamp > 80"),
        ("amount >= 4 legs", "amount >= 4"),
        ("done <= 5 min", "done.after <= 300"),
        ("last(done) <= 250 ms", "last(done.after) <= 0.25"),
        ("done_at.t < 0.25 s", "done_at.t < 250"),
        ("x + 5 mm < 2 * y_mm / 1000", "x + 0.005 < 2 * y_mm / 1000"),
        ("x < 1 m + 20 cm - 5 mm", "x < 1.195"),
        ("x < 2 * 5 mm", "x < 0.01"),
        ("x < (1 + 2) * 5 mm / 3", "x < 0.005"),
        ("x < 300 mm + 1600 ms * v", "x < 0.3 + 1.6 * v"),
        ("x / v < 250 ms", "x / v < 0.25"),
        ("y_mm / v < 250 ms", "y_mm / v < 250"),
        ("1 / done.after > 2 Hz", "1 / done.after > 2"),
        ("x < 50 mm [hysteresis 5 mm] [for 250 ms]", "x < 0.05 [hysteresis 0.005] [for 0.25]"),
        ("x < 0.05 [hysteresis 5 mm]", "x < 0.05 [hysteresis 0.005]"),
        ("time_since(p) < 250 ms", "time_since(p) < 0.25"),
        ("0.5 min < time_since(p)", "time_since(p) > 30"),
        ("time_between(p, p) < 250 ms", "time_between(p, p) < 0.25"),
        ("once[0:250 ms](p) & historically[1 s:2](q)", "once[0:0.25](p) & historically[1:2](q)"),
        ("count[0:1 min](p) < 3", "count[0:60](p) < 3"),
        ("x < 3 since p", "x < 3 since p"),
        ("x < 1e5 & x < 12E+5", "x < 100000 & x < 1200000"),
        ("plain < 3 & x < plain & x * 2 < plain", "plain < 3 & x < plain & x * 2 < plain"),
        ("x < 0.3 + 1.6 * v", "x < 0.3 + 1.6 * v"),  # a plain factor may have a unit of its own
    ],
)
def test_a_number_is_converted_to_the_unit_of_the_other_side(text: str, plain: str) -> None:
    without_units = Vocabulary(MEASURED.signals, MEASURED.messages)
    assert parse_condition(text, MEASURED) == parse_condition(plain, without_units)


@pytest.mark.parametrize(
    ("text", "mark", "says"),
    [
        ("x < 50 N", "50 N", "expected a number in m, got one in N"),
        ("50 mm < force", "50 mm", "expected a number in N, got one in mm"),
        ("x < 5 mmm", "5 mmm", "unknown unit 'mmm'; nearest: mm"),
        ("x < 3 y_mm", "y_mm", "unexpected"),
        ("x < 3 v", "3 v", "unknown unit 'v'"),
        ("x < 3 v", "3 v", "a product of a number and a name is written with `*`"),
        ("plain < 50 mm", "plain", "no unit is declared for this\n"),
        ("plain * 2 < 50 mm", "plain * 2", "no unit is declared for this\n"),
        ("50 mm < 3", "3", "this number has no unit, and the other one has"),
        ("x < 5 mm + 3", "3", "this number has no unit, and the other one has"),
        ("x < 5 mm + 3 s", "3 s", "expected a number in mm, got one in s"),
        ("x + 3 s < 1", "3 s", "expected a number in m, got one in s"),
        ("x < 5 mm * 2 s", "5 mm * 2 s", "expected a number in m, got one in m * s"),
        ("x < 5 mm / 0", "5 mm / 0", "this is not a finite number"),
        ("x < 1e308 km", "1e308 km", "too large for a float"),
        ("x < v", "v", "this is in m/s, the other side in m"),
        ("x + force < 3", "force", "this is in N, the other side in m"),
        ("x < y_mm", "y_mm", "signals are not converted: multiply it by 0.001"),
        ("count(p) < 3 s", "3 s", "expected a number without a unit, got one in s"),
        ("time_since(p) < 3 m", "3 m", "expected a number in s, got one in m"),
        ("time_between(p, p) < 3 m", "3 m", "expected a number in s, got one in m"),
        ("once[0:3 m](p)", "3 m", "expected a number in s, got one in m"),
        ("once[2 s:1 s](p)", "[2 s:1 s]", "needs a <= b, got [2 s:1 s]"),
        ("x < 5 mm [for 3 m]", "3 m", "expected a number in s, got one in m"),
        ("x < 5 mm [hysteresis 3 s]", "3 s", "expected a number in m, got one in s"),
        ("plain < 5 [hysteresis 3 mm]", "plain", "no unit is declared for this"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused(text: str, mark: str, says: str) -> None:
    with pytest.raises(RequirementError) as caught:
        parse_condition(text, MEASURED)
    assert says in str(caught.value)
    assert marked(caught.value) == mark


def test_a_definition_keeps_its_unit(tmp_path: Path) -> None:
    file = tmp_path / "requirements.toml"
    table = '[R1]\ntitle = "x"\nformula = "always(x < reach & y_mm < reach -> x > -reach + far)"\n'
    file.write_text(f'[definitions]\nreach = "5 cm"\nfar = "2 * reach + 1 mm"\n{table}')
    [requirement] = load_requirements(file, MEASURED)
    assert str(requirement.formula) == "always(x < 0.05 & y_mm < 50 -> x > 0.051)"
    file.write_text(f'[definitions]\nreach = "5 N"\nfar = "x + 1 mm"\n{table}')
    with pytest.raises(RequirementError, match="expected a number in m, got one in N"):
        load_requirements(file, MEASURED)


def test_units_of_unknown_names_are_refused() -> None:
    with pytest.raises(
        ValueError, match=r"units has 'm\.levl', which is neither a signal nor a topic\.field; nearest: m\.level"
    ):
        Vocabulary(messages={"m": {"level": float}}, units={"m.levl": "m"})


@given(value=st.floats(1e-6, 1e6), unit=st.sampled_from(unit_names()), other=st.sampled_from(unit_names()))
def test_all_units_of_a_dimension_mean_the_same(value: float, unit: str, other: str) -> None:
    vocabulary = Vocabulary(signals={"x": float}, units={"x": other})
    text = f"x < {value!r} {unit}"
    if unit_of(unit).dimension != unit_of(other).dimension:
        with pytest.raises(RequirementError, match="expected a number in"):
            parse_condition(text, vocabulary)
        return
    parsed = parse_condition(text, vocabulary)
    assert isinstance(parsed, NumberComparison)
    assert isinstance(parsed.right, NumberTerm)
    scale = unit_of(unit).scale / unit_of(other).scale
    assert parsed.right.value == pytest.approx(value * float(scale), rel=1e-15)


@pytest.mark.parametrize(
    ("text", "base", "scale"),
    [
        ("m/s^2", (("m", 1), ("s", -2)), 1),
        ("mm*mm", (("m", 2),), 1e-6),
        ("mm^2", (("m", 2),), 1e-6),
        ("N/cm^2", (("kg", 1), ("m", -1), ("s", -2)), 1e4),
        ("m*s^-1", (("m", 1), ("s", -1)), 1),
        ("m/m", (), 1),
    ],
)
def test_products_of_units(text: str, base: tuple[tuple[str, int], ...], scale: float) -> None:
    assert unit_of(text).dimension == base
    assert float(unit_of(text).scale) == scale
    assert unit_of(text).is_known


@pytest.mark.parametrize("text", ["legs", "left or right", "m/", "/m", "m/leg", "m s", "m^", "m^0.5"])
def test_a_unit_of_unknown_names_is_one_by_itself(text: str) -> None:
    assert unit_of(text).dimension == ((text, 1),)
    assert not unit_of(text).is_known
