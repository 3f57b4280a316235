"""Who a test is: an id and a seed from its content, never from its place, the machine or the clock."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from .abstract import AbstractTest, Plans
from .stream import derive_seed, digest

_UNFIT = re.compile(r"[^A-Za-z0-9_]+")


@dataclass(frozen=True)
class Draft:
    """A test before it has an id: what a method found. `aim` is short, `name` says more and may be empty."""

    aim: str
    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Plans = field(default_factory=dict, hash=False)
    name: str = ""


def slug(text: str) -> str:
    """The text in the characters an id may have: letters, digits, `_` and `-`."""
    return _UNFIT.sub("-", text).strip("-") or "test"


def own_seed(master_seed: int, suite: str, beliefs: Sequence[str], lines: Sequence[str], occurrence: int) -> int:
    """A test's own seed, 63 bits. Equal texts from different subsets have different seeds."""
    return derive_seed("seed", master_seed, suite, tuple(beliefs), tuple(lines), occurrence)


def content_digest(suite: str, beliefs: Sequence[str], lines: Sequence[str], seed: int, occurrence: int) -> str:
    """SHA-256 (hex) of all that makes a test the test it is; its id has the first 8 digits."""
    return digest("id", suite, tuple(beliefs), tuple(lines), seed, occurrence)


def identify(suite: str, master_seed: int, drafts: Iterable[Draft]) -> tuple[AbstractTest, ...]:
    """Give drafts their ids and seeds, in order.

    Drafts of equal content are told apart by their occurrence number among their equals, so that the order of
    different drafts never matters. Should two different contents share 8 digits (about one suite in a million of
    134 tests), both get 16.
    """
    occurrences: dict[tuple[tuple[str, ...], tuple[str, ...]], int] = {}
    found: list[tuple[Draft, int, str]] = []
    for draft in drafts:
        content = (draft.beliefs, draft.lines)
        occurrence = occurrences[content] = occurrences.get(content, -1) + 1
        seed = own_seed(master_seed, suite, *content, occurrence)
        found.append((draft, seed, content_digest(suite, *content, seed, occurrence)))
    short = [_test_id(suite, draft.aim, code[:8]) for draft, _, code in found]
    shared = {each for each in short if short.count(each) > 1} if len(set(short)) < len(short) else set()
    return tuple(
        AbstractTest(
            id=brief if brief not in shared else _test_id(suite, draft.aim, code[:16]),
            suite=suite,
            aim=draft.aim,
            beliefs=draft.beliefs,
            lines=draft.lines,
            plans=draft.plans,
            seed=seed,
            name=draft.name,
        )
        for brief, (draft, seed, code) in zip(short, found, strict=True)
    )


def _test_id(suite: str, aim: str, code: str) -> str:
    return f"{slug(suite)}-{slug(aim)}-{code}"
