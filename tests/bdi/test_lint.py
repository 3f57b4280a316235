"""Lint: what seems wrong in models is found where it is, and nothing else is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.__main__ import main
from pytest_hricdv.bdi.lint import CHECKS, Mistake, lint
from tests.bdi.models import TABLE, system_of

MODELS = TABLE.parent


def _lint(folder: Path, **sources: str) -> list[Mistake]:
    system_of(folder, **sources)
    return lint([folder / "mas.mas2j"])


def _found(folder: Path, **sources: str) -> list[str]:
    """The findings as ``file:line:column check``."""
    return [
        f"{Path(finding.location.file).name}:{finding.location.line}:{finding.location.column} {finding.check}"
        for finding in _lint(folder, **sources)
    ]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        # beliefs
        ("!go. +!go : ready <- act.", ["a.asl:1:13 unknown-belief"]),
        ("!go. +!go : not ready <- act.", ["a.asl:1:17 unknown-belief"]),
        ("!go. +!go <- if (ready) { act }.", ["a.asl:1:18 unknown-belief"]),
        ("!go. +!go <- .findall(X, ready(X) & X > 1, L); show(L).", ["a.asl:1:26 unknown-belief"]),
        ("!go. +!go <- ?ready; act.", ["a.asl:1:15 unknown-belief"]),
        ("p :- ready. !go. +!go : p <- act.", ["a.asl:1:6 unknown-belief"]),
        ("+ready <- act.", ["a.asl:1:2 unknown-belief"]),
        ("ready. !go. +!go : ready(1) <- act.", ["a.asl:1:20 unknown-belief"]),
        ("ready. !go. +!go : ~ready <- act.", ["a.asl:1:21 unknown-belief"]),
        ("ready. !go. +!go : ready & not lost <- +lost.", []),
        ("!go. +!go <- -+n(1); ?n(X); act(X).", []),
        ("!go. +!go <- ?sum(1, X); act(X). +?sum(A, B) <- B = A.", []),
        ("!go. +!go : true & not false <- act.", []),
        ("+light(X)[source(percept)] <- act(X).", []),
        ("// lint: percepts light, sound\n+light <- act. +sound <- act.", []),
        ("!go. +!go <- B = p(1); +B; ?p(X); act(X).", []),
        # goals
        ("!go.", ["a.asl:1:2 goal-without-plan"]),
        ("!go. +!go <- !walk; !!run.", ["a.asl:1:15 goal-without-plan", "a.asl:1:23 goal-without-plan"]),
        ("!go(1). +!go(2).", ["a.asl:1:2 goal-without-plan"]),
        ("!go(1). +!go <- act.", ["a.asl:1:2 goal-without-plan"]),
        ("!go(3). +!go(0). +!go(N) <- !go(N - 1).", []),
        ("!go. +!G <- act(G).", []),
        ("!go. +!go <- .add_plan({ +!new <- act }); !new.", []),
        ("!go. +!go[source(self)] <- act.", []),
        # shadowed plans
        ("!go. +!go <- a.\n+!go <- b.", ["a.asl:2:1 shadowed-plan"]),
        ("!go. +!go : true <- a.\n@x +!go : p <- b. p.", ["a.asl:2:1 shadowed-plan"]),
        ("p. q. !go. +!go : p <- a.\n+!go : q & p <- b.", ["a.asl:2:1 shadowed-plan"]),
        ("n(1). !go(1). +!go(X) : n(Y) & Y > X <- a.\n+!go(A) : n(B) & B > A <- b.", ["a.asl:2:1 shadowed-plan"]),
        ("!go(1). +!go(X) <- a(X).\n+!go(1) <- b.", ["a.asl:2:1 shadowed-plan"]),
        ("p. q. !go. +!go : p & q <- a. +!go : p <- b. +!go <- c.", []),
        ("!go(1). +!go(1) <- a. +!go(X) <- b(X).", []),
        ("!go(1,2). +!go(X,X) <- a(X). +!go(X,Y) <- b(X,Y).", []),
        ("!go. +!go : .random(X) & X < 0.5 <- a. +!go : .random(X) & X < 0.5 <- b. +!go <- c.", []),
        ("!go. +!go[source(bob)] <- a. +!go <- b.", []),
        # unbound variables
        ("!go. +!go : X > 3 <- act.", ["a.asl:1:13 unbound-comparison"]),
        ("p(1). !go. +!go : p(X) & Y < X <- act.", ["a.asl:1:26 unbound-comparison"]),
        ("!go. +!go <- X = Y + 1; act(X).", ["a.asl:1:18 unbound-comparison"]),
        ("p(1). !go. +!go <- for (p(X)) { act }; if (X == 1) { act }.", ["a.asl:1:44 unbound-comparison"]),
        ("p(1). !go. +!go : not (p(X) & X > 1) & X > 2 <- act.", ["a.asl:1:26 unbound-comparison"]),
        ("!go. +!go <- -+n(X + 1).", ["a.asl:1:18 unbound-comparison"]),
        ("p(1). !go. +!go <- X = .count(p(_)) + 1; act(X); if (.count(p(_)) > 1) { act }.", []),
        ("big(X) :- X > 9 & Y > 9. !go. +!go : big(10) <- act.", ["a.asl:1:19 unbound-comparison"]),
        (
            "p(1). !go. +!go : p(X) & Y = X + 1 & Y > 1 <- Z = Y; Z < 9; .length([], N); N == 0; !sub(M); M > 1.\n"
            "+!sub(1).",
            [],
        ),
        ("!go. +!go <- for (.range(I, 1, 3)) { if (I > 1) { act } }.", []),
        # deletions
        ("!go. +!go <- +p; -p[source(bob)].", ["a.asl:1:19 unmatched-deletion"]),
        ("!go. +!go <- -p.", ["a.asl:1:15 unmatched-deletion"]),
        ("+p[source(percept)] <- -p.", ["a.asl:1:25 unmatched-deletion"]),
        ("+p[source(percept)] <- -p[source(percept)].", []),
        ("!go. +!go <- +p(1); -p(_); .abolish(p(_)).", []),
        ("!go. +!go <- .abolish(q(_)).", ["a.asl:1:23 unmatched-deletion"]),
        # spins
        ("!w. x. +!w : x <- !w.", ["a.asl:1:8 endless-spin"]),
        ("!w. +!w <- !w.", ["a.asl:1:5 endless-spin"]),
        ("!w. +!w <- .wait(10); !w.", ["a.asl:1:5 endless-spin"]),
        ("x. !w. +!w <- while (x) { .wait(5) }.", ["a.asl:1:15 endless-spin"]),
        ("!w. +!w : not x <- !w. +!w. !s. +!s <- +x.", []),
        ("x. !w. +!w : x <- !w. +!w. !s. +!s <- -x.", []),
        ("!w. +!w <- !w. !s. +!s <- .wait(50); .drop_intention(w).", []),
        ("+x[source(percept)]. !w. +!w : x <- act. +!w <- !w.", []),
        # names
        ("ready. !go. +!go : redy <- act.", ["a.asl:1:1 near-name", "a.asl:1:20 near-name"]),
        ("!go. +!go <- !walk. +!wlak <- act.", ["a.asl:1:15 near-name"]),
        ("leg1. !go. +!go : leg2 <- act.", ["a.asl:1:19 unknown-belief"]),
    ],
)
def test_single_agent(tmp_path: Path, source: str, expected: list[str]) -> None:
    assert _found(tmp_path, a=source) == expected


@pytest.mark.parametrize(
    ("ann", "bob", "expected"),
    [
        ("!go. +!go <- .send(bob, tell, hi(1)).", "+hi(X)[source(ann)] <- act(X); -hi(X)[source(ann)].", []),
        ("!go. +!go <- .send(bob, tell, hi(1)).", "+hi(X) <- act(X); -hi(X).", ["bob.asl:1:20 unmatched-deletion"]),
        ("!go. +!go <- .send(bob, tell, hi).", "+hi[source(cid)] <- act.", ["bob.asl:1:2 unknown-belief"]),
        ("!go. +!go <- .broadcast(tell, hi).", "+hi <- act.", []),
        ("!go. +!go <- .send([bob], tell, [hi, ho]).", "+hi : ho <- act.", []),
        ("p(hi). !go. +!go : p(X) <- .send(bob, tell, X).", "+hi : ho[source(ann)] <- act.", []),
        ("!go. +!go <- .send(bob, achieve, dance).", "+!dance <- act.", []),
        ("!go. +!go <- .send(bob, achieve, dance).", "", ["ann.asl:1:14 goal-without-plan"]),
        ("!go. +!go <- .send(bob, achieve, dance).", "+!dnace <- act.", ["ann.asl:1:14 near-name"]),
        (
            "!go. +!go <- .send(bob, tell, ready).",
            "+raedy <- act.",
            ["ann.asl:1:14 near-name", "bob.asl:1:2 near-name"],
        ),
        ("!go. +!go <- .send(boob, tell, hi).", "", ["ann.asl:1:14 near-name"]),
        ("!go. +!go <- .send(someone, tell, hi).", "", ["ann.asl:1:14 unknown-agent"]),
        ("!go(bob). +!go(S) <- .send(S, achieve, dance).", "+!dance <- act.", []),
        ("!go(bob). +!go(S) <- .send(S, achieve, dance).", "", ["ann.asl:1:22 goal-without-plan"]),
        ("!go. +!go <- .broadcast(achieve, dance).", "+!dance <- act.", []),
        ("!go. +!go <- .send(bob, tellHow, P); .send(bob, achieve, dance).", "", []),
        ("!go. +!go <- .send(bob, askOne, price(X)). +price(X) <- act(X).", "price(3).", []),
        ("!go. +!go <- .send(bob, tell, x); .send(bob, untell, x).", "!w. +!w : x <- !w. +!w <- !w.", []),
        ("!go. +!go <- .wait(50); .send(bob, unachieve, w).", "!w. +!w <- !w.", []),
    ],
)
def test_two_agents_know_what_they_tell_each_other(tmp_path: Path, ann: str, bob: str, expected: list[str]) -> None:
    assert _found(tmp_path, ann=ann, bob=bob) == expected


def test_source_on_its_own_may_be_told_things_by_others(tmp_path: Path) -> None:
    (tmp_path / "a.asl").write_text("+hi[source(bob)] <- -hi[source(bob)]; .send(bob, tell, ho).\n+ho <- act.")
    assert [(finding.check, finding.location.line) for finding in lint([tmp_path / "a.asl"])] == [("unknown-belief", 2)]


def test_finding_shows_place_line_caret_and_reason(tmp_path: Path) -> None:
    (finding,) = _lint(tmp_path, a="!go.\n+!go : ready <- act.")
    assert str(finding) == (
        f"{tmp_path / 'a.asl'}:2:8: unknown-belief: ready/0 is never added to the beliefs of a\n"
        "    +!go : ready <- act.\n"
        "           ^\n"
        "    It never holds: a condition on it always has the same result, and a plan for it never runs."
    )


@pytest.mark.parametrize(
    "source",
    [
        "!go.\n+!go : ready <- act. // lint: ignore unknown-belief the environment will say so one day",
        "!go.\n// lint: ignore unknown-belief the environment will say so one day\n+!go : ready <- act.",
    ],
)
def test_finding_can_be_justified_in_its_line_or_above(tmp_path: Path, source: str) -> None:
    assert _found(tmp_path, a=source) == []


@pytest.mark.parametrize(
    ("remark", "message"),
    [
        ("ignore unknown-belief", "expected a reason to ignore unknown-belief"),
        ("ignore unknown-beleif why", "expected the name of a check to ignore, one of dead-failure-plan"),
        ("ignore", "expected the name of a check"),
        ("off", "expected 'lint: ignore NAME why' or 'lint: percepts name, ...'"),
        ("percepts", "expected 'lint: ignore"),
    ],
)
def test_remark_that_makes_no_sense_is_a_finding(tmp_path: Path, remark: str, message: str) -> None:
    findings = _lint(tmp_path, a=f"p. // lint: {remark}\n!go. +!go : p <- act.")
    assert [finding.check for finding in findings] == ["bad-remark"]
    assert findings[0].message.startswith(message)


def test_every_check_has_its_row_in_the_documentation() -> None:
    page = (TABLE.parents[1] / "docs" / "writing-models.md").read_text(encoding="utf-8")
    table = page.partition("| check | finds |")[2].partition("\n\n")[0]
    assert sorted(re.findall(r"^\| `([a-z0-9-]+)` \|", table, re.MULTILINE)) == sorted(check.name for check in CHECKS)


def test_every_check_says_why_in_one_sentence() -> None:
    for check in CHECKS:
        assert re.fullmatch(r"[A-Z].*[.]", check.why)


def test_table_models_are_clean() -> None:
    assert lint([TABLE]) == []


@pytest.mark.parametrize(
    ("file", "old", "new", "expected"),
    [
        ("human.asl", "+!request : leg3", "+!request : lleg3", {"near-name"}),
        ("human.asl", "-bored[source(meta)]", "-bored", {"unmatched-deletion"}),
        ("human.asl", "-leg_released[source(robot_code)]", "-leg_released", {"unmatched-deletion"}),
        ("human.asl", "tell, human_ready", "tell, human_redy", {"near-name", "unmatched-deletion"}),
        ("robot_code.asl", "!announce.", "!anounce.", {"near-name"}),
        ("robot_code.asl", "+leg_wanted[source(human)]", "+leg_wanted[source(sensors)]", {"unknown-belief"}),
        ("robot_code.asl", "+!hear_ready : clock(S)\n", "+!hear_ready : clock(T)\n", {"unbound-comparison"}),
        ("sensors.asl", " : pose(0, 0, 0)", "", {"shadowed-plan"}),
    ],
)
def test_mistakes_in_the_table_models_are_found(
    tmp_path: Path, file: str, old: str, new: str, expected: set[str]
) -> None:
    for model in MODELS.iterdir():
        (tmp_path / model.name).write_text(model.read_text(encoding="utf-8"), encoding="utf-8")
    text = (tmp_path / file).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    assert {finding.check for finding in lint([tmp_path / TABLE.name])} == expected


def test_command_prints_findings_and_tells_by_its_exit_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    system_of(tmp_path, a="!go. +!go <- !walk; !run.")
    assert main(["lint", str(tmp_path / "mas.mas2j")]) == 1
    out, err = capsys.readouterr()
    assert out.count("goal-without-plan") == 2
    assert err == "2 findings\n"
    assert main(["lint", str(TABLE)]) == 0
    out, err = capsys.readouterr()
    assert (out, err.splitlines()[1:]) == ("", ["nothing found"])
    assert err.startswith("note: external actions bored, close_hand, ")


@pytest.mark.parametrize("name", ["missing.mas2j", "missing.asl", "broken.asl"])
def test_file_that_cannot_be_read_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    (tmp_path / "broken.asl").write_text("+!go <- .prnt(1).")
    with pytest.raises(BdiError):
        lint([tmp_path / name])
    assert main(["lint", str(tmp_path / name)]) == 2
    assert capsys.readouterr().err.startswith("error: ")
