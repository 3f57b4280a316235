"""The comparison with other tools: faults fit, machines know the commands, figures are those of the journals."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from studies.fair_fight import CODE_BASES, faults, meter, tables
from studies.fair_fight.__main__ import PAGE, read
from studies.fair_fight.running import summary
from studies.localization.faults import FaultError

TABLE = next(base for base in CODE_BASES if base.name == "table")


def test_the_sealed_faults_fit_the_code_and_are_those_that_the_seed_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "controller"]:
        monkeypatch.delitem(sys.modules, name)  # that of this checkout
    TABLE.fill(tmp_path / "table", tmp_path)
    assert faults.draw(tmp_path / "table", TABLE.map(tmp_path / "table")) == faults.sealed("table")
    for fault in faults.sealed("table"):
        file = tmp_path / "table" / fault["file"]
        before = file.read_text(encoding="utf-8")
        faults.plant(fault, tmp_path / "table")
        with pytest.raises(FaultError, match=fault["id"]):
            faults.plant(fault, tmp_path / "table")
        file.write_text(before, encoding="utf-8")


def test_what_people_decided_during_a_run_is_what_is_replayed() -> None:
    action = ConcreteAction("wait", {"wait_s": 1.0})
    given = ConcreteTest("t", "t", 1, (), {"battery": 0.5})
    decided, cut = replace(given, actions=(action, action)), replace(given, actions=(action,))
    assert meter.repeatable(given, decided) == decided
    assert meter.repeatable(decided, cut) == decided
    assert meter.repeatable(decided, replace(decided, run={"battery": 0.4})).run == {"battery": 0.4}


def test_each_code_base_has_ten_sealed_faults() -> None:
    sealed = json.loads(faults.KEPT.read_text(encoding="utf-8"))
    assert {name: len(kept) for name, kept in sealed.items()} == {base.name: faults.MOST for base in CODE_BASES}


def run(second: float, actions: int, *kinds: str, statements: int = 0, test: str = "") -> dict[str, object]:
    return {
        "s": second,
        "actions": actions,
        "kinds": [*kinds],
        "statements": hex(statements),
        "branches": "0x0",
        "test": test or f"{second}",
    }


def test_a_summary_has_the_first_and_the_shortest_violation() -> None:
    runs = [run(1.0, 3, statements=3), run(2.0, 5, "R1", statements=5), run(3.0, 2, "R1", "R2")]
    assert summary(runs, 4, 2) == {
        "runs": 3,
        "statements": [3, 4],
        "branches": [0, 2],
        "kinds": {"R1": {"first_s": 2.0, "shortest": 2}, "R2": {"first_s": 3.0, "shortest": 2}},
        "first_s": 2.0,
        "shortest": 2,
    }


def test_each_violation_that_was_found_is_judged() -> None:
    judged = tables.verdicts()
    for key, row in read().items():
        assert {*row.get("kinds", ())} <= {*judged.get(key.partition("/")[0], ())}, key


def test_the_page_has_the_figures_of_the_results() -> None:
    assert tables.figures(read()) in PAGE.read_text(encoding="utf-8")


def test_a_row_counts_no_false_alarm_as_a_violation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "verdicts", lambda: {"table": {"R1": "real: as known", "R2": "false alarm: ours"}})
    kinds = {"R1": {"first_s": 9.0, "shortest": 4}, "R2": {"first_s": 1.0, "shortest": 1}}
    row = {"budget_s": 90.0, "used_s": 91.0, "machine": "m", "runs": 7, "statements": [3, 4], "branches": [1, 2]}
    lines = tables.figures({"table/rl": {**row, "kinds": kinds, "noticed": {"a": ["R1"], "b": []}, "control": []}})
    assert "| ours, `rl` | 7 | 75 % | 50 % | 1 | 9 | 4 | 1 of 10 | 1 |" in lines
    assert "| R2 | all that ran | false alarm: ours |" in lines
