"""The examples of docs/requirements.md do what the page says."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

from pytest_hricdv.monitor import load_requirements
from tests.monitor.vocabulary import R1, R3, TABLE

PAGE = (Path(__file__).parents[2] / "docs" / "requirements.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_the_definitions_of_the_example_explain_their_requirement(tmp_path: Path) -> None:
    [document] = blocks("toml definitions")
    file = tmp_path / "requirements.toml"
    file.write_text(document, encoding="utf-8")
    [requirement] = load_requirements(file, TABLE)
    assert (
        "where moving = arm_speed > 0.001 [hysteresis 0.004];\n      near = hand_distance < closest;"
        in requirement.text
    )
    assert requirement.group == "safety"


def test_the_python_examples_give_what_they_show() -> None:
    # One after the other, as they are read. The blank line ends what the last line of a block is expected to print.
    session = "\n\n".join(blocks("pycon"))
    example = doctest.DocTestParser().get_doctest(session, {"__name__": __name__}, "requirements.md", None, None)
    output: list[str] = []
    failed, attempted = doctest.DocTestRunner().run(example, out=output.append)
    assert not failed, "".join(output)
    assert attempted > 20


def test_the_requirements_of_the_example_are_those_of_the_table_assembly(tmp_path: Path) -> None:
    [document] = blocks("toml")
    file = tmp_path / "requirements.toml"
    file.write_text(document, encoding="utf-8")
    shown = load_requirements(file, TABLE)
    assert [(each.id, each.title, each.formula) for each in shown] == [
        (each.id, each.title, each.formula) for each in (R1, R3)
    ]
