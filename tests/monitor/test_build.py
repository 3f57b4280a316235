"""Requirements built in Python: the same formula as the text's, the same checks, and errors that say what to write."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pytest_hricdv.monitor import (
    Requirement,
    RequirementError,
    check_requirement,
    load_requirements,
    parse_formula,
)
from pytest_hricdv.monitor.build import (
    always,
    count,
    equal,
    eventually,
    fall,
    field,
    historically,
    last,
    on,
    once,
    previously,
    requirement,
    rise,
    signal,
    since,
    string,
    time_between,
    time_since,
    unequal,
)
from pytest_hricdv.monitor.formula import Formula, Holds
from pytest_hricdv.monitor.past_formula import NumberComparison, On
from pytest_hricdv.monitor.terms import ArithmeticTerm, FloatName, Negative, NumberTerm
from tests.monitor.strategies import formulas
from tests.monitor.vocabulary import R1, R2, R3, R4, SMALL, TABLE

p, q, x, y, ok = signal("p"), signal("q"), signal("x"), signal("y"), field("m.ok")
s, w = signal("s"), field("w.name")
a, b = on("a"), on("b")


def case_study() -> list[Requirement]:
    gaze, pressure, location = field("reading.gaze"), field("reading.pressure"), field("reading.location")
    released = fall(signal("leg_held")) & ~signal("leg_torn") & (signal("leg_offset") < 0.15)
    closing, distance, speed = signal("hand_closing"), signal("hand_distance"), signal("arm_speed")
    moving = (speed > 0.001).hysteresis(0.004)
    return [
        requirement("R1", "", always(on("reading") & gaze & pressure & location >> eventually(released, 0, 10))),
        requirement(
            "R2",
            "",
            always(on("reading") & ~(gaze & pressure & location) >> always(~released).until(on("request"))),
        ),
        requirement("R3", "", always(closing >> (distance >= 0.05).hysteresis(0.005))),
        requirement("R4", "", always(moving >> (speed < 0.25))),
    ]


def test_the_case_study_built_in_python_is_the_one_in_the_file() -> None:
    built = case_study()
    assert [rebuilt.formula for rebuilt in built] == [original.formula for original in (R1, R2, R3, R4)]
    for rebuilt in built:
        check_requirement(rebuilt, TABLE)


@pytest.mark.parametrize(
    ("built", "text"),
    [
        (always(p >> q), "always(p -> q)"),
        (always(p | q & ok >> q), "always(p | q & m.ok -> q)"),
        (always(p & (q | a) >> q), "always(p & (q | on(a)) -> q)"),
        (always(~p & q >> ~(p | q)), "always(!p & q -> !(p | q))"),
        (always(a & previously(p) >> always(q, 0.5, math.inf)), "always(on(a) & previously(p) -> always[0.5:inf](q))"),
        (always(rise(p) >> eventually(b, 1, 3)), "always(rise(p) -> eventually[1:3](on(b)))"),
        (always(fall(p) >> always(q).until(b)), "always(fall(p) -> always(q) until on(b))"),
        (always(once(a) & once(p, 1, 2) >> q), "always(once(on(a)) & once[1:2](p) -> q)"),
        (always(historically(p, 0, 2) >> q), "always(historically[0:2](p) -> q)"),
        (always(historically(p) >> q), "always(historically[0:inf](p) -> q)"),
        (always(since(p | q, a) >> q), "always(p | q since on(a) -> q)"),
        (always((x < 1) >> (y >= 2).held_for(0.5)), "always(x < 1 -> y >= 2 [for 0.5])"),
        (always((x <= 1).hysteresis(0.5).held_for(2) >> q), "always(x <= 1 [for 2] [hysteresis 0.5] -> q)"),
        (always((x > 0.5) & (x < y) >> q), "always(x > 0.5 & x < y -> q)"),
        (always(equal(x, 1) | unequal(x + y, 2) >> q), "always(x == 1 | x + y != 2 -> q)"),
        (always(equal(w, "i") >> unequal('"', s).held_for(2)), """always(w.name == "i" -> '"' != s [for 2])"""),
        (always(equal(string("s"), w) >> q), "always(s == w.name -> q)"),
        (always(equal(x, y).held_for(2) >> q), "always(x == y [for 2] -> q)"),
        (
            always((count(p) > 2) & (count(a, 0, 2) + 1 <= 3) >> q),
            "always(count(p) > 2 & count[0:2](on(a)) + 1 <= 3 -> q)",
        ),
        (
            always((time_between(a, p | q) + 1 < 3) >> q),
            "always(time_between(on(a), p | q) + 1 < 3 -> q)",
        ),
        (
            always((time_since(a) < 3) >> (time_since(p | q) >= 2)),
            "always(time_since(on(a)) < 3 -> time_since(p | q) >= 2)",
        ),
        (always((last("m.level") < 1) & last("m.ok") >> q), "always(last(m.level) < 1 & last(m.ok) -> q)"),
        (always(equal(last("w.name"), "i") >> q), 'always(last(w.name) == "i" -> q)'),
        (always((x - (y - 1) / 2 > -1) >> q), "always(x - (y - 1) / 2 > -1 -> q)"),
        (always((2 * -x + 1 - field("m.level") * y < 0) >> q), "always(2 * -x + 1 - m.level * y < 0 -> q)"),
        (always((1 / x + (2 - y) > 3 + x) >> q), "always(1 / x + (2 - y) > 3 + x -> q)"),
    ],
    ids=str,
)
def test_operators_build_the_formula_of_the_text(built: Formula, text: str) -> None:
    assert built == parse_formula(text, SMALL)


@given(formula=formulas)
def test_the_text_of_a_formula_is_read_as_the_same_formula(formula: Formula) -> None:
    try:
        read = parse_formula(str(formula), SMALL)
    except RequirementError as error:
        # Random formulas may ask that an instant lasts, which is refused wherever it is written.
        assume("single instants only" not in str(error))
        raise
    assert read == formula


numbers = st.floats(0, 1e300).map(NumberTerm)
terms = st.recursive(
    numbers | st.sampled_from([FloatName("x"), FloatName("m.level")]),
    lambda inner: st.builds(Negative, inner) | st.builds(ArithmeticTerm, st.sampled_from("+-*/"), inner, inner),
    max_leaves=8,
)


@given(left=terms, right=terms, hysteresis=st.floats(0, 1e9), for_s=st.floats(0, 1e9))
def test_the_text_of_arithmetic_is_read_as_the_same_arithmetic(
    left: NumberTerm, right: NumberTerm, hysteresis: float, for_s: float
) -> None:
    formula = Formula(On("a"), Holds(NumberComparison("<", left, right, hysteresis, for_s)))
    assert parse_formula(str(formula), SMALL) == formula


def test_the_text_has_only_necessary_parentheses() -> None:
    text = "always(p & (q | on(a)) & !(x < 1) since m.ok -> x - (y - 1) > 2 [hysteresis 0.5] [for 2] | q)"
    assert str(parse_formula(text, SMALL)) == text


def test_built_requirements_are_loaded_like_those_of_a_file() -> None:
    built = case_study()
    assert load_requirements(built, TABLE) == tuple(built)
    with pytest.raises(RequirementError, match="requirement R1 is there twice"):
        load_requirements([*built, built[0]], TABLE)
    with pytest.raises(RequirementError, match="no requirement; expected at least one"):
        load_requirements([], TABLE)
    with pytest.raises(RequirementError, match="requirement R1, column 11: unknown topic 'reading'"):
        load_requirements(built, SMALL)


def test_a_text_that_differs_from_its_formula_is_refused() -> None:
    with pytest.raises(RequirementError, match="requirement R: its text and its formula differ"):
        check_requirement(Requirement("R", "", "", "always(q -> p)", always(p >> q)), SMALL)


@pytest.mark.parametrize(
    ("mistake", "says"),
    [
        (lambda: p and q, "write & | ~ for and, or, not"),
        (lambda: 0 < x < 1, r"\(a < x\) & \(x < b\) for a < x < b"),
        (lambda: x == 1, r"write equal\(a, b\)"),
        (lambda: x != 1, r"write equal\(a, b\)"),
        (lambda: x < 1 & p, "put parentheses around each"),
        (lambda: p >> x < 1, "an implication cannot be compared with 1; .* put parentheses"),
        (lambda: p & 1, "expected a condition, got 1"),  # type: ignore[operator]
        (lambda: p >> always(q), r"got <always\(q\), without window or until"),  # type: ignore[operator]
        (lambda: requirement("R1", "", always(p)), r"R1: expected always\(antecedent >> response\)"),  # type: ignore[arg-type]
        (lambda: always(p >> q, 1, 2), "a window belongs to a response"),  # type: ignore[call-overload]
        (lambda: always(p, 1), "a window has two ends"),  # type: ignore[call-overload]
        (lambda: equal("i", 1), "expected a string or a name, got 1"),
        (lambda: s == "i", r"write equal\(a, b\)"),
        (lambda: x < "1", "a number: expected a number, got '1'"),  # type: ignore[operator]
        (lambda: x < True, "a number: expected a number, got True"),
        (lambda: rise(x + 1), "expected a condition, got <number x \\+ 1>"),  # type: ignore[arg-type]
    ],
)
def test_a_type_error_is_raised_where_it_is_made(mistake: Callable[[], object], says: str) -> None:
    with pytest.raises(TypeError, match=says):
        mistake()


@pytest.mark.parametrize(
    ("mistake", "says"),
    [
        (lambda: eventually(p, 2, 1), "needs a <= b, got 2 to 1"),
        (lambda: eventually(p, 0, 0), "has to end after the trigger, got 0 to 0; for a response at the very instant"),
        (lambda: always(p, 0, 0), "has to end after the trigger, got 0 to 0"),
        (lambda: once(p, -1, 1), "start of a window: expected a finite number of at least 0, got -1"),
        (lambda: once(p, math.inf, math.inf), "start of a window"),
        (lambda: once(p, 0, math.nan), "end of a window"),
        (lambda: (x < 1).hysteresis(-0.1), "a hysteresis"),
        (lambda: (x < 1).held_for(math.inf), "a duration"),
        (lambda: x < math.nan, "a number"),
        (lambda: x < -math.inf, "a number"),
        (lambda: signal("m.ok"), "'m.ok' is not a valid name"),
        (lambda: field("m"), "'' is not a valid name"),
        (lambda: equal(s, "i\nj"), "a string is one line"),
        (lambda: equal(s, "'\""), "at most one kind of quotation marks"),
        (lambda: on("a b"), "'a b' is not a valid name"),
    ],
)
def test_an_invalid_value_is_refused_where_it_is_written(mistake: Callable[[], object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        mistake()
