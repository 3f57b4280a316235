"""The study of public packages: its list, its testbenches, and its tables."""

from __future__ import annotations

import tomllib

from studies.wild import FOLDER, Package, packages
from studies.wild.known import known_bugs
from studies.wild.tables import figures, is_found, known_figures, violated


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


def test_a_known_bug_is_there_at_two_commits_with_one_testbench_and_a_report() -> None:
    every = [*known_bugs()]
    assert len(every) >= 15
    assert all(bug.before.sources[0].commit != bug.fix.sources[0].commit for bug in every)
    assert all(bug.before.benches == bug.fix.benches and bug.text and bug.report.startswith("https") for bug in every)
    packages_of = [bug.before.sources[0].repository for bug in every]
    assert max(packages_of.count(name) for name in packages_of) <= 4
    assert {bug.key: bug.before.lines() for bug in every if bug.before.lines() > 100} == {}


def test_a_bug_is_found_if_its_requirement_fails_before_and_holds_at_the_fix() -> None:
    bug = next(known_bugs())
    own = {"passed": 0, "failed": 0, "error": 0, "find": []}
    row = {"lines": 90, "found_by": ["rl"], "fix_violated_by": [], "fix_checks": 3, "own": own, "violations": []}
    assert is_found(row)
    assert not is_found({**row, "fix_violated_by": ["rl"]})
    assert not is_found({**row, "fix_checks": 0})
    lines = known_figures({bug.key: row}, [bug]).splitlines()
    assert lines[2].startswith("1 of 1 known bugs found: 1 by `rl`, 0 by `closure`, 0 by schedules")
    assert any(line.endswith("| 90 | yes | no | - | holds | none | yes |") for line in lines)


def test_schedules_have_a_dash_where_nothing_took_turns() -> None:
    bug = next(known_bugs())
    own = {"passed": 2, "failed": 0, "error": 0, "find": []}
    row = {
        "lines": 90,
        "found_by": ["closure alone"],
        "fix_violated_by": [],
        "fix_checks": 3,
        "own": own,
        "violations": [],
    }
    alone = {**row, "schedules": {"runs": 0, "ended": "nothing to order"}}
    lines = known_figures({bug.key: alone}, [bug]).splitlines()
    assert "1 by `closure`, 0 by schedules, which had something to order in 0." in lines[2]
    assert any(line.endswith("| 90 | no | yes | - | holds | none | yes |") for line in lines)
    ordered = {**row, "schedules": {"runs": 20, "ended": "done"}}
    lines = known_figures({bug.key: ordered}, [bug]).splitlines()
    assert any(line.endswith("| 90 | no | yes | no | holds | none | yes |") for line in lines)
