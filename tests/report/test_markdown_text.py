"""Texts of others in summaries and comments: they link nowhere, notify nobody, and have no markup."""

from __future__ import annotations

import html
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.report.markdown import escape_markdown

LINKS = [
    *(
        "https://evil.example/x",
        "HTTP://evil.example",
        "_https://evil.example",
        "ftp://evil.example",
        "www.evil.example",
    ),
    *("WWW.evil.example", "mailto:me@evil.example", "me@evil.example", "@team", "@org/team", "#123", "a/b#12", "GH-12"),
    *("gh-12", "!12", "~bug", '~"a label"', "%3", '%"1.0"', "&5", "$9", "^alert#7", "git+ssh://evil.example"),
]
LINKED = re.compile(r"://|@\w|(?i:www\.|GH-\d|mailto:\w)|[#!%~$&^][\w\"]")


def pieces(text: str) -> list[str]:
    """What a service sees of a text in markdown, a piece of text at a time."""
    return [html.unescape(re.sub(r"\\([!-/:-@\[-`{-~])", r"\1", piece)) for piece in text.split("&#8203;")]


@pytest.mark.parametrize("link", LINKS)
def test_no_service_makes_a_link_of_it(link: str) -> None:
    for text in (link, f"see {link} now", f"({link})", f"*{link}*"):
        assert LINKED.search(text)
        assert [piece for piece in pieces(escape_markdown(text)) if LINKED.search(piece)] == []


@given(st.text(alphabet='@#!%~$&^:/w.hGHtps-12 a|_*`[]<>\\"', max_size=30))
def test_people_read_what_was_said(text: str) -> None:
    assert "".join(pieces(escape_markdown(text))) == text
    assert [piece for piece in pieces(escape_markdown(text)) if LINKED.search(piece)] == []
    bare = escape_markdown(text)
    assert re.findall(r"(?<!\\)(?:\\\\)*[|`*_\[~]", bare) == []
    assert "<" not in bare
