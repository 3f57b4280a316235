"""``bdi lint``: names that no Jason reads, percepts that nobody tests, time-outs that never come."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi.lint import lint


def _checks(tmp_path: Path, text: str, percepts: tuple[str, ...] = ()) -> list[tuple[str, int, str]]:
    path = tmp_path / "a.asl"
    path.write_text(text, encoding="utf-8")
    wanted = ("not-portable", "untested-percept", "dead-timeout")
    return [(f.check, f.location.line, f.message) for f in lint([path], percepts) if f.check in wanted]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("!go.\n+!go <- ?größe(X).\ngröße(1).", "größe"),
        ("!go.\n+!go <- +div(1).", "div"),
        ("!go.\n+!go <- act(for).", "for"),
        ("!go.\n+!go <- act(Größe).", "Größe"),
    ],
)
def test_name_that_no_jason_reads_is_found(tmp_path: Path, text: str, name: str) -> None:
    ((check, _, message),) = _checks(tmp_path, text)
    assert (check, message.split()[0]) == ("not-portable", name)


@pytest.mark.parametrize(
    "text",
    [
        "begin(1). end(2). divide(3). model(4). notx(5). iff(6). !go. +!go <- act(X, 4 div 2, 5 mod 3).",
        '!go. +!go <- .print("größe"). // größe\n',
        "!go. +!go <- if (true) { act(1) } else { act(2) }; for (.member(X, [1])) { act(X) }.",
        "'größe'(1).",
    ],
)
def test_names_that_jason_reads_are_not_found(tmp_path: Path, text: str) -> None:
    assert _checks(tmp_path, text) == []


def test_percept_that_is_declared_and_never_tested_is_found_where_it_is_declared(tmp_path: Path) -> None:
    text = "!go.\n// lint: percepts whatever, light\n+!go : random <- act.\n+light(on) <- act."
    ((check, line, message),) = _checks(tmp_path, text)
    assert (check, line) == ("untested-percept", 2)
    assert message == "the percept whatever is declared, and never tested by a"


@pytest.mark.parametrize(
    "text",
    [
        "+light(on) <- act.",
        "+!go : not light(_) <- act.",
        "+!go <- .wait({+light(on)}); act.",
        "+!go <- .send(b, tell, light).",
        "+!go <- -light(on).",
        "+B[source(percept)] <- act(B).",
        "dark :- not light(on). +!go : dark <- act.",
        "+!go <- .findall(X, light(X), L); act(L).",
    ],
)
def test_percept_that_is_tested_anyhow_is_not_found(tmp_path: Path, text: str) -> None:
    assert _checks(tmp_path, text, ("light",)) == []


def test_plan_for_a_timeout_that_never_comes_is_found(tmp_path: Path) -> None:
    text = "!go.\n+!go <- .wait({+ready}, 500, T); act.\n-!go[error(wait_timeout)] <- stop."
    ((check, line, _),) = _checks(tmp_path, text)
    assert (check, line) == ("dead-timeout", 3)
    ((check, line, _),) = _checks(tmp_path, "!go.\n+!go <- act.\n-!go[error(deadline_reached)] <- stop.")
    assert (check, line) == ("dead-timeout", 3)


@pytest.mark.parametrize(
    "text",
    [
        "!go. +!go <- .wait({+ready}, 500); act. -!go[error(wait_timeout)] <- stop.",
        "!go. +!go <- .wait(ready, 500); act. -!go[error(wait_timeout)] <- stop.",
        "!go. +!go <- !do[hard_deadline(50)]. +!do <- act. -!go[error(deadline_reached)] <- stop.",
        "!go. +!go <- .fail(error(wait_timeout)). -!go[error(wait_timeout)] <- stop.",
        "!go. +!go <- act. -!go[error(E)] <- stop(E).",
        "!go. +!go <- act. -!go[error(action_failed)] <- stop.",
        "!go. +!go <- act. -!go <- stop.",
    ],
)
def test_plan_for_a_timeout_that_may_come_is_not_found(tmp_path: Path, text: str) -> None:
    assert _checks(tmp_path, text) == []
