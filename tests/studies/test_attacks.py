"""The attacks: they are well formed, and judged strictly."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from studies.attacks import Attack, attacks, judge
from studies.attacks.__main__ import make_project, run, summary


def test_every_attack_can_be_written(tmp_path: Path) -> None:
    project = make_project(tmp_path / "arm")
    kept = {path: path.read_text() for path in project.rglob("*") if path.is_file()}
    for attack in attacks():
        for path, text in kept.items():
            path.write_text(text)
        attack.write(project)


@pytest.mark.parametrize(
    ("output", "status", "wrong"),
    [
        ("arm.py:3: no", 1, ""),
        ("arm.py:3: no", 0, "status 0"),
        ("no", 1, "not seen: arm"),
        ("INTERNALERROR> arm.py:3", 3, "INTERNALERROR"),
        ('Traceback (most recent call last):\n  File "/x/pytest_hricdv/a.py", line 1, in f\n    f()\nE: arm.py:3', 1,
         "a traceback of the tool"),
        ("arm.py:3", -9, "did not end in 150 s"),
    ],
)  # fmt: skip
def test_an_answer_is_judged(tmp_path: Path, output: str, status: int, wrong: str) -> None:
    attack = Attack("hostile", "a", ends="failed", sees=(r"arm\.py:\d",), has=("audit",))
    report = tmp_path / "hri-report" / "report.json"
    report.parent.mkdir()
    report.write_text(json.dumps({"audit": [1]}))
    assert judge(attack, tmp_path, output, [status]).startswith(wrong)
    assert bool(judge(attack, tmp_path, output, [status])) == bool(wrong)
    report.write_text(json.dumps({"audit": []}))
    assert judge(attack, tmp_path, "arm.py:3", [1]) == "no audit in the report"
    report.unlink()
    assert judge(attack, tmp_path, "arm.py:3", [1]) == "no report"


def test_an_attack_on_a_model_is_run(tmp_path: Path) -> None:
    attack = Attack("models", "a", ends="loud", asl="!g.\n+!g <- .", sees=(r"a\.asl:2",))
    result = run(attack, tmp_path)
    assert (result["wrong"], result["statuses"]) == ("", [2])
    assert "| models | 1 | 1 | 0 (0.0 %) |" in summary([result])
