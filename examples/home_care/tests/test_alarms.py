"""The page about false alarms says what the reports of its sessions have."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from studies.alarms import page, seeded

from studies import alarms


def report(*tests: tuple[str, str, str], selected: int = 0) -> dict[str, Any]:
    """Of tests: id, suite and outcome."""
    return {
        "selected": selected or len(tests),
        "reported": len(tests),
        "requirements": {"N4": {}},
        "suites": [{"name": name} for name in dict.fromkeys(suite for _, suite, _ in tests)],
        "tests": [
            {
                "id": name,
                "suite": suite,
                "outcome": outcome,
                "failure": "N4 failed\nat 3 s" if outcome == "failed" else "",
                "sim_s": 1800.0,
                "requirements": {"N4": {"triggers": 2}},
            }
            for name, suite, outcome in tests
        ],
    }


def test_only_what_is_not_declared_is_an_alarm() -> None:
    held = seeded(3, report(("rl-1", "rl", "passed"), ("rl-2", "rl", "known-violation"), ("h-1", "by-hand", "failed")))
    assert [(alarm.test, alarm.suite, alarm.seed, alarm.text) for alarm in held.alarms] == [
        ("h-1", "by-hand", 3, "N4 failed at 3 s")
    ]
    text = page([held], "the command")
    assert "**1 of 3 runs have a false alarm.** 1 have known violations." in text
    assert "| by-hand | 1 | 1 | 1 |" in text
    assert "| N4 | 3 |" in text
    assert "- h-1, seed 3: N4 failed at 3 s" in text


def test_a_test_without_a_result_is_an_alarm() -> None:
    assert [alarm.test for alarm in seeded(0, report(("rl-1", "rl", "passed"), selected=3)).alarms] == ["2 tests"]


def test_what_is_there_is_not_run_again_unless_it_is_of_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran: list[int] = []

    def run(seed: int, suites: str, tests: int, workers: int, folder: Path) -> None:
        ran.append(seed)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "report.json").write_text(json.dumps(report(("rl-1", "rl", "passed"))), encoding="utf-8")

    monkeypatch.setattr(alarms, "_run", run)
    for _ in range(2):
        assert len(list(alarms.sessions_of((7, 8), "rl", 1, 1, tmp_path))) == 2
    assert ran == [7, 8]
    list(alarms.sessions_of((7, 8), "rl", 4, 1, tmp_path))
    assert ran == [7, 8, 7, 8]
