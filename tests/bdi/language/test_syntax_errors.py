"""What cannot be read is reported with its place, the line, and a caret."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError, BdiSyntaxError, MultiAgentSystem
from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.lint import lint
from tests.bdi.models import system_of


def _error(text: str) -> str:
    with pytest.raises(BdiSyntaxError) as caught:
        parse_program(text, "human.asl")
    return str(caught.value)


def test_message_shows_place_line_and_a_caret_under_the_column() -> None:
    assert _error("started.\n\n!go <- tell(leg).") == (
        "human.asl:3:5: expected '.', found '<-'\n    !go <- tell(leg).\n        ^"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("+!a <- b\n+!c <- d.", "human.asl:2:1: expected '.' before the next plan, found '+!'"),
        ("+!a <- b", "human.asl:1:9: expected '.' or ';', found the end of the file"),
        ("+!a <- f(b, c.", "human.asl:1:14: expected ',' or ')', found '.'"),
        ("+!a <- b;; c.", "human.asl:1:10: expected a statement, found ';'"),
        ('p("never closed).', "human.asl:1:3: a string that is not closed"),
        ("p. /* never closed", "human.asl:1:4: a comment that is not closed"),
        ("p(X) :- .", "human.asl:1:9: expected a term or condition, found '.'"),
        ("+!a : 3 <- b.", "human.asl:1:5: expected a condition or an action, found 3"),
        ("+!a : X > (b & c) <- d.", "human.asl:1:7: expected a term, found the condition (b & c)"),
        ("@l(1) +!a.", "human.asl:1:1: expected a name as a plan's label, found l(1)"),
        ("@one @two +!a.", "human.asl:1:6: expected an event such as +!g or -b, found '@'"),
        ("+!a <- if b { c }.", "human.asl:1:11: expected '(', found 'b'"),
        ("^?a <- b.", "human.asl:1:2: expected '!', found '?'"),
        (
            "p(^a).",
            "human.asl:1:3: expected a term or condition, found '^'; an event of a goal's state is written "
            "^!g[state(S)]",
        ),
        (
            "p('x).",
            'human.asl:1:3: unexpected character "\'"; strings are in double quotes, names with other characters in '
            "single quotes, on one line",
        ),
        ("p(é).", "human.asl:1:3: unexpected character 'é'"),
        (
            "+!a <- .b\n  .c.",
            "human.asl:2:3: expected '.' or ';', found '.c'; a ';' is missing between two statements",
        ),
        ("p(1).q(2).", "human.asl:1:5: expected '.', found '.q'; a full stop needs a space after it"),
        ("+!a <- b, c.", "human.asl:1:9: expected '.' or ';', found ','; statements are separated by ';'"),
        ("p(X) :- q(X), r(X).", "human.asl:1:13: expected '.', found ','; conditions are joined by '&'"),
        ("+!a : b != c.", "human.asl:1:9: expected '.', found '!'; unequal is '\\=='"),
        ("+!a <- X is 3.", "human.asl:1:10: expected '.' or ';', found 'is'; values are given with '='"),
        ("{ begin bc(g) }", "human.asl:1:16: expected a belief, goal or plan, found the end of the file"),
        ("# a", "human.asl:1:1: unexpected character '#'; comments begin with '//'"),
    ],
)
def test_message_says_what_was_expected_and_what_came(text: str, message: str) -> None:
    assert _error(text).splitlines()[0] == message


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (".prnt(1)", r"a\.asl:1:8: unknown internal action \.prnt; did you mean \.print"),
        ("X = math.sqr(4)", r"a\.asl:1:12: unknown internal action math\.sqr; did you mean math\.sqrt"),
        ("a; .nth(1, [])", r"a\.asl:1:11: \.nth takes 3 arguments, found 2: \.nth\(1,\[\]\)"),
        ("if (.membr(X, [1])) { a }", r"a\.asl:1:12: unknown internal action \.membr; did you mean \.member"),
    ],
)
def test_unknown_or_misused_internal_action_is_named_with_its_place(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(BdiError, match=message):
        system_of(tmp_path, a=f"+!g <- {body}.")


def test_text_that_is_not_utf8_is_an_error_at_its_first_bad_byte(tmp_path: Path) -> None:
    (tmp_path / "mas.mas2j").write_text("MAS m { agents: ann; }")
    (tmp_path / "ann.asl").write_bytes(b"p.\nq(\xff).")
    with pytest.raises(BdiError, match=r"ann\.asl:2:3: .*: .*ann\.asl:2:3: not UTF-8 text: byte 0xff"):
        MultiAgentSystem.load(tmp_path / "mas.mas2j")


@pytest.mark.parametrize("text", ["+!go <- .print(1) .print(2).", "+!go <- .print(1", "p(1.", "+!go : & p <- q."])
def test_a_mistake_in_latin_1_is_shown_where_it_is_with_the_encoding(tmp_path: Path, text: str) -> None:
    (tmp_path / "mas.mas2j").write_text("MAS m { agents: ann; }")
    (tmp_path / "ann.asl").write_text(f"// x\n\n\n{text}")
    with pytest.raises(BdiSyntaxError) as in_ascii:
        MultiAgentSystem.load(tmp_path / "mas.mas2j")
    (tmp_path / "ann.asl").write_bytes(f"// ü\n\n\n{text}".encode("latin-1"))
    with pytest.raises(BdiSyntaxError) as in_latin_1:
        MultiAgentSystem.load(tmp_path / "mas.mas2j")
    expected, shown = in_ascii.value, in_latin_1.value
    assert (shown.line, shown.column, shown.source_line) == (expected.line, expected.column, expected.source_line)
    encoding = f"{tmp_path / 'ann.asl'}:1:4: not UTF-8 text: byte 0xfc"
    assert shown.message == f"{expected.message}; the file is read as Latin-1: {encoding}"


def test_text_in_latin_1_is_read_with_a_warning(tmp_path: Path) -> None:
    (tmp_path / "mas.mas2j").write_bytes("MAS m { agents: ann; /* Größe */ }".encode("latin-1"))
    (tmp_path / "ann.asl").write_bytes('!go. // Übung\n+!go <- .print("Größe"). { include("b.asl") }'.encode("latin-1"))
    (tmp_path / "b.asl").write_bytes(b"// caf\xe9\nb.")
    system = MultiAgentSystem.load(tmp_path / "mas.mas2j")
    assert [warning.removeprefix(f"{tmp_path}/") for warning in system.warnings] == [
        "mas.mas2j:1:27: not UTF-8 text: byte 0xf6: read as Latin-1",
        "ann.asl:1:9: not UTF-8 text: byte 0xdc: read as Latin-1",
        "b.asl:1:7: not UTF-8 text: byte 0xe9: read as Latin-1",
    ]
    assert system.run().prints == ["[ann] Größe"]
    (finding,) = [finding for finding in lint([tmp_path / "mas.mas2j"]) if finding.check == "not-utf8"]
    assert (finding.location.line, finding.location.column) == (1, 9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "1:1: expected 'MAS', found the end of the file"),
        ("MAS m { agents: }", "1:9: a project needs agents"),
        ("MAS m { }", "1:1: a project needs agents"),
        ("MAS m { agents: ann }", "1:21: expected ';', found '}'"),
        ("MAS m { agent: ann; }", "1:9: expected one of .*agents.*, found 'agent'"),
        ("MAS m { agents: ann; ann; }", "1:22: a second agent named ann"),
        ("MAS m { agents: ann; } more", "1:24: expected the end of the file, found 'more'"),
        ("MAS m { agents: ann %; }", "1:21: unexpected character '%'"),
    ],
)
def test_project_that_cannot_be_read_is_a_located_error(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "ann.asl").write_text("p.")
    (tmp_path / "mas.mas2j").write_text(text)
    with pytest.raises(BdiSyntaxError, match=rf"mas\.mas2j:{message}"):
        MultiAgentSystem.load(tmp_path / "mas.mas2j")
