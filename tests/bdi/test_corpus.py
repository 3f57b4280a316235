"""``hricdv model corpus``."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pytest_hricdv.bdi.__main__ import main
from pytest_hricdv.bdi.corpus import read_corpus
from pytest_hricdv.bdi.language.errors import BdiError


def _folder(tmp_path: Path, **texts: str) -> Path:
    for name, text in texts.items():
        path = tmp_path / name.replace("__", "/").replace("_asl", ".asl").replace("_mas2j", ".mas2j")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path


def test_table_counts_what_was_parsed_and_what_was_refused_by_kind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = _folder(
        tmp_path,
        good_asl="!go. +!go <- .print(1).",
        one__copy_asl="!go. +!go <- .print(1).",
        one__bad_asl="+!go <- .print(1)\n  !x.",
        two__worse_asl="p.\n+!go <- act(1)\n !y.",
        two__unknown_asl="+!go <- .prnt(1).",
        m_mas2j="MAS m { agents: good; }",
        two__n_mas2j="MAS n { agents: good; }",
    )
    assert main(["corpus", str(folder)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:5] for line in lines[1:3]] == [
        [".asl", "5", "4", "2", "2"],
        [".mas2j", "2", "2", "1", "1"],
    ]
    calls = lines.index("parsed, but a run with such a call ends or does not begin")
    refused = lines[lines.index("refused") + 1 : calls - 1]
    assert refused[0].split(maxsplit=1) == ["2", "expected '.' or ';', found '!'"]
    assert refused[1].strip() == f"first in {folder}/one/bad.asl:2:3"
    assert {line.split(maxsplit=1)[1] for line in refused[2::2]} == {
        "the source of an agent does not exist",
    }
    assert [line.strip() for line in lines[calls + 1 : calls + 3]] == [
        "1  unknown internal action .prnt",
        f"first in {folder}/two/unknown.asl:1:9",
    ]
    assert len(lines) - lines.index("slowest") - 1 == 5


def test_all_prints_each_error_with_its_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = _folder(tmp_path, bad_asl="p :- .", also_asl="p(.")
    assert main(["corpus", str(folder), "--all"]) == 1
    out = capsys.readouterr().out
    assert f"{folder}/bad.asl:1:6: expected" in out
    assert f"{folder}/also.asl:1:3: expected" in out


def test_bytes_that_are_no_text_and_broken_links_are_refused_not_raised(tmp_path: Path) -> None:
    (tmp_path / "bytes.asl").write_bytes(b"p(\xff).")
    (tmp_path / "link.asl").symlink_to(tmp_path / "nowhere.asl")
    (tmp_path / "folder.asl").mkdir()
    (tmp_path / "folder.asl" / "good.asl").write_text("p.")
    corpus = read_corpus(tmp_path)
    assert sorted(result.path.name for result in corpus.failures) == ["bytes.asl", "link.asl"]
    assert corpus.files == {".asl": 3}


@pytest.mark.parametrize("make", [False, True])
def test_folder_without_models_is_one_sentence_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], make: bool
) -> None:
    folder = tmp_path / "models"
    if make:
        folder.mkdir()
    with pytest.raises(BdiError):
        read_corpus(folder)
    assert main(["corpus", str(folder)]) == 2
    assert capsys.readouterr().err.startswith(f"error: {folder}: no ")


def test_a_pipe_among_the_files_is_refused(tmp_path: Path) -> None:
    os.mkfifo(_folder(tmp_path, good_asl="!go.") / "pipe.asl")
    (failure,) = read_corpus(tmp_path).failures
    assert "pipe.asl: not a regular file" in failure.message
