"""The cache: what this user's sessions wrote comes back; whatever somebody else put there is as if it were missing."""

from __future__ import annotations

import copy
import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_hricdv._base import sealed_cache

SUITE = {"tests": ["a", "b"], "margin": 0.1, "name": "é\ud800"}


class Cache(dict[str, object]):
    """As pytest's."""

    def set(self, key: str, value: object) -> None:
        self[key] = copy.deepcopy(value)


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    sealed_cache._secret.cache_clear()
    yield tmp_path
    sealed_cache._secret.cache_clear()


def kept() -> Cache:
    cache = Cache()
    sealed_cache.write(cache, "k", SUITE)
    return cache


def test_what_was_written_comes_back(home: Path) -> None:
    assert sealed_cache.read(kept(), "k") == SUITE
    assert sealed_cache.read(None, "k") is None
    assert sealed_cache.read(Cache(), "k") is None
    file = home / "pytest-hricdv" / "cache.key"
    assert (file.stat().st_size, stat.S_IMODE(file.stat().st_mode) & 0o077) == (32, 0)


@pytest.mark.parametrize(
    "entry",
    [
        SUITE,
        {"content": SUITE},
        {"content": SUITE, "seal": ""},
        {"content": SUITE, "seal": "0" * 64},
        {"content": SUITE, "seal": "\ud800é"},
        {"content": SUITE, "seal": None},
        [SUITE],
        "suite",
        None,
    ],
)
def test_an_entry_without_a_seal_that_holds_is_none(entry: object) -> None:
    assert sealed_cache.read(Cache(k=entry), "k") is None


def test_an_entry_holds_for_its_own_key_and_version_only(monkeypatch: pytest.MonkeyPatch) -> None:
    cache = kept()
    cache["other"] = cache["k"]  # a suite of another seed, say
    assert sealed_cache.read(cache, "other") is None
    monkeypatch.setattr(sealed_cache, "version", lambda name: "0.0.1")
    assert sealed_cache.read(cache, "k") is None


def test_the_seal_of_another_user_does_not_hold(home: Path) -> None:
    cache = kept()
    (home / "pytest-hricdv" / "cache.key").write_bytes(b"x" * 32)
    sealed_cache._secret.cache_clear()
    assert sealed_cache.read(cache, "k") is None


def damage(home: Path, how: str) -> None:
    """What keeps a secret from being one."""
    folder = home / "pytest-hricdv"
    file = folder / "cache.key"
    if how == "no folder can be made":
        file.unlink()
        folder.rmdir()
        folder.write_text("in the way")
    elif how == "others may read it":
        file.chmod(0o644)
    elif how == "others may replace it":
        folder.chmod(0o777)
    elif how == "a link":
        file.rename(home / "elsewhere")
        file.symlink_to(home / "elsewhere")
    else:
        file.write_bytes(b"short")


@pytest.mark.skipif(os.name == "nt", reason="modes and links")
@pytest.mark.parametrize(
    "how", ["no folder can be made", "others may read it", "others may replace it", "a link", "cut off"]
)
def test_without_a_secret_nothing_is_read_or_written(home: Path, how: str) -> None:
    cache = kept()
    damage(home, how)
    sealed_cache._secret.cache_clear()
    assert sealed_cache.read(cache, "k") is None
    empty = Cache()
    sealed_cache.write(empty, "k", SUITE)
    assert empty == {}
