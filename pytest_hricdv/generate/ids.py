"""Ids and seeds of tests, from their content: never from their place in a suite, the machine or the clock."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.generate.abstract import AbstractTest, Plans
from pytest_hricdv.generate.rng import derive_seed, digest

_NOT_IN_IDS = re.compile(r"[^A-Za-z0-9_]+")


@dataclass(frozen=True)
class Draft:
    """An abstract test without an id, as a method generates it; the fields are those of `AbstractTest`."""

    target: str
    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Plans = field(default_factory=dict, hash=False)
    name: str = ""


def slug(text: str) -> str:
    """The text in the characters of an id: letters, digits, `_` and `-`."""
    return _NOT_IN_IDS.sub("-", text).strip("-") or "test"


def seed_of_test(master_seed: int, suite: str, beliefs: Sequence[str], lines: Sequence[str], occurrence: int) -> int:
    """A test's own seed, 63 bits. Equal texts from different subsets have different seeds."""
    return derive_seed("seed", master_seed, suite, tuple(beliefs), tuple(lines), occurrence)


def content_digest(suite: str, beliefs: Sequence[str], lines: Sequence[str], seed: int, occurrence: int) -> str:
    """SHA-256 (hex) of everything that distinguishes a test from others; its id has the first 8 digits."""
    return digest("id", suite, tuple(beliefs), tuple(lines), seed, occurrence)


def identify(suite: str, master_seed: int, drafts: Iterable[Draft]) -> tuple[AbstractTest, ...]:
    """Give drafts their ids and seeds, in order.

    Drafts of equal content are numbered among themselves (their occurrence), so that the order of different drafts
    does not matter. If two different contents share 8 digits (about one suite in a million of 134 tests), both ids
    have 16 digits.
    """
    occurrences: dict[tuple[tuple[str, ...], tuple[str, ...]], int] = {}
    numbered: list[tuple[Draft, int, str]] = []
    for draft in drafts:
        content = (draft.beliefs, draft.lines)
        occurrence = occurrences[content] = occurrences.get(content, -1) + 1
        seed = seed_of_test(master_seed, suite, *content, occurrence)
        numbered.append((draft, seed, content_digest(suite, *content, seed, occurrence)))
    short_ids = [_test_id(suite, draft.target, code[:8]) for draft, _, code in numbered]
    uses = Counter(short_ids)
    return tuple(
        AbstractTest(
            id=short if uses[short] == 1 else _test_id(suite, draft.target, code[:16]),
            suite=suite,
            target=draft.target,
            beliefs=draft.beliefs,
            lines=draft.lines,
            plans=draft.plans,
            seed=seed,
            name=draft.name,
        )
        for short, (draft, seed, code) in zip(short_ids, numbered, strict=True)
    )


def _test_id(suite: str, target: str, code: str) -> str:
    return f"{slug(suite)}-{slug(target)}-{code}"
