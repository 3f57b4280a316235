from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.bdi.__main__ import main as bdi
from tests.extra.draft.hostile_packages import write_package

SEEDS = [*range(10), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(10, 50))]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_package_has_a_draft_that_can_be_read_or_one_sentence(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    package = write_package(seed, tmp_path)
    before = {*tmp_path.rglob("*")}
    monkeypatch.chdir(tmp_path)
    status = main(["init", "hri", "--from", package, "--no-run"])
    error = capsys.readouterr().err
    new = {path for path in {*tmp_path.rglob("*")} - before if not path.is_relative_to(tmp_path / "hri")}
    assert not new
    if status == 2:
        assert error.startswith("error: init: ")
        assert error.count("\n") == 1
        assert not (tmp_path / "hri").exists()
        return
    for file in (tmp_path / "hri").rglob("*.*"):
        if file.suffix == ".py":
            compile(file.read_text(encoding="utf-8"), file.name, "exec")
        elif file.suffix == ".toml":
            tomllib.loads(file.read_text(encoding="utf-8"))
        elif file.suffix == ".mas2j":
            assert bdi(["lint", str(file)]) == 0
    check = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "F821,F811", str(tmp_path / "hri")]
    found = subprocess.run(check, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
