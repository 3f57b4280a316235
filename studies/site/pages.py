"""Pages as they stand in the repository, where GitHub shows them, to what Sphinx reads.

Seven things differ. A block with the name of its file (```` ```toml pytest.ini ````) becomes a block with a caption. A
link to a file outside of docs/ leads to the repository, or to the page that the site has of this file. A page in
docs/project/ has the text of the file that it links to. The lists of the first page become the navigation. Words after
which readers search (`<!-- search: flaky, random -->`) become entries of the index, which the search shows first.
Studies are not searched. And badges, which are loaded from elsewhere, are left out.
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
_LISTED = re.compile(r"\[(?P<text>[^\]]*)\]\((?P<page>[^\s:]+?)\.md\)")
_LINE = re.compile(r"^- .*(?:\n  .*)*", re.MULTILINE)
"""A line of a list, with the lines that go on with it."""
_SEARCHED = re.compile(r"^<!-- search: (?P<words>.*) -->$", re.MULTILINE)
OVERVIEWS = {"public-api": "api/", "studies/index": "studies/"}
"""Pages that list those of a folder, which are below them in the navigation."""
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

    text = _SEARCHED.sub(_index_entries, "".join(_parts(text, linked)))
    unsearched = "---\nnosearch: true\n---\n\n" if page.startswith("studies/") else ""
    navigation = _navigation(text) if page == "index" else _tree(_below(page, text), "")
    return f"{unsearched}{text}\n{navigation}" if navigation else unsearched + text


def _index_entries(match: re.Match[str]) -> str:
    """Entries of the index at this place; `!` makes each the main one, which Sphinx's search ranks highest."""
    entries = ", ".join(f"! {word.strip()}" for word in match["words"].split(","))
    return f"```{{index}} {entries}\n```"


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
    """A hidden table of contents for each section of the first page, with the first page of each line of its lists."""
    titles = [*_SECTION.finditer(index)]
    ends = [match.start() for match in titles[1:]] + [len(index)]
    return "\n".join(
        _tree([_entry(*line[0]) for line in entries(index[match.end() : end])], match["title"])
        for match, end in zip(titles, ends, strict=True)
    )


def entries(text: str) -> list[list[tuple[str, str]]]:
    """The pages that each line of a text's lists links to, with the link's text; without lines that link to none."""
    found = ([(link["text"], link["page"]) for link in _LISTED.finditer(line[0])] for line in _LINE.finditer(text))
    return [pages for pages in found if pages]


def listed(text: str, overview: str) -> list[str]:
    """The pages of an overview's folder, relative to docs/, that its text links to, in order."""
    pages = (os.path.normpath(Path(overview).parent / link["page"]) for link in _LISTED.finditer(text))
    return [page for page in dict.fromkeys(pages) if page.startswith(OVERVIEWS[overview])]


def _below(page: str, text: str) -> list[str]:
    """The pages below one in the navigation: the others of its line on the first page, or those of its folder."""
    if page in OVERVIEWS:
        return [f"/{each}" for each in listed(text, page)]
    lines = entries((DOCS / "index.md").read_text(encoding="utf-8"))
    return [_entry(title, f"/{each}") for (_, first), *others in lines if first == page for title, each in others]


def _entry(title: str, page: str) -> str:
    """A line of a table of contents: the link's text, as a title."""
    title = " ".join(title.split())
    return f"{title[:1].upper()}{title[1:]} <{page}>"


def _tree(pages: list[str], caption: str) -> str:
    """A hidden table of contents; empty without pages."""
    head = ["```{toctree}", ":hidden:", *([f":caption: {caption}"] if caption else []), ""]
    return "\n".join([*head, *pages, "```", ""]) if pages else ""
