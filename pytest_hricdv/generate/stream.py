"""Private random streams: each drawn from a key, none shared, none global.

Only `Random.random()` is used: it is the one method whose sequence Python promises to keep from version to version,
so that a seed written into a suite or a report means the same test for years.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from random import Random
from typing import TypeVar

T = TypeVar("T")

#: Keys of streams and contents of ids are made of these.
Json = None | bool | int | float | str | Sequence["Json"]


def canonical(value: object) -> str:
    """The one JSON text of a value: sorted keys, no spaces, ASCII, exact floats.

    Raises:
        ValueError: a float is NaN or infinite.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)


def digest(*key: Json) -> str:
    """SHA-256 (hex) of the key's canonical JSON."""
    return hashlib.sha256(canonical(key).encode("ascii")).hexdigest()


def derive_seed(*key: Json) -> int:
    """A seed of 63 bits from a key: a signed 64-bit integer wherever it is stored."""
    return int(digest(*key)[:16], 16) >> 1


def stream(*key: Json) -> Random:
    """A private stream of its own for a key."""
    return Random(derive_seed(*key))


def index(random: Random, count: int) -> int:
    """One of 0 .. count-1, each equally likely (to within 2**-53)."""
    return min(int(random.random() * count), count - 1)


def pick(random: Random, choices: Sequence[T]) -> T:
    """One of the choices, each equally likely."""
    return choices[index(random, len(choices))]


def shuffled(random: Random, items: Sequence[T]) -> list[T]:
    """The items in random order (Fisher and Yates)."""
    result = list(items)
    for last in range(len(result) - 1, 0, -1):
        other = index(random, last + 1)
        result[last], result[other] = result[other], result[last]
    return result
