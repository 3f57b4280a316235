"""The glossary: each term has one sentence and a link to a page that uses it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from studies.site.pages import DOCS

ENTRY = re.compile(
    r"- \*\*(?P<term>[^*]+)\*\*: (?P<sentence>.+?\.) \[[^\]]+\]\((?P<page>[\w./-]+\.md)(?P<anchor>#\S+)?\)"
)
TERMS_THE_FIELD_EXPECTS = {
    *("agent", "belief", "desire", "intention", "percept", "plan"),
    *(
        "abstract test",
        "concretization",
        "disturbance",
        "interaction",
        "intervention",
        "outcome",
        "record hash",
        "suite",
    ),
    *("antecedent", "margin", "monitor", "NC", "requirement", "trigger", "vacuity", "verdict", "violation"),
    *("bin", "closure", "cross product", "baseline", "exemption", "feature", "gate", "known violation", "waiver"),
    *("campaign", "replay", "shard"),
}


def lines() -> list[str]:
    """The entries, each on a line."""
    text = (DOCS / "glossary.md").read_text(encoding="utf-8").replace("\n  ", " ")
    return [line for line in text.splitlines() if line.startswith("- ")]


def entries() -> list[re.Match[str]]:
    """The entries that are as they have to be."""
    return [match for line in lines() if (match := ENTRY.fullmatch(line))]


def sections() -> list[list[str]]:
    """The terms of each section, in order."""
    parts = (DOCS / "glossary.md").read_text(encoding="utf-8").split("\n## ")[1:]
    return [re.findall(r"^- \*\*([^*]+)\*\*", part, re.MULTILINE) for part in parts]


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub and the site make them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_each_entry_has_a_sentence_and_a_link() -> None:
    assert [line for line in lines() if not ENTRY.fullmatch(line)] == []
    assert len(lines()) > 60


def test_terms_are_in_order_and_there_once() -> None:
    for terms in sections():
        assert terms == sorted(terms, key=str.lower)
    every = [term for terms in sections() for term in terms]
    assert len(every) == len({*every})
    assert {*every} >= TERMS_THE_FIELD_EXPECTS


@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry["term"])
def test_the_page_of_a_term_is_there_and_uses_it(entry: re.Match[str]) -> None:
    page = DOCS / entry["page"]
    assert page.is_file()
    assert not entry["anchor"] or entry["anchor"][1:] in anchors(page)
    assert re.search(
        rf"\b{re.escape(entry['term'])}", page.read_text(encoding="utf-8").replace("\n", " "), re.IGNORECASE
    )
