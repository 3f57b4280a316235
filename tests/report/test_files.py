"""A report on disk is whole or the old one, and every refusal says what to do."""

import errno
import json
import math
import os
import sys
from pathlib import Path
from subprocess import run
from typing import IO, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv._base import atomic_file
from pytest_hricdv.report.files import prepare, write
from pytest_hricdv.results.codec import ReportError, canonical, load
from tests.report import sample


@pytest.mark.parametrize("below", [".", "deeper/still"])
def test_prepare_refuses_a_file_in_the_way(tmp_path: Path, below: str) -> None:
    (tmp_path / "hri-report").write_text("a file")
    with pytest.raises(ReportError, match=r"a file is in the way: remove it, or choose another folder"):
        prepare(tmp_path / "hri-report" / below)


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.EACCES, "no permission"),
        (errno.EROFS, "read-only"),
        (errno.ENOSPC, "disk is full"),
        (errno.EIO, "--hri-report"),
    ],
)
def test_prepare_says_why_a_folder_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, remedy: str
) -> None:
    # The tests may run as root, whom no permission stops: the refusal is made here.
    def refuse(path: Path, data: bytes) -> int:
        raise OSError(number, os.strerror(number), str(path))

    monkeypatch.setattr(Path, "write_bytes", refuse)
    with pytest.raises(ReportError, match=remedy) as raised:
        prepare(tmp_path)
    assert str(tmp_path) in str(raised.value)


def test_write_then_load_gives_the_same_report(tmp_path: Path) -> None:
    report = sample.report()
    paths = write(report, tmp_path)
    assert [path.name for path in paths] == ["report.json", "index.html"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["index.html", "report.json"]
    assert load(paths[0]) == report
    assert load(tmp_path) == report


@pytest.mark.parametrize("full_at", [1, 2])
def test_a_failed_write_leaves_whole_files_and_no_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, full_at: int
) -> None:
    old = [path.read_bytes() for path in write(sample.report(tests=1), tmp_path)]
    new = [path.read_bytes() for path in write(sample.report(tests=2), tmp_path / "new")]
    written: list[Path] = []

    def full(path: Path, mode: str) -> IO[bytes]:
        written.append(path)
        if len(written) == full_at:
            path.write_bytes(b"{" * 100)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        return path.open(mode)

    monkeypatch.setattr(atomic_file, "_OPEN", full)
    with pytest.raises(ReportError, match="disk is full"):
        write(sample.report(tests=2), tmp_path)
    assert (tmp_path / "report.json").read_bytes() == (old if full_at == 1 else new)[0]
    assert (tmp_path / "index.html").read_bytes() == old[1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["index.html", "new", "report.json"]


def test_a_page_that_cannot_be_made_does_not_lose_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(report: object) -> str:
        raise ZeroDivisionError("no pixels")

    monkeypatch.setattr("pytest_hricdv.report.html.page", broken)
    with pytest.raises(ReportError, match=r"report\.json is written, but index\.html .*: ZeroDivisionError: no pixels"):
        write(sample.report(tests=2), tmp_path)
    assert load(tmp_path) == sample.report(tests=2)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_refused_with_its_place(tmp_path: Path, value: float) -> None:
    data = sample.data(tests=1)
    data["tests"][0]["requirements"]["R4"]["margin"] = value
    with pytest.raises(ReportError, match=r"\$\.tests\[0\]\.requirements\.R4\.margin"):
        write(sample.typed(data), tmp_path)
    assert list(tmp_path.iterdir()) == []


@given(st.dictionaries(st.text(st.characters(codec=None)), st.floats(allow_nan=False, allow_infinity=False)))
def test_canonical_text_is_ascii_and_reads_back(data: dict[str, float]) -> None:
    assert json.loads(canonical(data).encode("ascii")) == data


def _cut(text: str) -> str:
    return text[: len(text) // 2]


def _other_schema(text: str) -> str:
    return text.replace("hricdv-report/3", "hricdv-report/9")


def _no_outcome(text: str) -> str:
    report: Any = json.loads(text)
    del report["tests"][0]["outcome"]
    return json.dumps(report)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_cut, r"report\.json:\d+:\d+: not JSON, perhaps cut off"),
        (_other_schema, r"expected schema 'hricdv-report/3', found 'hricdv-report/9'"),
        (_no_outcome, r"report\.json: .* missing required field `outcome` - at `\$\.tests\[0\]`"),
        (lambda _: "{}", r"found None"),
        (lambda _: "", r"report\.json:1:1: not JSON"),
    ],
)
def test_load_locates_what_is_wrong(tmp_path: Path, spoil: Any, message: str) -> None:
    path, _ = write(sample.report(tests=1), tmp_path)
    path.write_text(spoil(path.read_text()))
    with pytest.raises(ReportError, match=message):
        load(path)


def test_importing_the_views_loads_no_template_engine() -> None:
    views = "from pytest_hricdv.report import explanation, exports, files, junit, markdown, terminal, totals"
    code = f"import sys; {views}; print(sorted({{'jinja2', 'numpy', 'coverage'}} & set(sys.modules)))"
    shown = run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"
