"""Internal actions that public models use, and what is said of those that there are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from tests.bdi.models import system_of


@pytest.mark.parametrize(
    ("body", "prints"),
    [
        (".foreach(b(X), { .print(X) })", ["1", "2"]),
        (".foreach(.member(X, [3, 4]), { .print(X); .print(x) })", ["3", "x", "4", "x"]),
        (".if_then_else(b(1), { .print(yes) }, { .print(no) })", ["yes"]),
        (".if_then_else(b(9), { .print(yes) }, { .print(no) })", ["no"]),
        (".if_then_else(b(9), { .print(yes) }); .print(on)", ["on"]),
        (".loop(b(X) & X > 1, { -b(X); .print(X) })", ["2"]),
        (".copy_term(f(X, Y, X), f(1, 2, A)); .print(A)", ["1"]),
        (".copy_term(f(X), Z); X = 1; Z = f(2); .print(X, Z)", ["1f(2)"]),
        ("Y = 3; .copy_term(f(Y, X), Z); Z = f(A, b); .print(A)", ["3"]),
        (".wait(1234); .time(H, M, S, Ms); .print(H, M, S); .print(Ms)", ["001", "234"]),
        (".verbose(2); .print(on)", ["on"]),
    ],
)
def test_action_does_what_jason_does(tmp_path: Path, body: str, prints: list[str]) -> None:
    result = system_of(tmp_path, a=f"b(1). b(2). !go. +!go <- {body}.").run()
    assert [line.removeprefix("[a] ") for line in result.prints] == prints


def test_verbosity_is_ignored_with_a_warning(tmp_path: Path) -> None:
    result = system_of(tmp_path, a="!go. +!go <- .verbose(2).").run()
    (warning,) = result.warnings
    assert warning.endswith("a.asl:1:14: ignored: .verbose(2)")


@pytest.mark.parametrize(
    ("call", "advice"),
    [
        (".foreach(1)", "unknown internal action .foreach; use for (condition) { ... }"),
        (".if_then_else(1)", "use if (condition) { ... } else { ... }"),
        (".create_agent(b, x)", "agents are those of the project file"),
        (".kill_agent(b)", "the run ends with .stopMAS"),
        (".set.create(S)", "use a list with .member"),
        (".df_search(s, L)", "agents tell each other what they offer"),
        (".sleep(3)", "use .wait(milliseconds)"),
        ("X = math.mean([1])", "use math.average"),
        ('gui.yes_no("ok?")', "gui.yes_no is an internal action in Java"),
        ("jia.move_to(X)", "an external action jia_move_to(...) of a Python environment"),
        (".prnt(x)", "did you mean .print"),
        ("X = math.sqr(4)", "did you mean math.sqrt"),
        (".qqq", "known are .abolish"),
    ],
)
def test_unknown_action_says_what_it_is_and_what_to_write_instead(tmp_path: Path, call: str, advice: str) -> None:
    with pytest.raises(BdiError) as caught:
        system_of(tmp_path, a=f"!go.\n+!go <- {call}.")
    assert "a.asl:2:" in str(caught.value)
    assert advice in str(caught.value)
    assert "value_by_rule" not in str(caught.value)
