"""Native values of TOML (pytest 9): a key of the ini file means the same whichever type its value has."""

from __future__ import annotations

from importlib.metadata import version

import pytest

from tests.plugin.project import A_WORKER, report

pytestmark = [
    pytest.mark.slow,  # each test is a session or several
    pytest.mark.skipif(int(version("pytest").split(".")[0]) < 9, reason="older ones have texts only"),
]

HEAD = 'pythonpath = ["."]\naddopts = ["-p", "no:hypothesispytest"]\n'
NATIVE = """
hri_suite = ["by-hand", "bdi-random"]
hri_seed = 7
hri_tests = 3
hri_concretizations = 2
hri_no_cov = true
hri_strict = false
hri_fail_on_nc = false
hri_shrink_seconds = 20
hri_mutate = false
hri_report = "made"
hri_rl = ["gamma=0.2"]
hri_fail_under = ["plans=0"]
hri_known_violations = ["R2: the hall has no dimmer"]
hri_allow_nc = ["R1: often", "R2: often", "R3: often"]
hri_testpaths = ["test_lamps.py"]
hri_summary = "summary.md"
hri_film = false
"""


def write_toml(lamps: pytest.Pytester, name: str, keys: str) -> None:
    """The project's settings as TOML."""
    (lamps.path / "pytest.ini").unlink()
    table = {"pytest.toml": "[pytest]\n", "pyproject.toml": "[tool.pytest]\n"}[name]
    (lamps.path / name).write_text(f"{table}{HEAD}{keys}", encoding="utf-8")


@pytest.mark.parametrize("name", ["pytest.toml", "pyproject.toml"])
@pytest.mark.parametrize("options", [(), A_WORKER], ids=["plain", "on a worker"])
def test_all_kinds_of_keys(lamps: pytest.Pytester, name: str, options: tuple[str, ...]) -> None:
    write_toml(lamps, name, NATIVE)
    result = lamps.runpytest_inprocess(*options)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["hri: lamps, suite* by-hand*bdi-random, seed 7*", "PASSED  *"])
    assert (lamps.path / "made" / "report.json").is_file()
    assert (lamps.path / "summary.md").is_file()


def test_the_command_line_wins(lamps: pytest.Pytester) -> None:
    write_toml(lamps, "pytest.toml", 'hri_suite = "by-hand"\nhri_seed = 7\nhri_known_violations = ["R2: dark"]\n')
    lamps.runpytest_inprocess("--hri-seed=1").stdout.fnmatch_lines(["hri: lamps, suite by-hand, seed 1, *"])
    lamps.runpytest_inprocess("-o", "hri_seed=2").stdout.fnmatch_lines(["hri: lamps, suite by-hand, seed 2, *"])


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("hri_no_cov = 'yes'", ""),
        ("hri_known_violations = 'R2: the hall has no dimmer'", ""),
        ("hri_known_violations = '''\nR2: the hall has no dimmer\n'''", ""),
        ("hri_testpaths = 'test_lamps.py'", ""),
        ("hri_shard = 1", ""),  # no key of ours: pytest warns
        ("hri_seed = 1.5", "hri_seed = 1.5: expected a whole number"),
        ("hri_seed = true", "hri_seed = true: expected a whole number"),
        ("hri_seed = nan", "hri_seed = nan: expected a whole number"),
        ("hri_seed = [1, 2]", "hri_seed = 1,2: expected a whole number"),
        ("hri_tests = 0", "hri_tests = 0: expected at least 1"),
        ("hri_tests = 1979-05-27", "hri_tests = 1979-05-27: expected a whole number"),
        (
            "hri_seed = {a = 1}",
            "pytest.toml: hri_seed: expected a string, a number or a list of these; a table has no *",
        ),
        (
            "hri_suite = [['rl']]",
            "pytest.toml: hri_suite: expected a string, a number or a list of these; a list in a *",
        ),
        ("hri_strict = 'maybe'", "pytest.toml: hri_strict: expected true or false, got 'maybe'"),
        ("hri_strict = 1", "pytest.toml: hri_strict: expected true or false, got 1"),
        ("hri_strict = []", "pytest.toml: hri_strict: expected true or false, got []"),
        ("hri_fail_under = 90", "hri_fail_under: 90: expected KIND=PCT*"),
        ("hri_rl = [0.2]", "hri_rl: 0.2: *"),
        ("hri_allow_nc = [true]", "hri_allow_nc: 'true': expected 'REQUIREMENT*"),
    ],
)
def test_each_value_is_taken_or_refused_in_a_line(lamps: pytest.Pytester, keys: str, expected: str) -> None:
    write_toml(lamps, "pytest.toml", f"{keys}\n")
    result = lamps.runpytest_inprocess("--hri-suite=rl" if "rl" in keys else "--hri-suite=by-hand")
    if not expected:
        assert result.ret in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
        assert report(lamps.path)["tests"]
        return
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: *{expected}"])
    assert "INTERNALERROR" not in result.stdout.str() + result.stderr.str()
