"""Repairs: what may mend a statement, taken from the code itself."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from pytest_hricdv.coverage.code_map import SourceFile
from pytest_hricdv.extra.diagnosis.repairs import Repair, repairs

POURING = """\
FULL_ML, LOOK_EVERY_S = 150.0, 0.2


def pour(clock, tap, scale):
    tap.open()
    while scale.level_ml() < FULL_ML:
        clock.sleep(LOOK_EVERY_S)
    return scale.level_ml() >= FULL_ML


def rinse(tap, ready):
    if not tap.is_open():
        tap.warn()
    tap.close()
    return None
"""
SERVING = """\
def work(scale, bus, pour):
    if not scale.cup_is_there():
        bus.refuse()
    else:
        pour(scale)
"""


def source(name: str, text: str) -> SourceFile:
    """A file with its statements."""
    lines = sorted({node.lineno for node in ast.walk(ast.parse(text)) if isinstance(node, ast.stmt)})
    return SourceFile(name, Path(name), tuple(lines), (), (), text)


FILES = (source("pouring.py", POURING), source("serving.py", SERVING))


def made(line: int, file: int = 0) -> list[Repair]:
    """The repairs of a statement."""
    return [*repairs(FILES, FILES[file], line)]


@pytest.mark.parametrize(
    ("line", "operator", "becomes"),
    [
        (6, "condition changed", "while scale.cup_is_there() and scale.level_ml() < FULL_ML:"),
        (6, "comparison changed", "while scale.level_ml() <= FULL_ML:"),
        (8, "call added", "        clock.sleep(LOOK_EVERY_S)\n    tap.close()\n    return"),
        (1, "number changed", "FULL_ML, LOOK_EVERY_S = (150.0, 2.0)"),
        (1, "number changed", "FULL_ML, LOOK_EVERY_S = (75.0, 0.2)"),
        (12, "condition changed", "    if tap.is_open():"),
        (12, "ended early", "        tap.warn()\n        return None\n"),
        (13, "left out", "        pass\n    tap.close()"),
        (7, "call added", "        clock.sleep(LOOK_EVERY_S)\n        tap.close()\n    return"),
        (14, "guarded", "    if not tap.is_open():\n        tap.close()"),
    ],
)
def test_a_repair_is_among_those_of_its_statement(line: int, operator: str, becomes: str) -> None:
    assert [repair for repair in made(line) if repair.operator == operator and becomes in repair.text]


def test_what_is_added_has_only_names_that_the_function_has() -> None:
    texts = "\n".join(repair.words for repair in made(14))
    assert "tap.warn()" in texts
    assert "scale" not in texts
    assert "clock" not in texts


def test_each_repair_compiles_and_is_another_program() -> None:
    for line in FILES[0].statements:
        texts = [repair.text for repair in made(line)]
        assert len({ast.dump(ast.parse(text)) for text in texts}) == len(texts)
        assert ast.unparse(ast.parse(POURING)) not in texts


def test_each_number_is_changed_a_little_before_one_is_changed_much() -> None:
    words = [repair.words.split("`")[1::2] for repair in made(1)]
    assert words[:4] == [["120.0", "150.0"], ["0.16", "0.2"], ["187.5", "150.0"], ["0.25", "0.2"]]
    assert len(words) == 12


@pytest.mark.parametrize(
    ("number", "others"), [("3", ["4", "2"]), ("60", ["48", "75", "30", "120", "6", "600"]), ("True", [])]
)
def test_small_whole_numbers_are_counted_and_great_ones_scaled(number: str, others: list[str]) -> None:
    file = source("settings.py", f"TIMES = {number}\n")
    assert [repair.words.split("`")[1] for repair in repairs([file], file, 1)] == others


def test_the_function_and_the_words_are_said() -> None:
    repair = made(13)[0]
    assert (repair.file, repair.line, repair.function) == ("pouring.py", 13, "rinse")
    assert repair.words == "without `tap.warn()`"
