"""Shards: a suite split over jobs, each of which takes its part by the ids alone."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass


class ShardError(ValueError):
    """What should say a shard is malformed; the text says what was expected."""


@dataclass(frozen=True)
class Shard:
    """The part `index` (from 1) of `of`.

    A test's part depends on its id and on `of`, so whoever adds tests moves none, and jobs need not know of each other.
    """

    index: int
    of: int

    def __contains__(self, test_id: str) -> bool:
        digest = hashlib.sha256(test_id.encode("utf-8")).digest()
        return int.from_bytes(digest[:8], "big") % self.of == self.index - 1

    def __str__(self) -> str:
        return f"{self.index}/{self.of}"


def shard(text: str) -> Shard:
    """The shard that `2/3` names. Raises ShardError."""
    match = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text.strip())
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise ShardError(f"{text}: expected INDEX/OF, as in 1/3, with INDEX from 1 to OF")
    return Shard(int(match[1]), int(match[2]))
