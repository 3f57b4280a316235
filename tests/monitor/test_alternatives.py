"""Alternatives of a response: by which of them it held, and by which it never did."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.monitor import MonitorSet, Requirement, Vocabulary, load_requirements, parse_formula

VOCABULARY = Vocabulary(signals={"asked": bool, "x": float, "near": bool}, messages={"answer": {"yes": bool}})


def unused(formula: str, *updates: tuple[float, str, bool | float]) -> tuple[str, ...]:
    """The alternatives that never decided, in a run of 9 s in which `asked` is true from 1 s on."""
    monitors = MonitorSet([Requirement("R", "", "", formula, parse_formula(formula, VOCABULARY))])
    for name, first in (("asked", False), ("x", 0.0), ("near", False)):
        monitors.signal(0.0, name, first)
    for time_s, name, value in sorted([*updates, (1.0, "asked", True)], key=lambda update: update[0]):
        if name == "answer":
            monitors.message(time_s, name, {"yes": value})
        else:
            monitors.signal(time_s, name, value)
    return monitors.finish(9.0)[0].vacuous_alternatives


@pytest.mark.parametrize(
    "response", ["x < 1 | near", "always[0:5](x < 1 | near)", "always(x < 1 | near) until on(answer)"]
)
def test_an_alternative_by_which_the_response_never_held_is_told(response: str) -> None:
    formula = f"always(asked -> {response})"
    assert unused(formula) == ("near",)
    assert unused(formula, (2.0, "near", True), (3.0, "x", 2.0)) == ()
    assert unused(formula, (0.5, "x", 2.0), (0.5, "near", True)) == ("x < 1",)


def test_what_guards_a_later_alternative_is_not_passed_by() -> None:
    """The field has no value before the first answer: an alternative behind another one is not read then."""
    formula = "always(asked -> !once(on(answer)) | answer.yes)"
    assert unused(formula) == ("answer.yes",)
    assert unused(formula, (2.0, "answer", True)) == ()


def test_a_response_that_is_no_disjunction_and_one_that_was_not_triggered_have_none() -> None:
    assert unused("always(asked -> x < 1 & (near | !near))") == ()
    assert unused("always(x > 7 -> x < 1 | near)") == ()


def test_an_alternative_is_told_by_the_names_of_its_definitions(tmp_path: Path) -> None:
    """As it was written: what long definitions mean is below the requirement."""
    file = tmp_path / "requirements.toml"
    file.write_text("""
[definitions]
limit = 1
far = "x > limit & !near"
waits = "!on(answer) since far"

[R]
title = "..."
formula = "always(asked -> near | waits & answer.yes | !(far) & previously(far | x > 5) & x > limit & !near & x > 7)"
""")
    requirements = load_requirements(file, VOCABULARY)
    monitors = MonitorSet(requirements)
    for name, value in (("asked", True), ("x", 0.0), ("near", True)):
        monitors.signal(0.0, name, value)
    [verdict] = monitors.finish(1.0)
    assert verdict.vacuous_alternatives == (
        "waits & answer.yes",
        "!far & previously(far | x > 5) & x > 1 & !near & x > 7",
    )
