"""The entries of a session's tests while it goes on: packed, as thousands of them wait for the last one."""

from __future__ import annotations

import json
import zlib
from collections.abc import KeysView

from pytest_hricdv.closure.closing import Entry

FASTEST = 1
"""Level of compression: a quarter of the size in half a millisecond; the best one saves little more."""


class Entries:
    """Node id -> entry; the last one that was put counts, as a test that is run again counts once."""

    def __init__(self) -> None:
        self._packed: dict[str, bytes] = {}

    def put(self, nodeid: str, entry: Entry) -> None:
        """Keep an entry, which must have a JSON."""
        self._packed[nodeid] = zlib.compress(json.dumps(entry).encode("ascii"), FASTEST)

    def nodeids(self) -> KeysView[str]:
        """Of all entries."""
        return self._packed.keys()

    def unpacked(self) -> list[Entry]:
        """All entries, in the order in which their tests were first put; each call makes new ones."""
        return [json.loads(zlib.decompress(packed)) for packed in self._packed.values()]
