"""Every example in the pages on BDI models has the output that the page shows.

Each section has its own folder. A block with a file name after its language is written to that file. A ``console``
block contains commands and their output. ``python`` blocks are executed in the order of the page; a ``text`` block
after one is its output. A ``text`` block after AgentSpeak is the output of the section's agents.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.bdi import MultiAgentSystem
from pytest_hricdv.bdi.actions.registry import ACTIONS, FUNCTIONS
from pytest_hricdv.bdi.language.parser import parse_program

DOCS = Path(__file__).parents[2] / "docs"
_BLOCK = re.compile(r"^```(?P<kind>\w+)(?: (?P<name>\S+))?\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
_COMMAND = "$ hricdv "


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    kind: str
    name: str | None
    text: str


@dataclass(frozen=True)
class Section:
    """A section of a page with its blocks."""

    title: str
    blocks: tuple[Block, ...]


def _sections(page: str) -> list[Section]:
    parts = re.split(r"^## ", (DOCS / page).read_text(encoding="utf-8"), flags=re.MULTILINE)
    sections = []
    for part in parts:
        blocks = [Block(match["kind"], match["name"], match["text"]) for match in _BLOCK.finditer(part)]
        if blocks:
            sections.append(Section(f"{page}: {part.splitlines()[0]}", tuple(blocks)))
    return sections


SECTIONS = [*_sections("writing-models.md"), *_sections("jason-support.md")]


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.title)
def test_examples_do_what_the_page_says(section: Section, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for before, block in zip((None, *section.blocks), section.blocks, strict=False):
        if block.name is not None:
            (tmp_path / block.name).write_text(block.text, encoding="utf-8")
        elif block.kind == "asl":
            parse_program(block.text)
        elif block.kind == "console":
            _check_commands(block.text)
        elif block.kind == "python":
            names["printed"] = _printed(block.text, names)
        elif block.kind == "text":
            assert before is not None
            shown = names["printed"] if before.kind == "python" else _agents_print(tmp_path)
            assert shown == block.text


def _check_commands(text: str) -> None:
    for command in re.split(r"^(?=\$ )", text, flags=re.MULTILINE)[1:]:
        line, _, expected = command.partition("\n")
        assert line.startswith(_COMMAND)
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(shlex.split(line.removeprefix(_COMMAND)))
        assert out.getvalue() + err.getvalue() == expected


def _printed(code: str, names: dict[str, object]) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, names)
    return out.getvalue()


def _agents_print(folder: Path) -> str:
    agents = " ".join(f"{path.stem};" for path in sorted(folder.glob("*.asl")))
    (folder / "page.mas2j").write_text(f"MAS page {{ agents: {agents} }}", encoding="utf-8")
    return "".join(f"{line}\n" for line in MultiAgentSystem.load(folder / "page.mas2j").run(max_rounds=10_000).prints)


def test_page_names_every_standard_action_and_no_other() -> None:
    page = (DOCS / "jason-support.md").read_text(encoding="utf-8")
    table = page.split("## Internal actions")[1].split("`.wait` takes")[0]
    named = set()
    for prefix, names in re.findall(r"`\.(set|map|queue)\.(\w+(?: \w+)+)`", table):  # written once for all of a kind
        named |= {f".{prefix}.{name}" for name in names.split()}
    table = re.sub(r"`\.(set|map|queue)\.[^`]+`", "", table)
    named |= set(re.findall(r"(?<![\w.])\.\w+", table))
    blocks = set(re.findall(r"\.\w+", table.split("| blocks |")[1].split("\n")[0]))  # statements by another name
    assert blocks == {".foreach", ".if_then_else", ".loop", ".fork"}
    assert named - blocks == set(ACTIONS)
    functions = {name.removeprefix("math.") for name in FUNCTIONS if name.startswith("math.")}
    assert functions == set(re.findall(r"\w+", table.split("`math.")[1].split("`")[0]))
