"""Signed entries of pytest's cache, for data that decide which tests exist: only entries written by this user are read.

`session.suites`, `coverage.reachability` and the closing loop keep suites and explored models with `write` and `read`.
The cache is in the project: a checkout, an archive or a CI cache may contain a forged one, for instance with a suite
that lacks the failing tests. So each entry has a seal (HMAC-SHA-256, RFC 2104) over its key, content and the plugin's
version. The secret is a file in the user's state folder that nobody else can read. An entry without a valid seal is
ignored; without a secret, all are. Any process of this user can read the secret, including code under test; but that
code needs no cache to do harm.
"""

from __future__ import annotations

import contextlib
import hmac
import json
import os
import secrets
import stat
import sys
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pytest_hricdv._base.contained import open_unlinked
from pytest_hricdv._base.input_file import from_cache

FILE = "cache.key"
_SECRET_BYTES = 32
"""Size (bytes) of the secret: that of the hash (RFC 2104: fewer bytes are weaker, more are not stronger)."""


def read(cache: Any | None, key: str) -> Any:
    """A cache entry; None if there is none that a session of this user wrote.

    Args:
        cache: `config.cache`, or None if the cache plugin is off.
        key: as of `Cache.get`; a hash of all that the content depends on.
    """
    entry, secret = from_cache(cache, key), _secret(_folder())
    if not isinstance(entry, dict) or secret is None:
        return None
    content, seal = entry.get("content"), entry.get("seal")
    return content if isinstance(seal, str) and _same(seal, _seal(secret, key, content)) else None


def write(cache: Any | None, key: str, content: object) -> None:
    """Keep plain data, where there is a cache, and a secret to seal it with."""
    secret = None if cache is None else _secret(_folder())
    if cache is not None and secret is not None:
        cache.set(key, {"content": content, "seal": _seal(secret, key, content)})


def _same(seal: str, expected: str) -> bool:
    return hmac.compare_digest(seal.encode("utf-8", "replace"), expected.encode())


def _seal(secret: bytes, key: str, content: object) -> str:
    text = json.dumps([key, version("pytest-hricdv"), content], sort_keys=True)
    return hmac.new(secret, text.encode("ascii"), "sha256").hexdigest()


def _folder() -> Path | None:
    """The folder of the user's state (XDG Base Directory Specification); None without a home folder."""
    try:
        named = Path(os.environ.get("XDG_STATE_HOME", ""))  # a relative one is to be ignored: it may lie in a checkout
        return (named if named.is_absolute() else Path.home() / ".local" / "state") / "pytest-hricdv"
    except RuntimeError:
        return None


@lru_cache(maxsize=8)  # more than one: tests of the plugin have a home each
def _secret(folder: Path | None) -> bytes | None:
    """The secret of this user, created if missing; None if others could read it."""
    if folder is None:
        return None
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_own(folder.stat(), stat.S_IWGRP | stat.S_IWOTH):
            return None
        with contextlib.suppress(FileExistsError):
            file = os.open(folder / FILE, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with open(file, "wb") as new:
                new.write(secrets.token_bytes(_SECRET_BYTES))
        with open(open_unlinked(folder / FILE, os.O_RDONLY), "rb") as kept:
            is_own = _is_own(os.fstat(kept.fileno()), stat.S_IRWXG | stat.S_IRWXO)
            secret = kept.read(_SECRET_BYTES + 1)
    except OSError:
        return None
    return secret if is_own and len(secret) == _SECRET_BYTES else None


def _is_own(status: os.stat_result, of_others: int) -> bool:
    """Whether a file or folder is this user's, and others have none of these rights."""
    if sys.platform == "win32":
        return True  # the user's profile is private; the mode says nothing there
    return status.st_uid == os.getuid() and not status.st_mode & of_others
