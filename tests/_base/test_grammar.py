"""Parsers are read from the user's cache folder, and built wherever that cannot be done."""

import stat
import sys
from collections.abc import Callable
from pathlib import Path

import lark
import pytest

from pytest_hricdv._base.grammar import lark_parser

GRAMMAR = 'start: "a" start | "b"'


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "pytest-hricdv"


@pytest.fixture
def grammar(tmp_path: Path) -> Path:
    file = tmp_path / "small.lark"
    file.write_text(GRAMMAR, encoding="utf-8")
    return file


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The grammars that were built, not read from the cache."""
    texts: list[str] = []
    build = lark.Lark.__init__

    def counted(self: lark.Lark, text: str, **options: object) -> None:
        if "start:" in text:  # lark builds the parser of its own grammar language, too
            texts.append(text)
        build(self, text, **options)

    monkeypatch.setattr(lark.Lark, "__init__", counted)
    return texts


def test_a_second_process_reads_the_parser_from_the_cache(cache: Path, grammar: Path, built: list[str]) -> None:
    first, second = lark_parser(grammar), lark_parser(grammar)
    assert built == [GRAMMAR]
    assert first.parse("aab") == second.parse("aab")
    assert len(list(cache.iterdir())) == 1


def test_a_changed_grammar_is_built(cache: Path, grammar: Path, built: list[str]) -> None:
    lark_parser(grammar)
    changed = GRAMMAR.replace("b", "c")
    grammar.write_text(changed, encoding="utf-8")
    lark_parser(grammar).parse("aac")
    assert built == [GRAMMAR, changed]


@pytest.mark.parametrize("version", ["lark", "python"])
def test_another_version_builds(
    cache: Path, grammar: Path, built: list[str], monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    lark_parser(grammar)
    monkeypatch.setattr(*((lark, "__version__", "0.0") if version == "lark" else (sys, "version", "0.0")))
    lark_parser(grammar)
    assert len(built) == 2


@pytest.mark.parametrize("damage", [lambda data: b"", lambda data: data[:-10], lambda data: data[:-1] + b"x"])
def test_a_damaged_file_is_ignored_and_written_again(
    cache: Path, grammar: Path, built: list[str], damage: Callable[[bytes], bytes]
) -> None:
    lark_parser(grammar)
    (file,) = cache.iterdir()
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert lark_parser(grammar).parse("b") == lark_parser(grammar).parse("b")
    assert len(built) == 2


@pytest.mark.parametrize("mode", [stat.S_IWGRP, stat.S_IWOTH])
def test_a_folder_that_others_can_write_to_is_not_used(cache: Path, grammar: Path, built: list[str], mode: int) -> None:
    cache.mkdir(parents=True)
    cache.chmod(0o700 | mode)
    lark_parser(grammar)
    lark_parser(grammar)
    assert len(built) == 2
    assert not list(cache.iterdir())
