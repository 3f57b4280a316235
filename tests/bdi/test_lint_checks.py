"""``bdi lint``: single checks, with what they find and what they leave alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi.lint import lint


def _found(folder: Path, check: str, text: str) -> list[tuple[int, str]]:
    """The lines and messages of a check; a light is perceived where percepts are what is checked."""
    path = folder / "a.asl"
    path.write_text(text, encoding="utf-8")
    percepts = ("light",) if check == "untested-percept" and "lint:" not in text else ()
    return [(f.location.line, f.message) for f in lint([path], percepts) if f.check == check]


NEVER_FAILS = "never fails: no statement of its plans can"
FOUND = [
    ("dead-failure-plan", "!go.\n-!go <- act.\n+!go <- .wait(500); +done; .print(done).", [(2, NEVER_FAILS)]),
    (
        "dead-failure-plan",
        "!go.\n-!go <- act.\n+!go <- .wait({+ready}); !sub. +!sub <- !!other; -ready. +!other.",
        [(2, NEVER_FAILS)],
    ),
    ("dead-failure-plan", "!go.\n-!go[error(E)] <- act(E).\n+!go <- .wait(ready); !go.", [(2, NEVER_FAILS)]),
    (
        "dead-failure-plan",
        "!go(1).\n-!go(X) <- act(X).\n+!go(X) <- if (ready) { +a } else { +b }; for (p(Y)) { .print(Y) }.",
        [(2, NEVER_FAILS)],
    ),
    (
        "dead-failure-plan",
        "!go.\n-!go <- act.\n+!go : ready <- +a. +!go <- .send(a, tell, late).",
        [(2, NEVER_FAILS)],
    ),
    (
        "repeated-anonymous",
        "!go(1, 2).\n+!go(_x, Y)\n   <- ?p(_x); act(Y).\nr(_A) :- q(_A).",
        [(3, "_x is another variable than the _x before it"), (4, "_A is another variable than the _A before it")],
    ),
    ("not-portable", "!go.\n+!go <- ?größe(X).\ngröße(1).", [(2, "größe ")]),
    ("not-portable", "!go.\n+!go <- +div(1).", [(2, "div ")]),
    ("not-portable", "!go.\n+!go <- act(for).", [(2, "for ")]),
    ("not-portable", "!go.\n+!go <- act(Größe).", [(2, "Größe ")]),
    (
        "untested-percept",
        "!go.\n// lint: percepts whatever, light\n+!go : random <- act.\n+light(on) <- act.",
        [(2, "the percept whatever is declared, and never tested by a")],
    ),
    ("dead-timeout", "!go.\n+!go <- .wait({+ready}, 500, T); act.\n-!go[error(wait_timeout)] <- stop.", [(3, "")]),
    ("dead-timeout", "!go.\n+!go <- act.\n-!go[error(deadline_reached)] <- stop.", [(3, "")]),
]
MAY_FAIL = [
    "act", "?ready", ".wait({+ready}, 500)", "!sub", "!nowhere", "X = 1; X > 2", ".send(ghost, tell, late)",
    ".send(X, tell, late)", "+n(X + 1)", ".print(X + 1)", ".member(1, [2])", "!other[hard_deadline(5)]",
    "!other; .fail", "B = { act }; B", "while (n(N) & N + 1 < 3) { +a }", "!X",
]  # fmt: skip
"""Bodies that may fail, so that a plan for that is none too many."""
NOT_FOUND = {
    "dead-failure-plan": [
        *(f"!go. -!go <- act. +!go <- {body}. +!sub : ready. +!other." for body in MAY_FAIL),
        "!go. -!go <- act. +!go : ready <- +a.",
        "!go(1). -!go(X) <- act. +!go(1) <- +a.",
        "!go. -!go <- act. +!go[source(b)] <- +a.",
        "!go. -!go <- act. +!G <- +a.",
        "!go. -!go <- act. +!go <- +a. +b <- .fail_goal(go).",
        "!go. -!go <- act. +!go <- +a. +b <- .add_plan({+!go <- act}).",
    ],
    "repeated-anonymous": [
        "+!go(_x) <- act. +!stop(_x) <- act.",
        "+!go(_, _) <- act(_).",
        "+!go(_1) <- ?p(_1).",
        '+!go(_x) <- .print("_x"). // _x',
        "+!go(a_x) <- ?p(a_x).",
        "+!go(_x, _y) <- act(1.5).",
    ],
    "not-portable": [
        "begin(1). end(2). divide(3). model(4). notx(5). iff(6). !go. +!go <- act(X, 4 div 2, 5 mod 3).",
        '!go. +!go <- .print("größe"). // größe\n',
        "!go. +!go <- if (true) { act(1) } else { act(2) }; for (.member(X, [1])) { act(X) }.",
        "'größe'(1).",
    ],
    "untested-percept": [
        "+light(on) <- act.",
        "+!go : not light(_) <- act.",
        "+!go <- .wait({+light(on)}); act.",
        "+!go <- .send(b, tell, light).",
        "+!go <- -light(on).",
        "+B[source(percept)] <- act(B).",
        "dark :- not light(on). +!go : dark <- act.",
        "+!go <- .findall(X, light(X), L); act(L).",
    ],
    "dead-timeout": [
        "!go. +!go <- .wait({+ready}, 500); act. -!go[error(wait_timeout)] <- stop.",
        "!go. +!go <- .wait(ready, 500); act. -!go[error(wait_timeout)] <- stop.",
        "!go. +!go <- !do[hard_deadline(50)]. +!do <- act. -!go[error(deadline_reached)] <- stop.",
        "!go. +!go <- .fail(error(wait_timeout)). -!go[error(wait_timeout)] <- stop.",
        "!go. +!go <- act. -!go[error(E)] <- stop(E).",
        "!go. +!go <- act. -!go[error(action_failed)] <- stop.",
        "!go. +!go <- act. -!go <- stop.",
    ],
}
"""By check, what it is about and does not find."""


@pytest.mark.parametrize(("check", "text", "expected"), FOUND)
def test_check_finds(tmp_path: Path, check: str, text: str, expected: list[tuple[int, str]]) -> None:
    found = _found(tmp_path, check, text)
    assert [line for line, _ in found] == [line for line, _ in expected]
    assert all(part in message for (_, message), (_, part) in zip(found, expected, strict=True))


@pytest.mark.parametrize(("check", "text"), [(check, text) for check, texts in NOT_FOUND.items() for text in texts])
def test_check_leaves_alone(tmp_path: Path, check: str, text: str) -> None:
    assert _found(tmp_path, check, text) == []
