"""What the user's configuration of coverage.py says holds here as well: the same totals, of the same run."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.plugin.project import change, report

SUITE = ("--hri-suite=by-hand", "-p", "no:cacheprovider")
CROSS_CHECK = ("--cov=lamps", "--cov-branch", "--cov-report=json")

MORE = '''

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fractions import Fraction

DEBUG = False


class Lever:
    """A lever."""

    def pull(self) -> None: ...


class Broken(Exception): ...


def shown(level):  # pragma: no cover
    return f"{level} %"


def check_testbench(level):
    assert level >= 0.0
    if DEBUG:
        print("level", level)
    while level:  # pragma: no branch
        level = 0.0
    for number in range(3):  # never ends early
        level += number
    return level


def logged(level):
    if level > 1000.0:
        raise NotImplementedError(level)
    return check_testbench(level)
'''
"""What configurations speak of, behind the guide."""

CALLS = "level = level_for(wish)\n        logged(level)"

INI = {
    "exclude_also": {"setup.cfg": "[coverage:report]\nexclude_also =\n    if DEBUG:\n    class Lever\n"},
    "rcfile": {
        ".coveragerc": "[run]\nomit =\n    lamps/messages.py\n    */unused.py\nrelative_files = true\nparallel = true\n"
        "[report]\nexclude_lines =\n    if DEBUG:\n    raise NotImplementedError\n"
    },
    "pyproject": {
        "pyproject.toml": "[tool.coverage.run]\ncontext = 'lab'\n[tool.coverage.report]\nomit = ['lamps/m*.py']\n"
        "partial_also = ['never ends early', 'if level > 1']\n"
    },
    "dynamic contexts": {".coveragerc": "[run]\ndynamic_context = test_function\n"},
    "patch": {".coveragerc": "[run]\npatch = subprocess\n"},
}

Totals = dict[str, tuple[int, int, int, int]]
"""File -> statements, missing ones, branches, missing ones."""


def grow(folder: Path) -> None:
    """Let the guide have what configurations speak of, and the package a module that nothing imports."""
    guide = folder / "lamps" / "guide.py"
    guide.write_text(guide.read_text(encoding="utf-8") + MORE, encoding="utf-8")
    change(folder, "lamps/guide.py", "level = level_for(wish)", CALLS)
    (folder / "lamps" / "unused.py").write_text("ONE = 1\n\nif ONE:\n    TWO = 2\n", encoding="utf-8")


def coverages(folder: Path) -> Totals:
    """Of coverage.py's own report of the run."""
    written = json.loads((folder / "coverage.json").read_text(encoding="utf-8"))["files"]
    return {
        Path(name).as_posix(): (
            file["summary"]["num_statements"],
            file["summary"]["missing_lines"],
            file["summary"]["num_branches"],
            file["summary"]["missing_branches"],
        )
        for name, file in written.items()
        if file["summary"]["num_statements"]
    }


def ours(folder: Path) -> Totals:
    """Of our report."""
    code: dict[str, Any] = report(folder)["code_under_test"]
    assert code["measured"], code["reason"]
    branches = {file["file"]: len(file["branches"]) for file in code["map"]}
    return {
        file["file"]: (
            file["statements"],
            len(file["missing_lines"]),
            branches[file["file"]],
            len(file["missing_branches"]),
        )
        for file in code["files"]
        if file["statements"]
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", INI)
def test_totals_are_those_of_coverages_own_report_of_the_same_run(lamps: pytest.Pytester, name: str) -> None:
    grow(lamps.path)
    for file, text in INI[name].items():
        (lamps.path / file).write_text(text, encoding="utf-8")
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", *CROSS_CHECK)
    assert ours(lamps.path) == coverages(lamps.path)
    joined = ours(lamps.path)
    if name == "dynamic contexts":  # coverage.py itself then has nothing of what was imported before the first test
        why = "it was imported, but the running measurement (--cov) recorded nothing of it"
        assert report(lamps.path)["code_under_test"]["unmeasured_files"] == {"lamps/messages.py": why}
        return
    lamps.runpytest_inprocess(*SUITE, "-p", "no:xdist", "-p", "no:cov")
    assert ours(lamps.path) == joined


@pytest.mark.skipif(sys.version_info < (3, 12), reason="sys.monitoring came with Python 3.12")
def test_the_core_sysmon_is_told_and_has_no_part_in_our_own_measurement(lamps: pytest.Pytester) -> None:
    grow(lamps.path)
    (lamps.path / ".coveragerc").write_text("[run]\ncore = sysmon\n", encoding="utf-8")
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", *CROSS_CHECK)
    assert "sys.monitoring" in report(lamps.path)["code_under_test"]["reason"]
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", "-p", "no:cov")
    assert ours(lamps.path)["lamps/guide.py"] == coverages(lamps.path)["lamps/guide.py"]


def test_a_configuration_that_leaves_nothing_is_the_reason_why_nothing_is_measured(lamps: pytest.Pytester) -> None:
    (lamps.path / "setup.cfg").write_text("[coverage:run]\nomit = lamps/*\n", encoding="utf-8")
    result = lamps.runpytest_inprocess(*SUITE, "-p", "no:xdist")
    assert result.ret == 0
    code = report(lamps.path)["code_under_test"]
    assert (code["measured"], code["map"]) == (False, [])
    assert code["reason"].endswith("setup.cfg leaves no file of it (source, include, omit)")


def test_a_configuration_that_coverage_refuses_is_one_line(lamps: pytest.Pytester) -> None:
    (lamps.path / ".coveragerc").write_text("[report]\nexclude_also =\n    (\n", encoding="utf-8")
    result = lamps.runpytest_inprocess(*SUITE, "-p", "no:xdist")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: the configuration of coverage.py: Invalid [[]report[]].exclude_also value*"])
    assert "Traceback" not in result.stderr.str()


@pytest.mark.slow
@pytest.mark.skipif(sys.version_info < (3, 12), reason="sys.monitoring is of Python 3.12 and later")
@pytest.mark.parametrize("branches", [True, False])
def test_measuring_with_sys_monitoring_gives_the_same_totals_or_says_that_it_does_not(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, branches: bool
) -> None:
    grow(lamps.path)
    monkeypatch.setenv("COVERAGE_CORE", "sysmon")
    beside = [option for option in CROSS_CHECK if branches or option != "--cov-branch"]
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", *beside)
    code = report(lamps.path)["code_under_test"]
    if code["measured"]:  # it has branches from Python 3.14 on, and before, coverage.py takes its own core
        assert ours(lamps.path) == coverages(lamps.path)
    else:
        assert code["reason"] == "the running measurement uses sys.monitoring: set core = 'ctrace' for coverage"
    lamps.runpytest_subprocess(*SUITE, "-p", "no:xdist", "-p", "no:cov")  # our own measurement has a core of its own
    assert report(lamps.path)["code_under_test"]["measured"]
