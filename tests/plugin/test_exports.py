"""Files for other tools: Cobertura, LCOV, markdown, JUnit's properties; and what GitHub gets."""

from __future__ import annotations

import os
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from ucis.cover_type_t import CoverTypeT
from ucis.history_node_kind import HistoryNodeKind
from ucis.scope_type_t import ScopeTypeT
from ucis.xml import validate_ucis_xml
from ucis.xml.xml_reader import XmlReader

from tests.plugin.project import A_WORKER, change, counted_up_to_313, report
from tests.report.dtd import faults

SUITE = "--hri-suite=by-hand"


def lines(path: Path) -> dict[str, dict[int, tuple[bool, str | None]]]:
    """Per file of a Cobertura XML: line -> is it hit, and the coverage of its conditions."""
    root = ET.parse(path).getroot()
    source = root.findtext("sources/source") or ""
    return {
        os.path.join(source, each.attrib["filename"]): {
            int(line.attrib["number"]): (int(line.attrib["hits"]) > 0, line.get("condition-coverage"))
            for line in each.iter("line")
        }
        for each in root.iter("class")
    }


@pytest.mark.slow
def test_cobertura_says_what_coverage_itself_says(lamps: pytest.Pytester) -> None:
    own = ("--cov=lamps", "--cov-branch", "--cov-report=xml:own.xml")
    result = lamps.runpytest_subprocess(SUITE, "--hri-tests=2", "--hri-cobertura=out/ours.xml", *own)
    assert result.ret == 0
    ours, theirs = lines(lamps.path / "out" / "ours.xml"), lines(lamps.path / "own.xml")
    # Coverage names files relative to the package, and we to the project: with their source folder they are the same.
    assert (
        ours.keys()
        == theirs.keys()
        == {str(lamps.path / "lamps" / f"{n}.py") for n in ("__init__", "guide", "messages")}
    )
    assert ours == theirs
    assert faults(ET.parse(lamps.path / "out" / "ours.xml").getroot()) == []
    result.stdout.fnmatch_lines([f"cobertura: {lamps.path / 'out' / 'ours.xml'}"])


def test_the_ini_names_files_too_and_lcov_names_files_of_the_project(lamps: pytest.Pytester) -> None:
    change(lamps.path, "pytest.ini", "[pytest]", "[pytest]\nhri_lcov = lcov.info\nhri_summary = summary.md")
    lamps.runpytest_inprocess(SUITE)
    text = (lamps.path / "lcov.info").read_text()
    files = [line.removeprefix("SF:") for line in text.splitlines() if line.startswith("SF:")]
    assert files == ["lamps/__init__.py", "lamps/guide.py", "lamps/messages.py"]
    assert "LF:29\nLH:28\n" in text
    assert (lamps.path / "summary.md").read_text().startswith("## Human-robot interaction: lamps, passed\n")


@pytest.mark.slow
@counted_up_to_313
def test_junit_has_properties_of_each_test_and_of_the_whole(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(SUITE, "--junitxml=junit.xml", "--hri-fail-under=plans=99", *A_WORKER)
    suite = ET.parse(lamps.path / "junit.xml").getroot()[0]
    whole = {each.attrib["name"]: each.attrib["value"] for each in suite.findall("properties/property")}
    assert whole["hri.testbench"] == "lamps"
    assert (whole["hri.expected"], whole["hri.reported"]) == ("4", "4")
    assert whole["hri.by-hand.R2"] == "2 passed, 1 failed, 1 NC"
    assert whole["hri.by-hand.statements_percent"] == "97.6"
    assert whole["hri.failed_gate"] == "suite by-hand: plans 77.78 %, at least 99 % asked for"
    cases = {
        case.attrib["name"]: {each.attrib["name"]: each.attrib["value"] for each in case.iter("property")}
        for case in suite.iter("testcase")
    }
    for test in report(lamps.path)["tests"]:
        properties = cases[test["nodeid"].partition("::")[2]]
        assert properties["hri.record_sha256"] == test["record_sha256"]
        assert properties["hri.R1"] == test["requirements"]["R1"]["verdict"]
        assert "hri.outcome" not in properties


@pytest.mark.slow
def test_github_gets_annotations_and_one_more_summary(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(lamps.path / "job.md"))
    monkeypatch.setenv("GITHUB_WORKSPACE", str(lamps.path.parent))
    (lamps.path / "job.md").write_text("what an earlier step said\n")
    result = lamps.runpytest_inprocess(SUITE, "--hri-strict", "--hri-diagnose=0")
    file = f"{lamps.path.name}/test_lamps.py"
    result.stdout.fnmatch_lines([f"::error file={file},line=4,title=hri%3A R2 failed in 1 test::The lamp shall *"])
    text = (lamps.path / "job.md").read_text()
    assert text.startswith("what an earlier step said\n## Human-robot interaction: lamps, failed\n")
    lamps.runpytest_inprocess(SUITE, "--hri-tests=1")
    assert (lamps.path / "job.md").read_text().count("## Human-robot interaction") == 2


@pytest.mark.parametrize("name", ["cobertura", "lcov", "summary"])
def test_a_file_that_cannot_be_written_is_said_before_the_first_test(lamps: pytest.Pytester, name: str) -> None:
    (lamps.path / "file").write_text("")
    for value, message in (
        ("lamps", "expected the name of a file to write, and there is a folder"),
        ("", "expected the name of a file to write"),
        ("file/x", "a file is in the way"),
    ):
        result = lamps.runpytest_inprocess(SUITE, f"--hri-{name}={value}")
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        assert message in result.stdout.str() + result.stderr.str()


def test_a_job_summary_that_cannot_be_written_fails_the_run_and_keeps_the_report(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(lamps.path / "nowhere" / "job.md"))
    result = lamps.runpytest_inprocess(SUITE)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["FAILED GITHUB_STEP_SUMMARY=*job.md: No such file or directory"])
    assert report(lamps.path)["reported"] == 4


@pytest.mark.slow
def test_a_written_report_is_exported_as_its_session_did(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    lamps.runpytest_inprocess(SUITE, "--hri-cobertura=a.xml", "--hri-lcov=a.info", "--hri-summary=a.md")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(lamps.path / "job.md"))
    files = ("--cobertura=b.xml", "--lcov=b.info", "--summary=b.md", f"--root={lamps.path}")
    done = lamps.run(sys.executable, "-m", "pytest_hricdv.report", "export", "hri-report", *files)
    assert done.ret == 0
    for end in ("xml", "info", "md"):
        assert (lamps.path / f"a.{end}").read_text() == (lamps.path / f"b.{end}").read_text()
    assert (lamps.path / "job.md").read_text() == (lamps.path / "a.md").read_text() + "\n"
    monkeypatch.delenv("GITHUB_STEP_SUMMARY")
    nothing = lamps.run(sys.executable, "-m", "pytest_hricdv.report", "export", "hri-report")
    assert nothing.ret == 2
    nothing.stderr.fnmatch_lines(["error: export: say what to write, with --cobertura=FILE, *"])


def test_no_tests_and_a_name_of_every_odd_character(lamps: pytest.Pytester) -> None:
    files = ("--hri-cobertura=c.xml", "--hri-lcov=l.info", "--hri-summary=s.md", "--junitxml=j.xml")
    result = lamps.runpytest_inprocess(SUITE, "-k", "nothing_of_that_name", *files)
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert not (lamps.path / "s.md").exists()
    change(
        lamps.path,
        "test_lamps.py",
        "def test_lamps(hri_case):",
        "import pytest\n\n\n@pytest.mark.parametrize('odd', ['|<&\"`%\\n\\x1bé'])\ndef test_lamps(hri_case, odd):",
    )
    result = lamps.runpytest_inprocess(SUITE, "--hri-strict", *files)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    ET.parse(lamps.path / "c.xml")
    ET.parse(lamps.path / "j.xml")
    assert "4 tests" in (lamps.path / "s.md").read_text()


def test_ucis_is_valid_and_says_what_the_report_says(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess(SUITE, "--hri-ucis=out/all.xml", "-p", "no:xdist", "-p", "no:cacheprovider")
    result.stdout.fnmatch_lines(["ucis: *out/all.xml"])
    path, found = lamps.path / "out" / "all.xml", report(lamps.path)
    with path.open(encoding="utf-8") as file:
        assert validate_ucis_xml(file)
    with path.open(encoding="utf-8") as file:
        database = XmlReader().read(file)
    (suite,) = found["suites"]
    tests = {node.getLogicalName(): node for node in database.historyNodes(HistoryNodeKind.TEST)}
    assert tests.keys() == {test["id"] for test in found["tests"]}
    assert {node.getSimTime() for node in tests.values()} == {test["sim_s"] for test in found["tests"]}
    instances = {scope.getScopeName(): scope for scope in database.scopes(ScopeTypeT.INSTANCE)}
    assert instances.keys() == {"code under test", "by-hand"}
    (block,) = instances["code under test"].scopes(ScopeTypeT.BLOCK)
    counts = [item.getCoverData().data for item in block.coverItems(CoverTypeT.STMTBIN)]
    assert (sum(count > 0 for count in counts), len(counts)) == (
        suite["code"]["statements"]["covered"],
        suite["code"]["statements"]["total"],
    )
    for assertion in instances["by-hand"].scopes(ScopeTypeT.ASSERT):
        bins = {item.getName(): item.getCoverData().data for item in assertion.coverItems(CoverTypeT.ALL)}
        results = [test["requirements"][assertion.getScopeName()] for test in found["tests"]]
        assert bins["attemptBin"] == sum(each["triggers"] for each in results)
        assert bins["failBin"] == sum(each["failures"] for each in results)
    groups = {scope.getScopeName(): scope for scope in instances["by-hand"].scopes(ScopeTypeT.COVERGROUP)}
    assert groups.keys() == {"plans", "light"}
    points = {scope.getScopeName(): scope for scope in groups["plans"].scopes(ScopeTypeT.COVERPOINT)}
    plans = {item.getName(): item.getCoverData().data for item in points["visitor"].coverItems(CoverTypeT.CVGBIN)}
    assert sorted(name for name, count in plans.items() if count) == sorted(suite["plans"]["visitor"]["covered"])
    assert len(plans) == suite["plans"]["visitor"]["total"]
    (cross,) = groups["light"].scopes(ScopeTypeT.CROSS)
    hit = {item.getName() for item in cross.coverItems(CoverTypeT.CVGBIN) if item.getCoverData().data}
    assert (len(hit), "hall x 100" in hit) == (suite["cross"]["hit"], True)
