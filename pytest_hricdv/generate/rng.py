"""Random streams (`make_rng`), seeds (`derive_seed`) and digests (`digest`), each determined by its key alone.

All modules that draw something use these functions; no two share a stream. Only `Random.random()` is called: it is the
one method whose sequence Python promises to keep, so a seed in a suite or a report means the same test for years.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Mapping, Sequence
from hashlib import sha256
from itertools import accumulate
from random import Random
from typing import TypeVar

from pytest_hricdv._base import own_json as json

T = TypeVar("T")

#: A part of a key: plain data, such as the name of a suite, a seed, and what is drawn.
Json = None | bool | int | float | str | Sequence["Json"]


def canonical_json(value: object) -> str:
    """The one JSON text of a value: sorted keys, no spaces, ASCII, exact floats.

    Raises:
        ValueError: a float is NaN or infinite.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)


def digest(*key: Json) -> str:
    """SHA-256 (hex) of the key's canonical JSON."""
    return sha256(canonical_json(key).encode("ascii")).hexdigest()


def derive_seed(*key: Json) -> int:
    """A seed of 63 bits: it fits into a signed 64-bit integer."""
    # 16 hexadecimal digits are 64 bits; any part of SHA-256 is as good as another.
    return int(digest(*key)[:16], 16) >> 1


def make_rng(*key: Json) -> Random:
    """The random stream of a key."""
    return Random(derive_seed(*key))


def random_index(rng: Random, count: int) -> int:
    """One of 0 .. count-1, each equally likely (to within 2**-53)."""
    return min(int(rng.random() * count), count - 1)


def pick(rng: Random, choices: Sequence[T]) -> T:
    """One of the choices, each equally likely."""
    return choices[random_index(rng, len(choices))]


def pick_weighted(rng: Random, weights: Mapping[T, float]) -> T:
    """One of the keys, each with a probability in proportion to its weight."""
    *sums, total = accumulate(weights.values())
    return [*weights][bisect(sums, rng.random() * total)]


def shuffle(rng: Random, items: Sequence[T]) -> list[T]:
    """The items in random order (Fisher and Yates)."""
    result = list(items)
    for last in range(len(result) - 1, 0, -1):
        other = random_index(rng, last + 1)
        result[last], result[other] = result[other], result[last]
    return result
