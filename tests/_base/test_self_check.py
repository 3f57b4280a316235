"""What the code under test replaces for the whole process is noticed, and makes no difference to results."""

from __future__ import annotations

import builtins
import hashlib
import json
import math
import os
import time
import zlib
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.self_check import complaint, wrong_answers
from pytest_hricdv.runtime.record import Recorder

REPLACED: dict[str, tuple[Any, str, Any]] = {
    "hashlib.sha256": (hashlib, "sha256", lambda data=b"", **_: hashlib.md5(data)),
    "hashlib.new": (hashlib, "new", lambda name, data=b"", **_: hashlib.md5(data)),
    "json.dumps": (json, "dumps", lambda value, **_: "{}"),
    "json.loads": (json, "loads", lambda text, **_: None),
    "zlib.crc32": (zlib, "crc32", lambda data, start=0: 0),
    "zlib.compress": (zlib, "compress", lambda data, level=-1: b""),
    "math.sqrt": (math, "sqrt", lambda value: value),
    "time.monotonic": (time, "monotonic", lambda: math.nan),
    "builtins.sorted": (builtins, "sorted", lambda items, **_: list(items)),
    "builtins.round": (builtins, "round", lambda value, digits=None: int(value)),
}


def test_nothing_is_wrong_at_first() -> None:
    assert wrong_answers() == ()


@pytest.mark.parametrize("name", REPLACED)
def test_what_answers_wrongly_is_named(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(*REPLACED[name])
        wrong = wrong_answers()
    assert wrong == (name,)
    assert complaint(wrong).startswith(f"{name} of Python's library answers wrongly: the code under test has replaced")


def test_what_raises_or_is_gone_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.delattr(hashlib, "sha256")
        patch.setattr(json.encoder.JSONEncoder, "encode", lambda self, value: 1 / 0)
        wrong = wrong_answers()
    assert wrong == ("hashlib.sha256", "json.dumps")


def _sha256() -> str:
    recorder = Recorder()
    recorder.signal(0.0, "lamp_level", 0.5)
    recorder.signal(1.0, "mode", "on")
    return recorder.finish().sha256


def test_the_hash_of_a_record_is_the_same_whatever_is_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    before = _sha256()
    with monkeypatch.context() as patch:
        for name in ("hashlib.sha256", "hashlib.new", "json.dumps", "json.loads"):
            patch.setattr(*REPLACED[name])
        patch.setattr(json.encoder.JSONEncoder, "encode", lambda self, value: "x")
        patch.setattr(json.encoder.JSONEncoder, "default", lambda self, value: "x")
        after = _sha256()
    assert after == before


def test_a_file_is_written_though_open_and_replace_do_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", lambda *_: None)
        patch.setattr(builtins, "open", lambda *_, **__: None)
        write_text(tmp_path / "report.json", "{}")
    assert (tmp_path / "report.json").read_text(encoding="utf-8") == "{}"
