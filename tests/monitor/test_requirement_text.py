"""Errors in requirement files and formulas: the place, what was expected, what was found, what to do."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import pytest_hricdv.monitor
from pytest_hricdv.monitor import (
    RequirementError,
    Vocabulary,
    load_requirements,
    parse_condition,
    parse_formula,
)
from pytest_hricdv.monitor.vocabulary import KEYWORDS
from tests.monitor.vocabulary import R1, R3, R4, REQUIREMENTS_FILE, SMALL, TABLE, marked


@pytest.mark.parametrize(
    ("text", "mark", "says"),
    [
        ("", "", "the formula is empty"),
        ("always(p)", ")", "a requirement says when it applies: always(antecedent -> response)"),
        ("eventually[0:1](p)", "eventually", "always(antecedent -> response)"),
        ("always(p -> q", "", "ends too early"),
        ("always(p -> q))", ")", "expected the end of the formula"),
        ("always(p and q -> q)", "and", "a conjunction is written `&`"),
        ("always(p && q -> q)", "&", "written with one `&`"),
        ("always(x = 1 -> q)", "=", "equality is written `==`"),
        ("always(p -> q -> p)", "->", "one `->`"),
        ("always(p -> q & eventually[0:1](p))", "eventually", "only at the top of the response"),
        ("always(p -> eventually[0:1](p) until q)", "until", "always(f) until g"),
        ("always(p -> 0 < x < 1)", "<", "expected"),
        ("always(p [for 1] -> q)", "[", "follow a comparison"),
        ("always(pp -> q)", "pp", "unknown name 'pp'"),
        ("always(m.okay -> q)", "m.okay", "unknown name 'm.okay'; nearest: m.ok"),
        ("always(a -> q)", "a", "a is a topic: `on(a)`"),
        ("always(on(p) -> q)", "p", "p is a signal; on(...) takes a topic"),
        ("always(on(c) -> q)", "c", "unknown topic 'c'; known: a, b, m, n, w"),
        ("always(x -> q)", "x", "expected a condition, but x is a float"),
        ("always(p < 1 -> q)", "p", "expected a number, but p is a bool"),
        ("always((p & q) < 1 -> q)", "p & q", "expected a number, but this is a condition"),
        ("always(p -> eventually[2:1](q))", "[2:1]", "needs a <= b"),
        ("always(p -> eventually[0:0](q))", "[0:0]", "has to end after the trigger"),
        ("always(p -> x == 1 [hysteresis 1])", "==", "a bound with two sides"),
        ("always(p -> x < 1 [for 1][for 2])", "[for 2]", "given twice"),
        ("always(p -> on(a))", "on(a)", "did you mean `eventually[0:d](...)`?"),
        ("always(p -> always[0:1](rise(q)))", "rise(q)", "single instants only"),
        ("always(previously(on(a)) -> q)", "on(a)", "once[0:d](...)"),
        ("always(historically[0:1](on(a)) -> q)", "on(a)", "single instants only"),
        ("always(x < 1e999 -> q)", "1e999", "too large"),
        (
            "always(x == 9007199254740993 -> q)",
            "9007199254740993",
            "too many digits for a float, which is 9007199254740992",
        ),
        ("always(count(p) -> q)", "count(p)", "expected a condition, but this is a number"),
        ("always(count(p) < 1 [hysteresis 1] -> q)", "1", "counts and times have no noise"),
        ("always(time_between(p) < 1 -> q)", ")", "expected"),
        ("always(time_between < 1 -> q)", "time_between", "unknown name 'time_between'"),
        ("always(time_between(p, q) < time_since(p) -> q)", "time_between(p, q)", "compared with a number of seconds"),
        ("always(x < count(p) [for 1 -> q)", "->", "expected ]"),
        ("always(time_since(p) < x -> q)", "x", "a time_since is compared with a number of seconds"),
        ("always(time_since(p) < time_since(q) -> q)", "time_since(q)", "compared with a number of seconds"),
        ("always(1 + time_since(p) < 3 -> q)", "time_since(p)", "compared with a number of seconds, as in"),
        ("always(time_since(p) == 3 -> q)", "==", "changes all the time: compare it with < <= > >="),
        ("always(time_since(p) < 3 [for 1] -> q)", "[for 1]", "no [hysteresis] and no [for]"),
        ("always(last(x) < 3 -> q)", "x", "expected a field of a message, but x is a signal"),
        ("always(last(m.lvel) < 3 -> q)", "last(m.lvel)", "unknown name 'm.lvel'; nearest: m.level"),
        ("always(last(w) == 'l' -> q)", "'l'", "last(w.name) is never 'l'"),
        ("always(s -> q)", "s", "expected a condition, but s is a str"),
        ("always(s < 'i' -> q)", "<", "strings are compared with == or !="),
        ("always(s == 1 -> q)", "1", "expected a string, but this is a number"),
        ("always('i' == (x) -> q)", "x", "expected a string, but x is a float"),
        ("always(p == s -> q)", "p", "expected a string, but p is a bool"),
        ("always(x + s < 1 -> q)", "s", "expected a number, but s is a str"),
        ("always(s == 'i' [hysteresis 1] -> q)", "==", "a bound with two sides"),
        ("always(s == i -> q)", "i", 'a string is written in quotation marks: "i"'),
        ("always(s == 'i -> q)", "'", "a string ends with the quotation mark"),
        ("always(w.name == 'jj' -> q)", "'jj'", "w.name is never 'jj'; nearest: j"),
        ("always('l' != w -> q)", "'l'", "w.name is never 'l'; known: i, j, k"),
        ("always(m == 1 -> q)", "m", "m is a topic: `on(m)`"),
    ],
)
def test_an_error_points_at_its_place(text: str, mark: str, says: str) -> None:
    with pytest.raises(RequirementError) as caught:
        parse_formula(text, SMALL)
    assert says in str(caught.value)
    assert not mark or marked(caught.value) == mark


def test_lark_is_imported_only_for_a_formula() -> None:
    script = "import sys, pytest_hricdv.monitor; sys.exit('lark' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0


def test_an_error_in_a_file_names_file_requirement_line_and_column(tmp_path: Path) -> None:
    file = tmp_path / "requirements.toml"
    file.write_text(
        '[R1]\ntitle = "One"\nformula = "always(p -> q)"\n\n'
        '[R2]\ntitle = "Two"\nformula = """\nalways(p\n       -> height < 1)"""\n'
    )
    with pytest.raises(RequirementError) as caught:
        load_requirements(file, SMALL)
    assert str(caught.value) == (
        f"{file}:9:11: requirement R2, line 2, column 11 of the formula: "
        "unknown name 'height'; known: p, q, x, y, s, m.ok, m.level, n.level, w.name\n"
        "           -> height < 1)\n"
        "              ^^^^^^"
    )


def test_a_formula_written_with_escapes_is_located_by_its_own_columns(tmp_path: Path) -> None:
    file = tmp_path / "requirements.toml"
    file.write_text('[R1]\ntitle = "One"\nformula = "always(\\u0070p -> q)"\n')
    with pytest.raises(RequirementError, match=r"requirements\.toml: requirement R1, column 8: unknown name 'pp'"):
        load_requirements(file, SMALL)


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ("", "no requirement in this file"),
        ("[R1", "not TOML"),
        ('title = "x"', "'title' is outside of a requirement"),
        ('[" "]\ntitle = "x"', "requirement ' ' has no name"),
        ('[R1]\ntitle = "x"', "requirement R1: no 'formula'"),
        ('[R1]\nformula = "always(p -> q)"', "requirement R1: no 'title'"),
        ('[R1]\ntitel = "x"', "unknown key 'titel'; nearest: title"),
        ("[R1]\ntitle = 3", "'title' has to be a string, got 3"),
        ('[R1]\ntitle = "x"\nformula = ""', "the formula is empty"),
        ("[R1]\ngroup = 3", "'group' has to be a string, got 3"),
        ('[R1]\nshows = "x"', "requirement R1: 'shows' has to be a list of signals, got 'x'"),
        ('[R1]\nshows = ["xx"]', "shows 'xx', which is not a numeric signal; nearest: x"),
        ('[R1]\nshows = ["p"]', "shows 'p', which is not a numeric signal"),
    ],
)
def test_a_file_that_is_wrong_is_refused(document: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "requirements.toml"
    file.write_text(document)
    with pytest.raises(RequirementError) as caught:
        load_requirements(file, SMALL)
    assert says in str(caught.value)
    assert str(file) in str(caught.value)


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RequirementError, match=r"absent.toml: no such file; expected a TOML file"):
        load_requirements(tmp_path / "absent.toml", SMALL)
    with pytest.raises(RequirementError, match=": a folder; expected a file"):
        load_requirements(tmp_path, SMALL)
    (tmp_path / "latin.toml").write_bytes(b"[R1]\ntitle = '\xe9'\n")
    with pytest.raises(RequirementError, match="not UTF-8"):
        load_requirements(tmp_path / "latin.toml", SMALL)


def test_a_requirement_may_belong_to_a_group(tmp_path: Path) -> None:
    file = tmp_path / "requirements.toml"
    table = 'title = "x"\nformula = "always(p -> q)"\n'
    file.write_text(f'[R1]\n{table}group = "safety"\n[R2]\n{table}')
    assert [requirement.group for requirement in load_requirements(file, SMALL)] == ["safety", ""]


def test_a_requirement_keeps_its_text_title_and_source() -> None:
    ids = [requirement.id for requirement in load_requirements(REQUIREMENTS_FILE, TABLE)]
    assert ids == ["R1", "R2", "R3", "R4", "R5"]
    assert R3.text == "always(hand_closing -> hand_distance >= 0.05 [hysteresis 0.005])"
    assert R3.source == "ISO 13482:2014"
    assert R3.shows == ("hand_contact_force",)
    assert "restricted joint speed" in R4.title
    assert R1.text.startswith("always(on(reading)")


def test_a_topic_with_one_number_or_text_may_be_written_without_the_field() -> None:
    vocabulary = Vocabulary(signals={"v": float}, messages={"n": {"turn": float}, "f": {"ok": bool}, "v": {"t": str}})
    assert str(parse_condition("n > 1", vocabulary)) == "n.turn > 1"
    assert str(parse_condition("v > 1 & v.t == 'i'", vocabulary)) == 'v > 1 & v.t == "i"'
    with pytest.raises(RequirementError, match=r"f is a topic: `on\(f\)`"):  # not `f.ok`: `f` might mean its arrival
        parse_condition("f & n > 1", vocabulary)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "condition, column 1: the condition is empty"),
        ("p &", "the condition ends too early"),
        ("always(p -> q)", "a condition is about the present and the past"),
        ("p -> q", "elsewhere write `!a | b`"),
        ("x + 1", "expected a condition, but this is a number"),
        ("pp", "unknown name 'pp'"),
    ],
)
def test_a_condition_that_is_wrong_is_refused(text: str, says: str) -> None:
    with pytest.raises(RequirementError) as caught:
        parse_condition(text, SMALL)
    assert says in str(caught.value)


def test_values_of_what_is_no_text_are_refused() -> None:
    with pytest.raises(ValueError, match=r"values of 'w\.nam': not a signal or .*; nearest: w\.name"):
        Vocabulary(messages={"w": {"name": str}}, values={"w.nam": ("i",)})
    with pytest.raises(ValueError, match=r"values of 'w\.name': expected at least one string, got 'i'"):
        Vocabulary(messages={"w": {"name": str}}, values={"w.name": "i"})


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("p | q & p", "p | (q & p)"),
        ("!p & q", "(!p) & q"),
        ("not p & q", "(!p) & q"),
        ("!x < 1", "!(x < 1)"),
        ("p & q since p | q", "(p & q) since (p | q)"),
        ("x + 2 * y < 1 - -x", "(x + (2 * y)) < (1 - (-x))"),
        ("x - y - 1 > 0", "((x - y) - 1) > 0"),
        ("once(p)", "once[0:inf](p)"),
        ("3 > time_since(p) | 3 <= time_since(q)", "time_since(p) < 3 | time_since(q) >= 3"),
        ("count(p) - 1 < last(n)", "(count[0:inf](p) - 1) < last(n.level)"),
        ("2*time_between ( p , (q | p) ) < 1", "2 * time_between(p, q | p) < 1"),
        ("s == 'i' | w != (\"j\")", 's == "i" | (w.name != "j")'),
        ("x < 1 [hysteresis 1][for 2]", "x < 1 [for 2] [hysteresis 1]"),
    ],
)
def test_precedence(text: str, other: str) -> None:
    assert parse_formula(f"always({text} -> p)", SMALL) == parse_formula(f"always( {other}\n->p )", SMALL)


def test_every_word_of_the_grammar_is_a_keyword() -> None:
    grammar = Path(pytest_hricdv.monitor.__file__).with_name("requirement.lark").read_text(encoding="utf-8")
    alternatives = re.findall(r"/\(([a-z|]+)\)\\b/", grammar)
    words = {
        *re.findall(r'"([a-z]+)"', grammar),
        *(word for alternative in alternatives for word in alternative.split("|")),
    }
    assert words == KEYWORDS
