"""The examples of docs/requirements.md and docs/patterns.md do what the pages say."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import pytest

from pytest_hricdv.monitor import load_requirements
from pytest_hricdv.monitor.patterns import PATTERNS
from tests.monitor.vocabulary import R1, R3, TABLE

DOCS = Path(__file__).parents[2] / "docs"


def blocks(page: str, language: str) -> list[str]:
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def test_the_definitions_of_the_example_explain_their_requirement(tmp_path: Path) -> None:
    [document] = blocks("requirements.md", "toml definitions")
    file = tmp_path / "requirements.toml"
    file.write_text(document, encoding="utf-8")
    [requirement] = load_requirements(file, TABLE)
    assert (
        "where moving = arm_speed > 0.001 [hysteresis 0.004];\n      near = hand_distance < closest;"
        in requirement.text
    )
    assert requirement.group == "safety"


@pytest.mark.parametrize(("page", "least"), [("requirements.md", 20), ("patterns.md", 15)])
def test_the_python_examples_give_what_they_show(page: str, least: int) -> None:
    # One after the other, as they are read. The blank line ends what the last line of a block is expected to print.
    session = "\n\n".join(blocks(page, "pycon"))
    example = doctest.DocTestParser().get_doctest(session, {"__name__": __name__}, page, None, None)
    output: list[str] = []
    failed, attempted = doctest.DocTestRunner().run(example, out=output.append)
    assert not failed, "".join(output)
    assert attempted > least


def test_the_requirements_of_the_example_are_those_of_the_table_assembly(tmp_path: Path) -> None:
    [document] = blocks("requirements.md", "toml")
    file = tmp_path / "requirements.toml"
    file.write_text(document, encoding="utf-8")
    shown = load_requirements(file, TABLE)
    assert [(requirement.id, requirement.title, requirement.formula) for requirement in shown] == [
        (requirement.id, requirement.title, requirement.formula) for requirement in (R1, R3)
    ]


def test_the_page_of_patterns_has_them_all() -> None:
    text = (DOCS / "patterns.md").read_text(encoding="utf-8")
    assert [name for name in PATTERNS if f"| `{name}(" not in text] == []
