"""Texts in markdown that mean nothing there: neither markup, nor links, nor references that notify people.

GitHub and GitLab make links of much that is no markup: of bare addresses, of `@team`, which sends mail to a team, of
`#123`, which leaves a note at an issue. A backslash keeps neither from it: both look at the text that was rendered.
A space of no width in it does. It is written as an entity, as bots that update dependencies do where they quote others.
"""

from __future__ import annotations

import re

from pytest_hricdv._base.message import visible

_CUT = "&#8203;"

_SPECIAL = {
    "\\": "\\\\",
    "&": "&amp;",
    "<": "&lt;",
    ">": "&gt;",
    "|": "\\|",
    "`": "\\`",
    "*": "\\*",
    "_": "\\_",
    "[": "\\[",
    "#": "\\#",
    "~": "\\~",
    "$": "&#36;",  # a backslash before it is no escape where GitHub looks for formulas
}

_LINKED = re.compile(
    r"@"  # people, teams, addresses of mail
    r"|[#!%~$&^](?=[\w\"])"  # issues; of GitLab: merge requests, milestones, labels, snippets, epics, iterations
    r"|:(?=//)|(?:mailto|xmpp):|www(?=\.)|GH-(?=\d)",
    re.IGNORECASE,
)
"""What a link begins with, up to where it is cut. After GitHub's documentation on autolinked references, that of GitLab
on special references, and GitHub Flavored Markdown, 6.9, Autolinks (extension)."""


def escaped(text: str) -> str:
    """A text without any meaning in markdown or HTML, and without invisible characters."""
    pieces: list[str] = []
    end = 0
    shown = visible(text)
    for link in _LINKED.finditer(shown):
        pieces += [_plain(shown[end : link.end()]), _CUT]
        end = link.end()
    return "".join([*pieces, _plain(shown[end:])])


def _plain(text: str) -> str:
    return "".join(_SPECIAL.get(char, char) for char in text)
