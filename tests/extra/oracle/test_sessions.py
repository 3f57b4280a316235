"""A run compared with an agent of the model: the verdict MODEL in every view, as that of a requirement."""

from __future__ import annotations

import pytest

from tests.plugin.project import change, report

SUITE = "--hri-suite=rl"
DECLARED = """
        oracle=ModelOracle(
            agent="guide",
            percepts=(PerceptMapping("asked", "on(wish)", source="visitor"),),
            actions=(ActionMapping("switch", "on(switched)", within_s=(0.2, 0.4)),),
        ),
"""


@pytest.fixture
def compared(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project, with the agent of the guide as an oracle."""
    change(
        lamps.path,
        "conftest.py",
        "Concretization, CrossProduct, ",
        "ActionMapping, Concretization, CrossProduct, ModelOracle, PerceptMapping, ",
    )
    change(lamps.path, "conftest.py", "        run=run,\n", f"        run=run,{DECLARED}")
    return lamps


@pytest.mark.slow
def test_a_run_that_conforms_passes_and_is_reported(compared: pytest.Pytester) -> None:
    result = compared.runpytest_inprocess("-vv", SUITE)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["  R3 *", "  model", "  MODEL The code * 0 *"])
    written = report(compared.path)
    assert written["requirements"]["MODEL"]["text"] == "switch after 0.2 to 0.4 s"
    assert {test["requirements"]["MODEL"]["verdict"] for test in written["tests"]} == {"Passed", "NC"}


@pytest.mark.slow
def test_a_run_that_deviates_fails_and_says_how(compared: pytest.Pytester) -> None:
    change(compared.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 0.6")
    result = compared.runpytest_inprocess("-v", SUITE)
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "MODEL Failed: The code under test does what the agent guide does, in time, and nothing else",
            "  triggered at * violated at *: expected switch 0.2 to 0.4 s after * s (plan @g2 of guide, observed by "
            "on(switched)); observed nothing",
            "others:  R1 Passed, R2 Passed, R3 Passed",
        ]
    )
    failed = [test for test in report(compared.path)["tests"] if test["requirements"]["MODEL"]["verdict"] == "Failed"]
    assert all("expected switch" in test["requirements"]["MODEL"]["violations"][0]["text"] for test in failed)
    assert failed


@pytest.mark.slow
def test_a_deviation_can_be_known_and_shrunk(compared: pytest.Pytester) -> None:
    change(compared.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 0.6")
    result = compared.runpytest_inprocess("-vv", SUITE, "--hri-known=MODEL", "--hri-known=R2", "--hri-shrink")
    assert result.ret == 0
    result.stdout.fnmatch_lines(
        ["  MODEL * known *", "MODEL of rl-* shrunk from * for expected switch & observed nothing *"]
    )


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"switch"', '"swich"', "ActionMapping('swich'): guide has no action or message swich; nearest: switch"),
        ('"on(wish)"', '"on(whish)"', "PerceptMapping('asked'), column 4: unknown topic 'whish'; nearest: wish"),
        ("(0.2, 0.4)", "(0.4, 0.2)", "conftest.py:*ActionMapping('switch'): within_s is (0.4, 0.2); expected *"),
        ('"guide",\n', '"gide",\n', "ModelOracle: no agent 'gide' in *lamps.mas2j; nearest: guide"),
    ],
)
def test_a_wrong_declaration_is_refused_before_any_test_runs(
    compared: pytest.Pytester, old: str, new: str, told: str
) -> None:
    change(compared.path, "conftest.py", old, new)
    result = compared.runpytest_inprocess(SUITE)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: *{told}".replace("[", "[[]")])
    assert "Traceback" not in result.stderr.str()
