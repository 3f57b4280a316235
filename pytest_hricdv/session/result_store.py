"""Stores the results of a session's tests until the last one has arrived."""

from __future__ import annotations

import zlib
from collections.abc import KeysView

from pytest_hricdv.results.codec import decode
from pytest_hricdv.results.model import TestResult

FASTEST = 1
"""Level of compression: a quarter of the size in half a millisecond; the best one saves little more."""


class ResultStore:
    """Node id -> result, as compressed JSON: results of thousands of tests would need gigabytes as objects.

    The last one that was put counts, as a test that is run again counts once.
    """

    def __init__(self) -> None:
        self._packed: dict[str, bytes] = {}

    def put(self, nodeid: str, text: str) -> None:
        """Keep a result, as `pytest_hricdv.results.codec.encode` wrote it."""
        self._packed[nodeid] = zlib.compress(text.encode(), FASTEST)

    def nodeids(self) -> KeysView[str]:
        """Of all results."""
        return self._packed.keys()

    def results(self) -> list[TestResult]:
        """All results, in the order in which their tests were first put."""
        return [decode(zlib.decompress(packed)) for packed in self._packed.values()]
