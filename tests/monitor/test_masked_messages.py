"""Messages that a requirement does not see, as another one came at the same instant."""

from __future__ import annotations

import pytest

from pytest_hricdv.monitor import Log, Requirement, Vocabulary, evaluate, parse_formula
from tests.monitor.logs import Logged

VOCABULARY = Vocabulary(
    signals={"lamp": bool},
    messages={"state": {"name": str, "turn": float}, "order": {}},
    values={"state.name": ("Idle", "Failed", "Moving")},
)


def run(*said: tuple[float, str, float]) -> Log:
    messages = [Logged(time_s, "state", {"name": name, "turn": turn}) for time_s, name, turn in said]
    return Log({"lamp": ([0.0], [0.0])}, messages, 10.0)


TWICE = run((1.0, "Moving", 1.0), (2.0, "Failed", 1.0), (2.0, "Idle", 1.0), (3.0, "Moving", 2.0), (3.0, "Moving", 2.0))


@pytest.mark.parametrize(
    ("formula", "count"),
    [
        ('always(on(state) & state.name == "Failed" -> lamp)', {"state": 1}),
        ('always(lamp -> eventually[0:3](on(state) & state.name == "Failed"))', {"state": 1}),
        # It sees two messages, and reads nothing that was other, or nothing.
        ('always(on(state) & (state.name == "Failed" | last(state.name) == "Failed") -> lamp)', {}),
        ("always(on(state) & state.turn > 1 -> lamp)", {}),
        ("always(on(state) -> lamp)", {}),
        ("always(on(order) -> lamp)", {}),
        # What holds for a while does so for no time.
        ('always(state.name == "Failed" -> lamp)', {}),
    ],
)
def test_a_message_that_is_not_judged_is_counted(formula: str, count: dict[str, int]) -> None:
    [verdict] = evaluate([Requirement("R1", "", "", formula, parse_formula(formula, VOCABULARY))], TWICE)
    assert verdict.masked_messages == count


def test_of_three_the_first_is_not_seen_even_with_the_one_before() -> None:
    formula = 'always(on(state) & (state.name == "Failed" | last(state.name) == "Failed") -> lamp)'
    requirement = Requirement("R1", "", "", formula, parse_formula(formula, VOCABULARY))
    thrice = run((1.0, "Failed", 1.0), (1.0, "Moving", 1.0), (1.0, "Idle", 1.0))
    [verdict] = evaluate([requirement], thrice)
    assert (verdict.verdict, verdict.masked_messages) == ("NC", {"state": 1})
