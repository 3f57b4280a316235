from __future__ import annotations

import os
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.bdi.__main__ import main as bdi
from pytest_hricdv.extra.draft.first_runs import _run_command
from pytest_hricdv.monitor.requirement import FormulaSource
from pytest_hricdv.monitor.syntax_tree import syntax_tree
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
            for requirement in tomllib.loads(file.read_text(encoding="utf-8")).values():
                syntax_tree(FormulaSource(requirement["formula"]), "formula")
        elif file.suffix == ".mas2j":
            assert bdi(["lint", str(file)]) == 0
    check = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "F821,F811", str(tmp_path / "hri")]
    found = subprocess.run(check, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kills by a signal of POSIX")
def test_a_process_that_the_code_leaves_behind_keeps_no_first_run_waiting(tmp_path: Path) -> None:
    child = "[sys.executable, '-c', 'import signal; signal.pause()']"
    command = [sys.executable, "-c", f"import subprocess, sys; print(subprocess.Popen({child}).pid)"]
    text, status, _ = _run_command(command, tmp_path, tmp_path / "seen.json", 60.0)
    os.kill(int(text), signal.SIGKILL)
    assert status == 0
