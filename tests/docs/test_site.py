"""The documentation as a site: it builds without a warning, and a reader needs no network for it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.page import DOCS, blocks

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `make docs` builds."""
    folder = tmp_path_factory.mktemp("site")
    options = ["--builder", "html", "--fail-on-warning", "--quiet", "--doctree-dir", str(folder / "trees")]
    command = [sys.executable, "-m", "sphinx", *options, str(DOCS), str(folder / "html")]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr
    return folder / "html"


def test_pages_load_nothing_from_elsewhere(site: Path) -> None:
    pages = [*site.rglob("*.html")]
    assert len(pages) > 50
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert re.findall(r"<(?:script|link|img|iframe)[^>]*(?:src|href)=\"(?:https?:)?//[^\"]*", text) == [], page
    for sheet in site.rglob("*.css"):
        assert "url(http" not in sheet.read_text(encoding="utf-8").replace('"', "").replace("'", ""), sheet


def test_blocks_that_are_files_have_their_names_and_colours(site: Path) -> None:
    text = (site / "tutorial.html").read_text(encoding="utf-8")
    names = [block.name for block in blocks("tutorial.md") if block.name]
    assert re.findall(r'"code-block-caption"><span class="caption-text">([^<]+)<', text) == names
    assert 'class="highlight-asl' in text
    assert re.search(r'<span class="nl">@\w+</span>', text), "labels of plans"


def test_each_public_name_is_in_the_index(site: Path) -> None:
    index = (site / "genindex.html").read_text(encoding="utf-8")
    for name in (
        "Testbench",
        "Uniform",
        "HriCase",
        "CaseResult",
        "parse_pattern",
        "MultiAgentSystem",
        "MessageDisturbance",
        "Value",
    ):
        assert re.search(rf">\s*{name}\b", index), name
