"""`uuid` in a run: identifiers that are the same in each repeat, and of which no two of a run are equal."""

from __future__ import annotations

import uuid
from hashlib import sha256
from itertools import count
from typing import Any

from pytest_hricdv.runtime.kernel import running_node
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


MODULES = (stand_in(uuid, {"uuid1": uuid1, "uuid4": uuid4}),)
"""What the modules under test see."""
