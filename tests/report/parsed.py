"""A page taken apart."""

import base64
import json
import zlib
from html.parser import HTMLParser
from typing import Any

VOID = {"meta", "link", "br", "input", "hr", "img"}


class Page(HTMLParser):
    """The elements of a page; fails where a tag is not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words = ""
        self.scripts: dict[str, str] = {}
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, f"</{tag}> at {self.getpos()}"

    def handle_data(self, data: str) -> None:
        if self.open[-1:] == ["script"]:
            self.scripts[self.tags[-1][1].get("id") or "code"] = data
        elif self.open[-1:] != ["style"]:
            self.words += f" {data} "

    def count(self, tag: str, name: str = "") -> int:
        return sum(other == tag and (not name or name in (attrs.get("class") or "")) for other, attrs in self.tags)


def details(page: Page, number: int = 0) -> list[dict[str, Any]]:
    """The details of the tests of a pack that is in the page."""
    lines = zlib.decompress(base64.b64decode(page.scripts[f"pack-{number}"])).splitlines()
    tests: list[dict[str, Any]] = [json.loads(line) for line in lines]
    return tests
