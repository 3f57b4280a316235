"""The study of public packages: its list, its testbenches, and its tables."""

from __future__ import annotations

import tomllib

from studies.wild import FOLDER, Package, packages
from studies.wild.tables import figures, violated


def of(key: str) -> Package:
    return next(package for package in packages() if package.key == key)


def test_there_are_twenty_packages_of_which_twelve_are_nodes_at_fixed_commits() -> None:
    every = [*packages()]
    assert len(every) == 20
    assert sum(package.kind == "ROS 2" for package in every) >= 12
    assert all(len(source.commit) == 40 for package in every for source in package.sources)


def test_a_testbench_has_at_most_a_hundred_lines() -> None:
    assert {package.key: package.lines() for package in packages() if package.lines() > 100} == {}


def test_each_real_violation_has_a_report() -> None:
    rows = tomllib.loads((FOLDER / "packages.toml").read_text(encoding="utf-8"))
    real = {key for key, row in rows.items() if any(why.startswith("real") for why in row.get("verdicts", {}).values())}
    assert real == {path.stem for path in (FOLDER / "reports").glob("*.md")}


def test_a_row_says_what_was_violated_and_what_could_not_be_run() -> None:
    suite = {"tests": 10, "failed": 2, "statements": {"percent": 71.4}, "requirements": {"R1": {}, "R2": {}}}
    races = {"requirements": ["race"], "counts": False}
    row = {"lines": 80, "suites": {"rl": suite}, "violations": [{"requirements": ["R1"]}, races]}
    assert violated(row) == ["R1"]
    lines = figures({"pupper": row, "tello": {"not_run": "it opens sockets"}}, [of("pupper"), of("tello")]).splitlines()
    assert lines[0] == "1 of 2 packages run, all unmodified. Violated requirements: 1 real, of 1 causes."
    assert any(line.endswith("| Python | 80 | 10 | 71 % | 2 | R1 |") for line in lines)
    assert any(line.endswith("| not run: it opens sockets |") for line in lines)
