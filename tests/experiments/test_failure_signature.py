"""Failure signatures: the violated parts of a condition."""

from __future__ import annotations

import pytest

from pytest_hricdv.experiments.failure_signature import FailureSignature, failure_signature, has_signature
from pytest_hricdv.monitor import MonitorSet, Requirement, Verdict, Vocabulary, parse_formula

VOCABULARY = Vocabulary(signals={"moving": bool, "speed": float, "near": bool, "mode": str}, messages={"done": {}})


def judged(text: str, **signals: float | bool | str) -> tuple[Requirement, Verdict]:
    """A requirement, and the verdict on a run in which these are the values from one second on."""
    requirement = Requirement("R", "a title", "", text, parse_formula(text, VOCABULARY))
    monitors = MonitorSet([requirement])
    for name, kind in VOCABULARY.signals.items():
        monitors.signal(0.0, name, kind(0))
    for name, value in signals.items():
        monitors.signal(1.0, name, value)
    (verdict,) = monitors.finish(20.0)
    return requirement, verdict


BOTH = "always(moving -> speed < 2 & !near)"


@pytest.mark.parametrize(
    ("text", "signals", "expected"),
    [
        (BOTH, {"speed": 3.0}, ("speed < 2",)),
        (BOTH, {"near": True}, ("!near",)),
        (BOTH, {"speed": 3.0, "near": True}, ("speed < 2", "!near")),
        ("always(moving -> speed < 2 & previously(near))", {"speed": 1.0}, ("previously(near)",)),
        ("always(moving -> eventually[0:2](on(done) & near))", {"near": True}, ("on(done)", "near")),
        ('always(moving -> mode == "auto" & mode != "manual")', {"mode": "off"}, ('mode == "auto"',)),
        ('always(moving -> mode == "auto" & mode != "manual")', {"mode": "manual"}, None),
        ("always(moving -> speed + 1 < -(2 * speed) / 4 | near)", {"speed": 1.0}, None),
    ],
)
def test_the_signature_has_the_conjuncts_that_were_false(
    text: str, signals: dict[str, float | bool | str], expected: FailureSignature | None
) -> None:
    requirement, verdict = judged(text, moving=True, **signals)
    assert verdict.verdict == "Failed"
    found = failure_signature(requirement, verdict, verdict.violations[0])
    assert " & ".join(found) == " & ".join(expected or (str(requirement.formula.response.condition),))


def test_another_violated_conjunct_is_another_failure() -> None:
    requirement, fast = judged(BOTH, moving=True, speed=3.0)
    _, near = judged(BOTH, moving=True, near=True)
    _, passed = judged(BOTH, moving=True)
    wanted = failure_signature(requirement, fast, fast.violations[0])
    assert has_signature(requirement, wanted, fast)
    assert not has_signature(requirement, wanted, near)
    assert not has_signature(requirement, wanted, passed)
