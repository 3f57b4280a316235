"""Files and models that are no good: an error that says where, never anything else, and soon."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.bdi import BdiError, BdiSyntaxError, MultiAgentSystem
from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.language.project import read_project
from tests.bdi.models import TABLE, system_of
from tests.hanging import ends

SOURCES = [path.read_text(encoding="utf-8") for path in sorted(TABLE.parent.glob("*.asl"))]
SOURCES += [path.read_text(encoding="utf-8") for path in sorted((Path(__file__).parent / "programs").glob("*/*.asl"))]
PIECES = [*'"()[]{}.;!+-|&@Xa1\x00', "<-", ":-", "/*"]


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
    with ends(), pytest.raises(BdiError, match=r"long\.\w+: too large: 10,500,000 bytes; expected at most 1,000,000"):
        MultiAgentSystem.load(tmp_path / ("mas.mas2j" if name.endswith("asl") else name))


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
    with ends(), contextlib.suppress(BdiSyntaxError):
        parse_program(text)


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


@pytest.mark.parametrize("data", [b"", b"\xff\xfe", b"MAS \xe9 { agents: a; }", b"\x00" * 50])
def test_project_that_is_no_text_is_a_located_error(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "mas.mas2j").write_bytes(data)
    with pytest.raises(BdiError, match=r"mas\.mas2j:1:\d+: "):
        MultiAgentSystem.load(tmp_path / "mas.mas2j")


def test_files_that_include_each_other_are_an_error(tmp_path: Path) -> None:
    (tmp_path / "b.asl").write_text('p.\n{ include("a.asl") }')
    with pytest.raises(BdiError, match=r"b\.asl:2:\d+: files that include each other"):
        system_of(tmp_path, a='{ include("b.asl") }')


def test_files_that_include_others_twice_end_at_a_limit(tmp_path: Path) -> None:
    for number in range(23):
        (tmp_path / f"f{number}.asl").write_text(f'{{ include("f{number + 1}.asl") }}\n' * 2)
    (tmp_path / "f23.asl").write_text("p.")
    with ends(), pytest.raises(BdiSyntaxError, match=r"f\d+\.asl:\d:\d+: a program of more than 1,000 files"):
        system_of(tmp_path, a='{ include("f0.asl") }')


@pytest.mark.parametrize("text", ["root:x:0:0:secret", "\xff secret"])
@pytest.mark.parametrize("included", [False, True])
def test_nothing_of_a_file_outside_of_the_project_is_shown(tmp_path: Path, text: str, included: bool) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "passwd.conf").write_bytes(text.encode("latin-1"))
    (tmp_path / "mine" / "mas.mas2j").write_text("MAS m { agents: a " + ("" if included else "../passwd.conf") + "; }")
    (tmp_path / "mine" / "a.asl").write_text('{ include("../passwd.conf") }')
    with pytest.raises(BdiError, match=r"passwd\.conf.*: not AgentSpeak; details are not shown") as caught:
        MultiAgentSystem.load(tmp_path / "mine" / "mas.mas2j")
    assert "secret" not in str(caught.value)
    assert "x:0" not in str(caught.value)


@pytest.mark.parametrize(
    ("count", "message"),
    [
        ("#00000000199999999", "found '00000000199999999'"),
        ("#10001", "from 1 to 10,000, found '10001'"),
        ("#٣", "unexpected character"),
        ("#0", "found '0'"),
        ("#6000; b #6000", "from 1 to 4,000 more, 10,000 together, found '6000'"),
        ("; ".join(["", *(f"x{number}" for number in range(10_001))]), "expected at most 10,000 agents"),
    ],
    ids=lambda value: value[:20],
)
def test_agents_have_a_largest_number(tmp_path: Path, count: str, message: str) -> None:
    (tmp_path / "mas.mas2j").write_text(f"MAS m {{ agents: a {count}; }}", encoding="utf-8")
    with pytest.raises(BdiSyntaxError) as caught:
        read_project(tmp_path / "mas.mas2j")
    assert message in str(caught.value)


def test_beliefs_of_many_copies_end_at_a_limit(tmp_path: Path) -> None:
    (tmp_path / "mas.mas2j").write_text("MAS m { agents: a #10000; }")
    (tmp_path / "a.asl").write_text("p. " * 200)
    with pytest.raises(BdiSyntaxError, match=r"mas\.mas2j:1:17: more than 1,000,000 beliefs of all agents"):
        MultiAgentSystem.load(tmp_path / "mas.mas2j")


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
