"""Names with control characters and text directions: every output stays what it should be."""

from __future__ import annotations

import io
import unicodedata
import xml.etree.ElementTree as ET
from contextlib import redirect_stderr, redirect_stdout

import pytest

from pytest_hricdv.bdi.__main__ import main as bdi
from tests.plugin.project import change, command, report

HOSTILE = "R2\x01\x1b[31m\u202e\ufffe"
SUITE = "--hri-suite=by-hand"


def odd(text: str) -> set[str]:
    """Characters that a terminal would act on, or that XML does not allow."""
    return {char for char in text if unicodedata.category(char) in ("Cc", "Cf", "Cn", "Cs") and char not in "\n\t"}


@pytest.fixture
def hostile(lamps: pytest.Pytester) -> pytest.Pytester:
    """The project with a requirement whose id is hostile."""
    written = HOSTILE.encode("unicode_escape").decode().replace("\\x", "\\u00")
    change(lamps.path, "requirements.toml", "[R2]", f'["{written}"]')
    change(lamps.path, "pytest.ini", "    R2: the hall has no dimmer\n", "")
    return lamps


@pytest.mark.slow
def test_junit_and_cobertura_are_well_formed_and_the_terminal_is_clean(hostile: pytest.Pytester) -> None:
    result = hostile.runpytest_inprocess(SUITE, "--junitxml=junit.xml", "--hri-cobertura=c.xml", "--color=no")
    assert HOSTILE in report(hostile.path)["requirements"]
    names = {each.attrib["name"] for each in ET.parse(hostile.path / "junit.xml").iter("property")}
    assert r"hri.R2\x01\x1b[31m\u202e\ufffe" in names
    ET.parse(hostile.path / "c.xml")
    assert odd(result.stdout.str() + result.stderr.str()) == set()


@pytest.mark.slow
def test_commands_on_reports_print_no_such_character(hostile: pytest.Pytester) -> None:
    hostile.runpytest_inprocess(SUITE)
    for arguments in (["gate", "hri-report"], ["merge", "hri-report"], ["minimal", "hri-report", "m"]):
        done = command(*arguments)
        assert odd(done.stdout + done.stderr) == set()


def test_what_agents_print_and_findings_have_no_such_character(pytester: pytest.Pytester) -> None:
    (pytester.path / "m.mas2j").write_text("MAS m { agents: a; }")
    sound = '!g. +!g <- .print("\x1b[31m\u202e\tx"). // lint: other \x1b'
    printed = io.StringIO()
    with redirect_stdout(printed), redirect_stderr(printed):
        for source, commands in (("!g. \x1b", {"run": 2}), (sound, {"run": 0, "trace": 0, "lint": 1})):
            (pytester.path / "a.asl").write_text(source)
            for name, status in commands.items():
                assert bdi([name, "m.mas2j"]) == status
    assert "[a] \\x1b[31m\\u202e\tx" in printed.getvalue()
    assert odd(printed.getvalue()) == set()
