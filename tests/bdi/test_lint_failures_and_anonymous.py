"""``bdi lint``: plans for failures that nothing can have, and names with ``_`` that are written twice."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi.lint import lint


def _found(tmp_path: Path, check: str, text: str) -> list[tuple[int, str]]:
    (tmp_path / "a.asl").write_text(text, encoding="utf-8")
    (tmp_path / "m.mas2j").write_text("MAS m { agents: a; }", encoding="utf-8")
    return [(f.location.line, f.message) for f in lint([tmp_path / "m.mas2j"]) if f.check == check]


@pytest.mark.parametrize(
    "text",
    [
        "!go.\n-!go <- act.\n+!go <- .wait(500); +done; .print(done).",
        "!go.\n-!go <- act.\n+!go <- .wait({+ready}); !sub. +!sub <- !!other; -ready. +!other.",
        "!go.\n-!go[error(E)] <- act(E).\n+!go <- .wait(ready); !go.",
        "!go(1).\n-!go(X) <- act(X).\n+!go(X) <- if (ready) { +a } else { +b }; for (p(Y)) { .print(Y) }.",
        "!go.\n-!go <- act.\n+!go : ready <- +a. +!go <- .send(a, tell, late).",
    ],
)
def test_plan_for_a_failure_that_cannot_be_is_found(tmp_path: Path, text: str) -> None:
    ((line, message),) = _found(tmp_path, "dead-failure-plan", text)
    assert line == 2
    assert message.endswith("never fails: no statement of its plans can")


@pytest.mark.parametrize(
    "body",
    [
        "act",
        "?ready",
        ".wait({+ready}, 500)",
        "!sub",
        "!nowhere",
        "X = 1; X > 2",
        ".send(ghost, tell, late)",
        ".send(X, tell, late)",
        "+n(X + 1)",
        ".print(X + 1)",
        ".member(1, [2])",
        "!other[hard_deadline(5)]",
        "!other; .fail",
        "B = { act }; B",
        "while (n(N) & N + 1 < 3) { +a }",
        "!X",
    ],
)
def test_plan_for_a_failure_that_may_be_is_not_found(tmp_path: Path, body: str) -> None:
    text = f"!go. -!go <- act. +!go <- {body}. +!sub : ready. +!other."
    assert _found(tmp_path, "dead-failure-plan", text) == []


@pytest.mark.parametrize(
    "text",
    [
        "!go. -!go <- act. +!go : ready <- +a.",
        "!go(1). -!go(X) <- act. +!go(1) <- +a.",
        "!go. -!go <- act. +!go[source(b)] <- +a.",
        "!go. -!go <- act. +!G <- +a.",
        "!go. -!go <- act. +!go <- +a. +b <- .fail_goal(go).",
        "!go. -!go <- act. +!go <- +a. +b <- .add_plan({+!go <- act}).",
    ],
)
def test_goal_without_a_plan_that_is_always_applicable_may_fail(tmp_path: Path, text: str) -> None:
    assert _found(tmp_path, "dead-failure-plan", text) == []


def test_name_with_an_underscore_that_is_written_twice_is_found_at_its_second_place(tmp_path: Path) -> None:
    text = "!go(1, 2).\n+!go(_x, Y)\n   <- ?p(_x); act(Y).\nr(_A) :- q(_A)."
    first, second = _found(tmp_path, "repeated-anonymous", text)
    assert first == (3, "_x is another variable than the _x before it")
    assert second[0] == 4


@pytest.mark.parametrize(
    "text",
    [
        "+!go(_x) <- act. +!stop(_x) <- act.",
        "+!go(_, _) <- act(_).",
        "+!go(_1) <- ?p(_1).",
        '+!go(_x) <- .print("_x"). // _x',
        "+!go(a_x) <- ?p(a_x).",
        "+!go(_x, _y) <- act(1.5).",
    ],
)
def test_name_with_an_underscore_that_is_written_once_is_not_found(tmp_path: Path, text: str) -> None:
    assert _found(tmp_path, "repeated-anonymous", text) == []
