"""The texts that coverage is shown in."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.cover.source import map_code
from pytest_hricdv.generate.model import Model
from pytest_hricdv.sources import code_texts, model_texts

ROOT = Path(__file__).parents[2]


def test_every_plan_of_the_table_model_has_its_line() -> None:
    model = Model(ROOT / "models_bdi" / "table_assembly.mas2j")
    plans = {"human": [f"plan{n}" for n in range(1, 49)], "robot_code": [f"p{n}" for n in range(1, 13)]}
    texts = model_texts(model, plans)
    assert [(each["agent"], each["file"]) for each in texts] == [
        ("human", "models_bdi/human.asl"),
        ("robot_code", "models_bdi/robot_code.asl"),
    ]
    for each in texts:
        assert list(each["plans"]) == plans[each["agent"]]
        lines = each["text"].splitlines()
        assert all(f"@{label} " in lines[line - 1] for label, line in each["plans"].items())


def test_labels_in_comments_and_texts_are_none_and_includes_are_followed(tmp_path: Path) -> None:
    (tmp_path / "m.mas2j").write_text("MAS m { agents: a; b; }")
    (tmp_path / "a.asl").write_text('{ include("more.asl") }\n// @x\n/* \n@x */\n@y +!g <- .print("@x").\n')
    (tmp_path / "more.asl").write_text("@x +!h.\n")
    (tmp_path / "b.asl").write_text("\n@x +!k.\n")
    found = model_texts(Model(tmp_path / "m.mas2j"), {"a": ["x", "y"], "b": ["x"]})
    named = {(each["agent"], Path(each["file"]).name): each["plans"] for each in found}
    assert named == {("a", "a.asl"): {"y": 5}, ("a", "more.asl"): {"x": 1}, ("b", "b.asl"): {"x": 2}}


@pytest.mark.parametrize("text", ["", "MAS m { agents: a; }"])
def test_a_model_that_cannot_be_read_has_no_text(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.mas2j").write_text(text)
    (tmp_path / "a.asl").write_bytes(b"\xff")
    assert model_texts(Model(tmp_path / "m.mas2j"), {"a": ["x"]}) == []


def test_statements_are_listed_in_the_order_of_their_bits() -> None:
    code = map_code(["controller"], ROOT)
    files = code_texts(code)
    first = code.bits({str(code.files[1].path): [files[1]["statements"][0]]}, {})
    assert first.statements == 1 << len(files[0]["statements"])
    assert all(len(each["text"].splitlines()) >= max(each["statements"], default=0) for each in files)
