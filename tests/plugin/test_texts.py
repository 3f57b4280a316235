"""Texts in a project: enumerations and strings of messages, and signals that are texts, in requirements and reports."""

from __future__ import annotations

import pytest

from tests.plugin.project import change, report

FORMULA = 'formula = "always(on(greeting) -> eventually[0:2](on(answer)))"'


@pytest.fixture
def toned(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project, whose guide answers in a tone, and whose lamp has a colour."""
    change(
        lamps.path,
        "lamps/messages.py",
        '    """The guide greets back."""',
        "    tone: Literal['warm', 'cold'] = 'cold'",
    )
    change(lamps.path, "lamps/messages.py", "import dataclass\n", "import dataclass\nfrom typing import Literal\n")
    change(
        lamps.path,
        "conftest.py",
        'Signal(float, "%")}',
        'Signal(float, "%"), "colour": Signal(str, values=("white", "red"))}',
    )
    switch = 'run.recorder.signal(run.kernel.now_s, "lamp_level", level)'
    change(lamps.path, "conftest.py", switch, f"{switch}; {switch.replace('lamp_level', 'colour')}")
    change(lamps.path, "conftest.py", '"colour", level', '"colour", "white" if level else "red"')
    return lamps


@pytest.mark.slow
def test_a_requirement_compares_them(toned: pytest.Pytester) -> None:
    compared = """formula = 'always(on(answer) -> answer == "warm" | colour == "red")'"""
    change(toned.path, "requirements.toml", FORMULA, compared)
    toned.runpytest_inprocess("--hri-suite=by-hand")
    results = [test["requirements"]["R3"] for test in report(toned.path)["tests"]]
    found = [violation["values"] for result in results for violation in result["violations"]]
    assert {"answer.tone": "cold", "colour": "white"} in found
    assert {"white", "red"} >= {text for _, text in report(toned.path)["tests"][0]["timeline"]["texts"]["colour"]}


@pytest.mark.parametrize(
    ("formula", "told"),
    [
        ("""'always(on(answer) -> answer == "hot")'""", "*answer.tone is never 'hot'; known: warm, cold*"),
        ("""'always(on(answer) -> colour == "rde")'""", "*colour is never 'rde'; nearest: red*"),
    ],
)
def test_a_value_that_they_never_have_is_refused(toned: pytest.Pytester, formula: str, told: str) -> None:
    change(toned.path, "requirements.toml", FORMULA, f"formula = {formula}")
    result = toned.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([told])
