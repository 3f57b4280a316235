"""Pages as they stand in the repository, where GitHub shows them, to what Sphinx reads.

Five things differ. A block with the name of its file (```` ```toml pytest.ini ````) becomes a block with a caption. A
link to a file outside of docs/ leads to the repository, or to the page that the site has of this file. A page in
docs/project/ has the text of the file that it links to. The lists of the first page become the navigation. And badges,
which are loaded from elsewhere, are left out.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
ROOT_FILES = ("CONTRIBUTING.md", "CHANGELOG.md", "RELEASING.md", "SECURITY.md", "README.md")
"""Files above docs/ that the site has as pages."""

_FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
_NAMED = re.compile(r"\A```(?P<language>\w+) (?P<name>\S+)\n")
_CODE = re.compile(r"`[^`\n]*`")
_LINK = re.compile(r"\]\((?P<target>[^)\s#]+)(?P<anchor>#[^)\s]*)?\)")
_LISTED = re.compile(r"\]\((\S+?)\.md\)")
_BADGE = re.compile(r"!\[[^\]]*\]\(https://img\.shields\.io/[^)]*\) ?")
"""Badges are loaded from elsewhere, which no page of the site does."""
_SECTION = re.compile(r"^## (?P<title>.*)$", re.MULTILINE)


def page_of(root_file: str) -> str:
    """The page that the site has of a file above docs/: `project/contributing` of `CONTRIBUTING.md`."""
    return f"project/{PurePosixPath(root_file).stem.lower()}"


_PAGES = {page_of(name): name for name in ROOT_FILES}


def root_file(page: str) -> str:
    """The file above docs/ that a page shows; empty for a page of its own."""
    return _PAGES.get(page, "")


def sphinx_source(page: str, text: str, repository_url: str) -> str:
    """What Sphinx reads for a page.

    Args:
        page: its name, relative to docs/ and without `.md`.
        text: of its file.
        repository_url: of the repository's front page, to which files outside of docs/ are linked.
    """
    file = DOCS / f"{page}.md"
    name = root_file(page)
    if name:
        file = ROOT / name
        text = _BADGE.sub("", file.read_text(encoding="utf-8"))

    def linked(match: re.Match[str]) -> str:
        target = _target(match["target"], file, page, repository_url)
        return f"]({target}{match['anchor'] or ''})"

    text = "".join(_parts(text, linked))
    return f"{text}\n{_navigation(text)}" if page == "index" else text


def _parts(text: str, linked: Callable[[re.Match[str]], str]) -> Iterator[str]:
    """The text with its links replaced, except in code, and its named blocks captioned."""
    end = 0
    for fence in _FENCED.finditer(text):
        yield _outside_code(text[end : fence.start()], linked)
        yield _NAMED.sub(r"```{code-block} \g<language>\n:caption: \g<name>\n\n", fence[0])
        end = fence.end()
    yield _outside_code(text[end:], linked)


def _outside_code(text: str, linked: Callable[[re.Match[str]], str]) -> str:
    """The prose with its links replaced; a link's own text may have code in it."""
    code = [match.span() for match in _CODE.finditer(text)]

    def replaced(match: re.Match[str]) -> str:
        is_code = any(start < match.start() < end for start, end in code)
        return match[0] if is_code else linked(match)

    return _LINK.sub(replaced, text)


def _target(target: str, file: Path, page: str, repository_url: str) -> str:
    """Where a link of a page leads on the site; what does not exist stays as it is, for Sphinx to complain about."""
    if "://" in target or target.startswith("mailto:"):
        return target
    path = Path(os.path.normpath(file.parent / target))
    if not path.exists() or not path.is_relative_to(ROOT):
        return target
    name = path.relative_to(ROOT).as_posix()
    if name in ROOT_FILES:
        path = DOCS / f"{page_of(name)}.md"
    if path.is_relative_to(DOCS):
        return Path(os.path.relpath(path, (DOCS / page).parent)).as_posix()
    return f"{repository_url}/{'tree' if path.is_dir() else 'blob'}/main/{name}"


def _navigation(index: str) -> str:
    """A hidden table of contents for each section of the first page, with the pages that it links to, in this order."""
    titles = [*_SECTION.finditer(index)]
    ends = [match.start() for match in titles[1:]] + [len(index)]
    trees = []
    for match, end in zip(titles, ends, strict=True):
        pages = list(dict.fromkeys(_LISTED.findall(index[match.end() : end])))
        trees.append("\n".join(["```{toctree}", ":hidden:", f":caption: {match['title']}", "", *pages, "```", ""]))
    return "\n".join(trees)
