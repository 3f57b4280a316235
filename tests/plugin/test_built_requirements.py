"""Requirements that were built in Python, handed to a testbench in place of a file."""

from __future__ import annotations

import pytest

from tests.plugin.project import change, report

BUILT = """(
            requirement("R1", "Fulfilled", always(on("wish") >> eventually(on("switched"), 0, 1))),
            requirement("R3", "Never dark", always(on("greeting") >> (signal("lamp_level") >= 0))),
        )"""
IMPORTS = "    from pytest_hricdv.monitor.build import always, eventually, on, requirement, signal\n"


@pytest.fixture
def built(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project without its file of requirements."""
    change(lamps.path, "conftest.py", 'HERE / "requirements.toml"', BUILT)
    change(lamps.path, "conftest.py", "    pause = {", f"{IMPORTS}\n    pause = {{")
    (lamps.path / "requirements.toml").unlink()
    return lamps


def test_they_are_judged_and_reported_like_texts(built: pytest.Pytester) -> None:
    assert built.runpytest_inprocess("--hri-suite=by-hand", "-o", "hri_known_violations=").ret == 0
    written = report(built.path)
    assert written["requirements"]["R1"]["text"] == "always(on(wish) -> eventually[0:1](on(switched)))"
    assert written["suites"][0]["requirements"]["R3"]["passed"] > 0
    misses = [test["requirements"]["R3"]["near_miss"] for test in written["tests"]]
    assert {"time_s": 0.0, "missing": ["on(greeting)"], "distance": None} in misses


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('signal("lamp_level")', 'signal("lamp_levl")', "R3, column 24: unknown name 'lamp_levl'; nearest: lamp_level"),
        ('requirement("R1", ', '("R1", ', "('R1', 'Fulfilled', *is none; expected the path of a TOML file"),
    ],
)
def test_what_is_no_requirement_is_refused(built: pytest.Pytester, old: str, new: str, told: str) -> None:
    change(built.path, "conftest.py", old, new)
    result = built.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*requirement {told}*"])
