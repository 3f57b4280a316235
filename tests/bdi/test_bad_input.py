"""Files and models that are no good: an error that says where, never anything else, and soon."""

from __future__ import annotations

import contextlib
import random
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.bdi import BdiError, BdiSyntaxError, MultiAgentSystem
from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.language.project import read_project
from tests.bdi.models import TABLE, system_of

SOURCES = [path.read_text(encoding="utf-8") for path in sorted(TABLE.parent.glob("*.asl"))]
SOURCES += [path.read_text(encoding="utf-8") for path in sorted((Path(__file__).parent / "programs").glob("*/*.asl"))]
PIECES = [
    '"',
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "<-",
    ":-",
    ".",
    ";",
    "!",
    "+",
    "-",
    "|",
    "&",
    "@",
    "X",
    "a",
    "1",
    "/*",
    "\x00",
]


@st.composite
def mutants(draw: st.DrawFn) -> str:
    """The source of a real model in which a few places were cut out, doubled, cut off or filled with something else."""
    text = draw(st.sampled_from(SOURCES))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 12)))
        piece = draw(st.sampled_from([*PIECES, "", text[start:end] * 2, text[end : end + 30]]))
        text = text[:start] if draw(st.integers(0, 9)) == 0 else text[:start] + piece + text[end:]
    return text


@given(mutants())
def test_mutated_model_is_read_or_its_error_has_a_place(text: str) -> None:
    with contextlib.suppress(BdiSyntaxError):
        parse_program(text, "mutant.asl")
        return
    with pytest.raises(BdiSyntaxError) as caught:
        parse_program(text, "mutant.asl")
    assert 1 <= caught.value.line <= text.count("\n") + 1
    assert str(caught.value).startswith(f"mutant.asl:{caught.value.line}:{caught.value.column}: ")


@given(text=mutants())
def test_mutated_model_runs_or_fails_with_an_error_of_the_engine(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    folder = tmp_path_factory.mktemp("mutant")
    with contextlib.suppress(BdiError):
        system_of(folder, a=text, b="p(1). +!g <- .send(a, tell, p(2)).").run(max_rounds=200)


@given(st.data())
def test_mutated_project_is_read_or_its_error_has_a_place(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    text = (
        'MAS m { infrastructure: Centralised(1, "x") environment: e.E("a") agents: ann [beliefs="p"] #2; bob b.asl; }'
    )
    start = data.draw(st.integers(0, len(text)))
    end = start + data.draw(st.integers(0, 9))
    piece = data.draw(st.sampled_from([*PIECES, ":", "#", "=", ",", "agents", "at", "9" * 400, "é"]))
    path = tmp_path_factory.mktemp("project") / "m.mas2j"
    path.write_text(text[:start] + piece + text[end:], encoding="utf-8")
    with contextlib.suppress(BdiSyntaxError):
        read_project(path)


@pytest.mark.parametrize("name", ["long.asl", "long.mas2j"])
def test_file_of_ten_megabytes_is_refused_at_once(tmp_path: Path, name: str) -> None:
    (tmp_path / "mas.mas2j").write_text("MAS m { agents: long; }")
    (tmp_path / name).write_text("p. " * 3_500_000)
    begin = time.perf_counter()
    with pytest.raises(BdiSyntaxError, match=r"long\.\w+:1:1: too long to be a model: 10,500,000 bytes"):
        MultiAgentSystem.load(tmp_path / ("mas.mas2j" if name.endswith("asl") else name))
    assert time.perf_counter() - begin < 5


@pytest.mark.parametrize(
    "text",
    [
        "x" * 900_000,
        '"' * 900_000,
        'p("' + "a" * 900_000,
        "p. /*" + "*" * 900_000,
        "p(" + "9" * 900_000 + ").",
        "[" * 900_000,
    ],
    ids=["name", "quotes", "string", "comment", "number", "brackets"],
)
def test_hopeless_text_is_an_error_soon(text: str) -> None:
    begin = time.perf_counter()
    with contextlib.suppress(BdiSyntaxError):
        parse_program(text)
    assert time.perf_counter() - begin < 10


@pytest.mark.parametrize(
    "source",
    [
        "f(" * 10_000 + ")" * 10_000 + ".",
        "+!g <- " + "if (a) { " * 10_000 + "}" * 10_000 + ".",
        "p :- " + "(" * 10_000 + "q" + ")" * 10_000 + ".",
        "+!g <- X = " + "-" * 10_000 + "1.",
        "p(" + "[" * 10_000 + "]" * 10_000 + ").",
        "+!g : " + "not " * 10_000 + "a <- b.",
    ],
    ids=["structure", "if", "brackets", "minus", "list", "not"],
)
def test_nesting_ten_thousand_deep_is_an_error_with_a_place(tmp_path: Path, source: str) -> None:
    with pytest.raises(BdiSyntaxError, match=r"a\.asl:1:\d+: nested too deeply"):
        system_of(tmp_path, a=source)


def test_every_place_a_model_can_be_cut_off_at_is_an_error_or_a_shorter_model() -> None:
    text = SOURCES[0]
    places = random.Random(4).sample(range(len(text)), 120)
    for place in places:
        with contextlib.suppress(BdiSyntaxError):
            parse_program(text[:place], "cut.asl")


def test_empty_source_is_an_agent_that_does_nothing(tmp_path: Path) -> None:
    result = system_of(tmp_path, a="", b="// nothing\n", c="\ufeff").run()
    assert (result.ended, result.rounds, result.plans) == ("idle", 0, {"a": [], "b": [], "c": []})


@pytest.mark.parametrize("data", [b"", b"\xff\xfe", b"MAS \xe9 { agents: a; }", b"\x00" * 50])
def test_project_that_is_no_text_is_a_located_error(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "mas.mas2j").write_bytes(data)
    with pytest.raises(BdiSyntaxError, match=r"mas\.mas2j:1:\d+: "):
        MultiAgentSystem.load(tmp_path / "mas.mas2j")


def test_files_that_include_each_other_are_an_error(tmp_path: Path) -> None:
    (tmp_path / "b.asl").write_text('{ include("a.asl") }')
    with pytest.raises(BdiError, match="files that include each other"):
        system_of(tmp_path, a='{ include("b.asl") }')


@pytest.mark.parametrize(
    "source",
    [
        "!go. +!go <- !go; .print(x).",
        "n([]). !go. +!go : n(L) <- -+n([x|L]); !go.",
        "!go. +!go <- !!go; !!go.",
        "n(1). !go. +!go : n(X) <- -+n(X * 2); !go.",
        's("x"). !go. +!go : s(X) <- .concat(X, "x", Y); -+s(Y); !go.',
    ],
    ids=["deeper and deeper", "longer and longer", "more and more", "greater and greater", "longer string"],
)
def test_agent_that_goes_on_for_ever_is_stopped_at_the_round_limit(tmp_path: Path, source: str) -> None:
    result = system_of(tmp_path, a=source).run(max_rounds=2000)
    assert (result.ended, result.rounds) == ("round limit", 2000)
