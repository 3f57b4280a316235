"""The workflow file in the README does what it says, job by job, in a user's project."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

from tests.docs.page import DOCS
from tests.plugin import project

README = DOCS.parent / "README.md"


def _steps(workflow: str) -> list[str]:
    """The workflow's commands, in order, without those that install something."""
    found = re.findall(r"^ +- run: (.*)$", workflow, re.MULTILINE)
    return [command for command in found if not command.startswith("pip ")]


def _run(command: str, folder: Path, summary: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = os.environ | {"PATH": path, "GITHUB_ACTIONS": "true", "GITHUB_STEP_SUMMARY": str(summary)}
    return subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True)


def test_the_workflow_runs_shards_merges_them_and_keeps_the_report(tmp_path: Path) -> None:
    project.write(tmp_path)
    (workflow,) = re.findall(r"^```yaml\n(.*?)^```$", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    shards = re.search(r"shard: \[(.*)\]", workflow)
    assert shards is not None
    run, merge, export = _steps(workflow)
    summary = tmp_path / "job.md"
    for shard in shards[1].split(", "):
        done = _run(run.replace("${{ matrix.shard }}", shard).replace("-n 2", ""), tmp_path, summary)
        assert done.returncode == 0, done.stdout
    merged = _run(merge, tmp_path, summary)
    assert merged.returncode == 0, merged.stdout + merged.stderr
    assert "expected 34, merged 34" in merged.stdout
    exported = _run(export, tmp_path, summary)
    assert exported.returncode == 0, exported.stderr
    report = json.loads((tmp_path / "hri-report" / "report.json").read_text(encoding="utf-8"))
    assert report["reported"] == 34
    assert {path.name for path in (tmp_path / "hri-report").iterdir()} >= {"index.html", "cobertura.xml", "lcov.info"}
    assert summary.read_text(encoding="utf-8").count("## Human-robot interaction: lamps, passed") == 4
    assert (tmp_path / "hri-report-2" / "junit.xml").exists()


def test_what_the_workflow_uploads_is_what_its_commands_write() -> None:
    text = README.read_text(encoding="utf-8")
    uploaded = re.findall(r"^ +path: (.*)$", text, re.MULTILINE)
    written = re.findall(r"(?:--hri-report=|-o )(\S+?(?:\$\{\{.*?\}\})?)(?=\s)", text)
    assert set(uploaded) <= set(written)
