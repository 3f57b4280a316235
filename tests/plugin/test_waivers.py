"""The list of waivers: what is waived, why, and whether it is still needed."""

from __future__ import annotations

import pytest

from pytest_hricdv.report.waivers_view import list_waivers
from pytest_hricdv.results.codec import load
from tests.plugin.project import change

SUITE = ("--hri-suite=by-hand", "-p", "no:xdist")


def found(lamps: pytest.Pytester, *options: str) -> dict[str, tuple[str, str, str]]:
    """What is waived -> kind, until, state."""
    lamps.runpytest_inprocess(*SUITE, *options)
    rows = list_waivers(load(lamps.path / "hri-report"))
    assert all(row.reason or row.state == "expired" for row in rows)
    return {row.subject: (row.kind, row.until, row.state) for row in rows}


def test_each_waiver_says_whether_it_is_needed(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", 'return "by hand"', 'return "by hand"  # unreachable: nobody services it here')
    with (lamps.path / "pytest.ini").open("a", encoding="utf-8") as file:
        file.write(
            "hri_allow_nc =\n    R1 in rl until 2999-12-31: not there\n    R3: nobody greets [lamp team]\n"
            "    R2 in by-hand: it has no lamp\n"
        )
    rows = found(lamps)
    owners = {row.subject: (row.reason, row.owner) for row in list_waivers(load(lamps.path / "hri-report"))}
    assert owners["R3"] == ("nobody greets", "lamp team")
    assert owners["R1 in rl"] == ("not there", "")
    assert rows["R2"] == ("known violation", "", "needed")
    assert rows["R1 in rl"] == ("may be NC", "2999-12-31", "not seen in this part")
    assert rows["R3"] == ("may be NC", "", "not needed here")
    assert rows["lamps/guide.py:44"] == ("unreachable line", "", "needed")
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert "nobody services it here" in page
    assert "not needed here" in page


def test_waivers_of_another_testbench_do_not_count(lamps: pytest.Pytester) -> None:
    """The line runs here, so the waiver is wrong, unless the session is told that it is of another world."""
    source = (lamps.path / "lamps/guide.py").read_text("utf-8")
    line = next(line for line in source.splitlines() if line.strip().startswith("def "))
    change(lamps.path, "lamps/guide.py", line, f"{line}  # unreachable: elsewhere")
    lamps.runpytest_inprocess(*SUITE).stdout.fnmatch_lines(["*ran, though it is waived as unreachable (elsewhere)*"])
    told = lamps.runpytest_inprocess(*SUITE, "--hri-no-waivers")
    assert "though it is waived" not in told.stdout.str()
    assert load(lamps.path / "hri-report").code_under_test.waivers == ()


@pytest.mark.slow
def test_a_known_violation_that_does_not_occur_expires_or_is_ignored(lamps: pytest.Pytester) -> None:
    known = "--hri-known=R1"
    assert found(lamps, known)["R1"] == ("known violation", "", "not needed here")
    assert found(lamps, known, "-k", "cellar")["R1"] == ("known violation", "", "not seen in this part")
    assert found(lamps, known, "--hri-strict")["R1"] == ("known violation", "", "ignored: strict")
    ini = lamps.path / "pytest.ini"
    ini.write_text(ini.read_text("utf-8").replace("R2: the hall", "R2 until 2020-01-31: the hall"), "utf-8")
    assert found(lamps)["R2"] == ("known violation", "2020-01-31", "expired")
