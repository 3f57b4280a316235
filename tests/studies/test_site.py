"""What the site's pages are made of: Markdown for Sphinx, sections of docstrings, colours of AgentSpeak."""

from __future__ import annotations

from pathlib import Path

import pytest
from pygments.token import Error, Token

from studies.site.agentspeak import AgentSpeakLexer, ProjectLexer
from studies.site.pages import ROOT, root_file, sphinx_source

REPOSITORY = "https://example.org/repository"
MODELS = sorted([*(ROOT / "models_bdi").glob("*.asl"), *(ROOT / "pytest_hricdv" / "skeleton").rglob("*.asl")])
PROJECTS = sorted([*(ROOT / "models_bdi").glob("*.mas2j"), *(ROOT / "pytest_hricdv" / "skeleton").rglob("*.mas2j")])


def read(text: str, page: str = "tutorial") -> str:
    return sphinx_source(page, text, REPOSITORY)


def test_a_block_that_is_a_file_gets_a_caption() -> None:
    assert read("```toml requirements.toml\n[R1]\n```\n") == (
        "```{code-block} toml\n:caption: requirements.toml\n\n[R1]\n```\n"
    )
    assert read("```console\n$ pytest\n```\n") == "```console\n$ pytest\n```\n"


@pytest.mark.parametrize(
    ("page", "target", "expected"),
    [
        ("tutorial", "reference.md#files", "reference.md#files"),
        ("tutorial", "../CHANGELOG.md", "project/changelog.md"),
        ("api/run", "../../CHANGELOG.md", "../project/changelog.md"),
        ("tutorial", "../pytest_hricdv/plugin.py", f"{REPOSITORY}/blob/main/pytest_hricdv/plugin.py"),
        ("tutorial", "../models_bdi/", f"{REPOSITORY}/tree/main/models_bdi"),
        ("tutorial", "https://example.com/a.md", "https://example.com/a.md"),
        ("tutorial", "missing.md", "missing.md"),
    ],
)
def test_where_links_lead(page: str, target: str, expected: str) -> None:
    assert read(f"[`a`]({target})", page) == f"[`a`]({expected})"


def test_a_file_above_the_documentation_becomes_a_page() -> None:
    assert root_file("project/readme") == "README.md"
    text = sphinx_source("project/readme", "whatever the page itself says", REPOSITORY)
    assert text.startswith("# pytest-hricdv\n")
    assert "](../tutorial.md)" in text
    assert "](../pictures/run.gif)" in text
    assert root_file("tutorial") == ""


def trees_of(page: str, text: str) -> list[list[str]]:
    return [tree.partition("\n```\n")[0].splitlines()[1:] for tree in read(text, page).split("{toctree}")[1:]]


def test_the_navigation_has_the_first_page_of_each_line_of_the_index() -> None:
    lists = [
        "[not here](zero.md)",
        "## Begin",
        "- [b](b.md),",
        "  [a](a.md)",
        "- [d",
        "  e](d.md)",
        "## Look up",
        "- [c](c.md)",
    ]
    text = "\n".join(lists)
    assert trees_of("index", text) == [
        [":hidden:", ":caption: Begin", "", "B <b>", "D e <d>"],
        [":hidden:", ":caption: Look up", "", "C <c>"],
    ]


def test_words_that_readers_search_for_are_main_entries_of_the_index() -> None:
    assert read("# T\n\n<!-- search: flaky, random seed -->\n") == ("# T\n\n```{index} ! flaky, ! random seed\n```\n")


@pytest.mark.parametrize("path", [*MODELS, *PROJECTS], ids=lambda path: path.name)
def test_the_lexers_know_all_that_our_models_have(path: Path) -> None:
    lexer = AgentSpeakLexer() if path.suffix == ".asl" else ProjectLexer()
    tokens = [*lexer.get_tokens(path.read_text(encoding="utf-8"))]
    assert len(tokens) > 10
    assert [text for kind, text in tokens if kind in (Error, Token.Other)] == []
