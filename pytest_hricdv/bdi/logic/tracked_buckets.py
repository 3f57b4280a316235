"""Beliefs of which each lookup is noticed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pytest_hricdv.bdi.language.terms import Key
from pytest_hricdv.bdi.logic.beliefs import Bucket


class TrackedBuckets(dict[Key, Bucket]):
    """Beliefs by predicate; a function is called before each read."""

    def __init__(self, buckets: dict[Key, Bucket], note_read: Callable[[Key], None]) -> None:
        super().__init__(buckets)
        self._note_read = note_read

    def get(self, key: Key, default: Any = None) -> Any:
        """The beliefs of a predicate."""
        self._note_read(key)
        return super().get(key, default)

    def peek(self, key: Key) -> Bucket | None:
        """The beliefs of a predicate, without calling the function."""
        return super().get(key)
