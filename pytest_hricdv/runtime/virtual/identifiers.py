"""`uuid` in a run: identifiers that are the same in each repeat, and of which no two of a run are equal."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from hashlib import sha256
from itertools import count
from typing import Any, cast

from pytest_hricdv.runtime.kernel import running_node
from pytest_hricdv.runtime.virtual.clocks import EPOCH
from pytest_hricdv.runtime.virtual.copies import stand_in


def uuid4() -> uuid.UUID:
    """As of `uuid`, but in a run it is made of how many there were before."""
    node = running_node()
    if node is None:
        return uuid.uuid4()
    numbers: Any = node.kernel.own.setdefault("identifiers", count())
    # Hashed, so that they look as random as real ones: code may use the first digits only. A UUID has 16 bytes.
    return uuid.UUID(bytes=sha256(b"%d" % next(numbers)).digest()[:16], version=4)


def uuid1(node: int | None = None, clock_seq: int | None = None) -> uuid.UUID:
    """As of `uuid`; in a run it names no machine and no time, but is one of `uuid4`."""
    return uuid.uuid1(node, clock_seq) if running_node() is None else uuid4()


def uuid6(node: int | None = None, clock_seq: int | None = None) -> uuid.UUID:
    """As of `uuid` from Python 3.14 on; see `uuid1`."""
    return _real("uuid6")(node, clock_seq) if running_node() is None else uuid4()


def uuid7() -> uuid.UUID:
    """As of `uuid` from Python 3.14 on; in a run it has the time of the run, and later ones are larger."""
    node = running_node()
    if node is None:
        return _real("uuid7")()
    numbers: Any = node.kernel.own.setdefault("timed identifiers", count())
    number = next(numbers)
    # RFC 9562: 48 bits of milliseconds, 4 of version, 12 and (after 2 of variant) 62 bits, here a count and its hash.
    hashed = int.from_bytes(sha256(b"timed %d" % number).digest()[:4], "big")
    high, low = divmod(number << 32 | hashed, 1 << 62)
    now_ms = round(EPOCH.timestamp()) * 1000 + node.kernel.now_us // 1000
    return uuid.UUID(int=now_ms << 80 | 7 << 76 | high << 64 | 2 << 62 | low)


def _real(name: str) -> Callable[..., uuid.UUID]:
    return cast(Callable[..., uuid.UUID], getattr(uuid, name))


_NAMES = {"uuid1": uuid1, "uuid4": uuid4, "uuid6": uuid6, "uuid7": uuid7}

MODULES = (stand_in(uuid, {name: made for name, made in _NAMES.items() if hasattr(uuid, name)}),)
"""What the modules under test see."""
