"""What a closing loop led to, in pytest's cache."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence

import msgspec

from pytest_hricdv._base.input_file import from_cache
from pytest_hricdv.extra.closing.records import ClosingResult
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.suite import Suite
from pytest_hricdv.results.building import GeneratedSuite
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.suites import CACHE_FOLDER


class KeptSuite:
    """A suite with its evidence, and with the files that its runs loaded: where one has changed, it does not hold.

    Args:
        collection: of the session.
        key: of all else that the suite depends on.
    """

    def __init__(self, collection: Collection, key: str) -> None:
        self._cache = getattr(collection.config, "cache", None)
        self._root = collection.config.rootpath
        self._key = f"{CACHE_FOLDER}/{key}"

    def read(self) -> GeneratedSuite | None:
        """The suite; None where there is none, or it is of other files."""
        kept = from_cache(self._cache, self._key)
        try:
            if kept is None or kept["files"] != self._digests(kept["files"]):
                return None
            closing = msgspec.json.decode(kept["closing"], type=ClosingResult)
            return GeneratedSuite(Suite.from_json(kept["suite"]), 0.0, cached=True, closing=closing)
        except (GenerateError, KeyError, TypeError, msgspec.DecodeError):
            return None  # written by another version, or cut off

    def write(self, suite: Suite, closing: ClosingResult, files: Sequence[str]) -> None:
        """Keep a suite."""
        if self._cache is not None:
            evidence = msgspec.json.encode(closing).decode()
            digests = self._digests(dict.fromkeys(files, ""))
            self._cache.set(self._key, {"files": digests, "suite": suite.to_json(), "closing": evidence})

    def _digests(self, files: Mapping[str, str]) -> dict[str, str]:
        digests = {}
        for name in files:
            path = self._root / name
            digests[name] = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        return digests
