"""Tables of Q in files: learning continues from a saved table, but only on the same model."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import ReinforcementLearning
from pytest_hricdv.generate.saved_table import SavedTable, read_warm_start
from tests.generate.toy import LAMPS, lamps

names = st.text(min_size=1, max_size=5)
tables = st.builds(
    SavedTable,
    model=names,
    model_sha256=names,
    beliefs=st.dictionaries(names, st.lists(names).map(tuple), max_size=3),
    learning=st.dictionaries(names, st.integers(-(2**63), 2**63 - 1) | st.booleans() | names, max_size=3),
    seed=st.integers(-(2**63), 2**63 - 1),
    iterations=st.integers(0, 2**63 - 1),
    converged_at=st.none() | st.integers(0, 2**63 - 1),
    maxima=st.dictionaries(names, st.integers(0, 2**63 - 1), max_size=3),
    q=st.dictionaries(names, st.dictionaries(names, st.floats(allow_nan=False, allow_infinity=False)), max_size=3),
)


@given(tables)
def test_a_table_reads_back_exactly(table: SavedTable) -> None:
    assert SavedTable.from_json(table.to_json(), "x") == table


@pytest.fixture
def context(tmp_path: Path) -> GenerationContext:
    return GenerationContext(lamps(tmp_path), LAMPS, save=tmp_path / "kept" / "q.json")


def _learned(context: GenerationContext) -> Path:
    ReinforcementLearning().generate(context)
    assert context.save is not None
    return context.save


def test_a_table_of_other_groups_is_an_error(context: GenerationContext) -> None:
    assert context.model is not None
    other = BeliefSpace(LAMPS.start, {"mood": ("polite", "curt"), "wish": ("bright", "dim")}, id_groups=("mood",))
    with pytest.raises(GenerateError, match="a table of other belief groups: wish; learn again"):
        read_warm_start(_learned(context), context.model, other)


def _without_a_cell(data: dict[str, Any]) -> None:
    del data["q"]["hall"]["curt"]


def _with_an_unknown_cell(data: dict[str, Any]) -> None:
    data["q"]["hall"]["sad"] = 1.0


def _infinite(data: dict[str, Any]) -> None:
    data["q"]["hall"]["curt"] = math.inf


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda data: data.update(schema="hricdv-qtable/9"),
            "expected schema 'hricdv-qtable/1', found 'hricdv-qtable/9'",
        ),
        (lambda data: data.pop("maxima"), "missing required field `maxima`"),
        (lambda data: data.update(q=3), "Expected `object`, got `int` - at `\\$.q`"),
        (_without_a_cell, "the row of 'hall' lacks 'curt'; was the file edited"),
        (_with_an_unknown_cell, "the row of 'hall' has the unknown cell 'sad'; was the file edited"),
        (_infinite, "expected a finite number, got Infinity"),
    ],
)
def test_an_edited_table_is_an_error(
    context: GenerationContext, change: Callable[[dict[str, Any]], None], message: str
) -> None:
    assert context.model is not None
    path = _learned(context)
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(GenerateError, match=message):
        read_warm_start(path, context.model, LAMPS)


def test_other_files_are_no_table(context: GenerationContext, tmp_path: Path) -> None:
    assert context.model is not None
    cut = tmp_path / "cut.json"
    cut.write_text('{"schema": "hric')
    with pytest.raises(GenerateError, match=r"cut.json:1:12: not JSON, perhaps cut off"):
        read_warm_start(cut, context.model, LAMPS)
    with pytest.raises(GenerateError, match=r"gone.json: there is no such file"):
        read_warm_start(tmp_path / "gone.json", context.model, LAMPS)
    with pytest.raises(GenerateError, match="expected a saved table, or belief sets"):
        read_warm_start(tmp_path, context.model, LAMPS)


def test_a_table_that_cannot_be_written_is_an_error(context: GenerationContext, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(GenerateError, match=r"cannot write .*q.json: .*; choose another file"):
        ReinforcementLearning().generate(replace(context, save=tmp_path / "file" / "q.json"))
