"""Evidence: rows, files for other tools, and what `verify` finds."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.evidence import outputs
from pytest_hricdv.extra.evidence.folder import verify_evidence, write_evidence
from pytest_hricdv.extra.evidence.requirement_lists import ListedRequirement, read_requirements
from pytest_hricdv.extra.evidence.rows import EvidenceRow, gather_evidence, names
from pytest_hricdv.report.files import write
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report
from tests.report import sample, sample_sections
from tests.report.sample_tests import requirement_results

CHECKED = {"R1", "R2", "R3", "R4"}


def made(*tests: dict[str, Any], **changes: Any) -> Report:
    """A report whose tests have these verdicts."""
    data = sample.data(tests=len(tests))
    for test, verdicts in zip(data["tests"], tests, strict=True):
        violates = any(result["verdict"] == "Failed" for result in verdicts.values())
        test |= {"requirements": verdicts, "outcome": "failed" if violates else "passed"}
    for name, tally in data["suites"][0]["requirements"].items():
        outcomes = [verdicts[name]["verdict"] for verdicts in tests]
        tally |= {"passed": outcomes.count("Passed"), "failed": outcomes.count("Failed"), "nc": outcomes.count("NC")}
    return sample.typed({**data, "gates": {"failed": [], "improved": []}, **changes})


def rows(report: Report, *listed: ListedRequirement) -> dict[str, EvidenceRow]:
    return {row.id: row for row in gather_evidence(report, listed)}


def test_each_requirement_has_a_status_with_its_waiver() -> None:
    report = made(
        requirement_results("R3", "R2", unchecked=("R4",)),
        requirement_results("R3", unchecked=("R4",)),
        known_until={"R3": "2027-01-20"},
        allowed_untriggered={"R4": {"reason": "needs a fast arm"}},
    )
    found = rows(report)
    assert {name: found[name].status for name in sorted(CHECKED)} == {
        "R1": "satisfied",
        "R2": "violated",
        "R3": "known violation",
        "R4": "not checked",
    }
    assert (found["R3"].waiver, found["R3"].until) == ("no crush prevention", "2027-01-20")
    assert found["R4"].waiver == "needs a fast arm"
    assert [(check.verdict, check.seed) for check in found["R2"].checks] == [
        ("Failed", report.tests[0].seed),
        ("Passed", report.tests[1].seed),
    ]
    assert (found["R4"].checks, found["R4"].not_checked) == ((), 2)


def test_a_waiver_has_its_owner() -> None:
    report = made(requirement_results("R3"), known_violations={"R3": "no crush prevention [safety team]"})
    assert (rows(report)["R3"].waiver, rows(report)["R3"].owner) == ("no crush prevention", "safety team")
    assert rows(report)["R1"].owner == ""


def test_conditions_are_those_of_a_closing_loop_and_otherwise_not_measured(tmp_path: Path) -> None:
    points = [("gpl_ready", "true"), ("gpl_ready", "false")]
    hit, left = ({"point": ["condition", "R1", *point]} for point in points)
    loop = {"hit": [{**hit, "test": "t", "strategy": "model", "run": 1}], "open": [{**left, "tries": 3}]}
    looped = made(requirement_results(), closing={**sample_sections.CLOSING, **loop})
    assert (rows(looped)["R1"].conditions, rows(looped)["R1"].open_conditions) == ((2, 1), ("gpl_ready: false",))
    for name, report, says in (("loop", looped, "1 of 2"), ("plain", made(requirement_results()), "not measured")):
        write(report, tmp_path / name)
        write_evidence(tmp_path / name, tmp_path / f"evidence of {name}")
        page, table = (
            (tmp_path / f"evidence of {name}" / file).read_text() for file in ("index.html", "requirements.csv")
        )
        assert says in page
        assert says in table.splitlines()[1]


def test_a_known_violation_is_none_where_waivers_are_ignored_or_do_not_hold() -> None:
    verdicts = requirement_results("R3")
    assert rows(made(verdicts, strict=True))["R3"].status == "violated"
    verdicts["R3"]["violations"][0]["outside"] = True
    assert rows(made(verdicts, known_when={"R3": "moving"}))["R3"].status == "violated"


def test_a_listed_requirement_is_as_good_as_the_worst_that_names_it() -> None:
    report = made(requirement_results("R2"))
    report = sample.typed(_with_sources(report, R1="SR-1, ISO 10218-2", R2="SR-1", R4="SR-12"))
    listed = [ListedRequirement(id=name, title=f"Title of {name}") for name in ("SR-1", "SR-2", "R4")]
    found = rows(report, *listed)
    assert list(found)[:3] == ["SR-1", "SR-2", "R4"]
    assert (found["SR-1"].status, found["SR-1"].checked_by) == ("violated", ("R1", "R2"))
    assert (found["SR-2"].status, found["SR-2"].title) == ("no evidence", "Title of SR-2")
    assert (found["R4"].status, found["R4"].checked_by) == ("satisfied", ("R4",))


def _with_sources(report: Report, **sources: str) -> dict[str, Any]:
    data: dict[str, Any] = msgspec.to_builtins(report)
    for name, source in sources.items():
        data["requirements"][name]["source"] = source
    return data


def test_a_list_hides_no_open_requirement() -> None:
    """One that is listed itself still checks others; of two that nothing triggered, the one without a waiver counts."""
    report = made(requirement_results(unchecked=("R1", "R4")), allowed_untriggered={"R1": {"reason": "rare"}})
    report = sample.typed(_with_sources(report, R1="SR-1", R4="SR-1", R2="SR-2"))
    found = rows(report, *(ListedRequirement(id=name) for name in ("R2", "SR-2", "SR-1")))
    assert (found["SR-2"].status, found["SR-1"].is_open) == ("satisfied", True)


def test_a_session_that_failed_otherwise_is_no_evidence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = made(requirement_results(), problems=("the audit was not done",))
    assert "the audit was not done" in outputs.facts_of(report).problems
    write(report, tmp_path / "report")
    assert main(["evidence", str(tmp_path / "report"), "-o", str(tmp_path / "evidence")]) == 1
    assert "problem: the audit was not done" in capsys.readouterr().out
    statement = json.loads((tmp_path / "evidence" / outputs.STATEMENT).read_text(encoding="utf-8"))
    assert statement["predicate"]["result"] == "FAILED"


@given(st.from_regex(r"[A-Z]{1,3}-[0-9]{1,3}", fullmatch=True), st.from_regex(r"[0-9A-Za-z]", fullmatch=True))
def test_an_id_is_found_as_a_word_only(name: str, letter: str) -> None:
    assert names(f"as of {name}.", name)
    assert names(f"{name}{letter}, {name}", name)
    assert not any(names(text, name) for text in (f"{name}{letter}", f"{letter}{name}", f"{name}.1", f"A-{name}"))


# Files


HOSTILE = '=1+1 <b>&amp; "x", \x07 größe\n</table>'


def test_every_file_says_the_same_to_the_tools_that_read_it(tmp_path: Path) -> None:
    """ReqIF is read back by the library `reqif`; all ids come back."""
    data = _with_sources(made(requirement_results("R2", unchecked=("R4",))), R1=HOSTILE)
    data["requirements"]["R1"]["title"] = HOSTILE
    write(sample.typed(data), tmp_path / "report")
    found = {row.id: row for row in write_evidence(tmp_path / "report", tmp_path / "evidence")[0]}
    folder = tmp_path / "evidence"
    with (folder / "requirements.csv").open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert [(line["id"], line["status"]) for line in lines] == [(row.id, row.status) for row in found.values()]
    assert lines[0]["title"].startswith("'=1+1")
    pytest.importorskip("reqif")
    for name in ("requirements.reqif", "needs.json", "requirements.csv"):
        assert [entry.id for entry in read_requirements(folder / name)] == list(found), name
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "<b>" not in page
    assert "no crush prevention" not in page  # R3 was not violated


def test_the_statement_names_each_file_and_each_requirement(tmp_path: Path) -> None:
    write(made(requirement_results("R3", unchecked=("R4",))), tmp_path / "report")
    write_evidence(tmp_path / "report", tmp_path / "evidence")
    statement = json.loads((tmp_path / "evidence" / outputs.STATEMENT).read_text(encoding="utf-8"))
    files = {path.name for path in (tmp_path / "evidence").iterdir()} - {outputs.STATEMENT}
    assert {subject["name"] for subject in statement["subject"]} == files
    predicate = statement["predicate"]
    assert (predicate["result"], predicate["warnedTests"], predicate["failedTests"]) == ("FAILED", ["R3"], ["R4"])
    attestation = pytest.importorskip("in_toto_attestation.v1.statement")
    json_format = pytest.importorskip("google.protobuf.json_format")
    attestation.Statement.copy_from_pb(json_format.ParseDict(statement, attestation.spb.Statement())).validate()


def change_a_byte(folder: Path) -> None:
    page = folder / "index.html"
    page.write_bytes(page.read_bytes().replace(b"Evidence", b"evidence", 1))


def remove_a_row(folder: Path) -> None:
    """From a table, and from the hash of it: only the report still has it."""
    table = folder / "requirements.csv"
    table.write_text("".join(table.read_text(encoding="utf-8").splitlines(keepends=True)[:-1]), encoding="utf-8")
    statement = json.loads((folder / outputs.STATEMENT).read_text(encoding="utf-8"))
    for subject in statement["subject"]:
        if subject["name"] == table.name:
            subject["digest"]["sha256"] = outputs.sha256(table.read_bytes())
    (folder / outputs.STATEMENT).write_text(json.dumps(statement), encoding="utf-8")


def remove_a_file(folder: Path) -> None:
    (folder / "checks.csv").unlink()


def add_a_file(folder: Path) -> None:
    (folder / "extra.csv").write_text("", encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (change_a_byte, "index.html: was changed"),
        (remove_a_row, "requirements.csv: contradicts report.json"),
        (remove_a_file, "checks.csv: is missing"),
        (add_a_file, "extra.csv: is not in statement.json"),
    ],
)
def test_verify_finds_what_was_changed(
    change: Callable[[Path], None], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(made(requirement_results()), tmp_path / "report")
    assert main(["evidence", str(tmp_path / "report"), "-o", str(tmp_path / "evidence")]) == 0
    assert main(["evidence", "verify", str(tmp_path / "evidence"), "--rerun=0"]) == 0
    change(tmp_path / "evidence")
    capsys.readouterr()
    assert main(["evidence", "verify", str(tmp_path / "evidence"), "--rerun=0"]) == 1
    assert f"FAILED {says}" in capsys.readouterr().out


# Lists of other tools


def test_an_export_of_strictdoc_keeps_its_ids_and_is_no_list_of_headings(tmp_path: Path) -> None:
    """And what is written from it is ReqIF by the schema of the library."""
    pytest.importorskip("reqif")
    listed = read_requirements(Path(__file__).with_name("strictdoc.reqif"))
    assert [(entry.id, entry.title) for entry in listed] == [
        ("SR-1", "Stop for a person"),
        ("SR-2", "Release only into a hand"),
        ("REQUIREMENT-c0cfe499-0d66-4687-9186-772a39f8b04d", "No id"),
    ]
    assert listed[0].text == 'The arm shall stop within 0.5 s when a person is near & stays < 0.3 m "near".'
    report = made(requirement_results())
    file = tmp_path / "requirements.reqif"
    file.write_text(outputs.reqif(gather_evidence(report, listed), outputs.facts_of(report)), encoding="utf-8")
    assert [entry.id for entry in read_requirements(file)][:3] == [entry.id for entry in listed]
    assert "complete with 0 errors, 0 schema issues found, 0 semantic issues found." in validate(file).stdout


def validate(file: Path) -> subprocess.CompletedProcess[str]:
    """What the library says of a file."""
    command = [sys.executable, "-m", "reqif.cli.main", "validate", "--use-reqif-schema", str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def archive(folder: Path, files: dict[str, str]) -> Path:
    with ZipFile(folder / "list.reqifz", "w") as made_archive:
        for name, text in files.items():
            made_archive.writestr(name, text)
    return folder / "list.reqifz"


def test_an_archive_of_reqif_is_all_of_its_files(tmp_path: Path) -> None:
    pytest.importorskip("reqif")
    text = Path(__file__).with_name("strictdoc.reqif").read_text(encoding="utf-8")
    other = text.replace("SR-1", "SR-7").replace("SR-2", "SR-8").replace("c0cfe499", "d1")
    found = read_requirements(archive(tmp_path, {"b/other.reqif": other, "a.reqif": text, "picture.png": "x"}))
    assert [entry.id[:4] for entry in found] == ["SR-1", "SR-2", "REQU", "SR-7", "SR-8", "REQU"]
    with pytest.raises(ReportError, match="has no file"):
        read_requirements(archive(tmp_path, {"picture.png": "x"}))
    (tmp_path / "list.reqifz").write_bytes(b"PK")
    with pytest.raises(ReportError, match="not an archive of ReqIF"):
        read_requirements(tmp_path / "list.reqifz")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (r"(?s).*", "", "not ReqIF: Document is empty"),
        ("SPEC-OBJECTS>", "OBJECTS>", "has 5 SPEC-OBJECT, 0 of them where ReqIF allows them"),
    ],
    ids=["empty", "requirements where the schema has none"],
)
def test_a_refused_file_is_invalid_for_the_library_too(old: str, new: str, says: str, tmp_path: Path) -> None:
    """Each is like one of the two sample files of the library that are not imported."""
    pytest.importorskip("reqif")
    text = Path(__file__).with_name("strictdoc.reqif").read_text(encoding="utf-8")
    (tmp_path / "a.reqif").write_text(re.sub(old, new, text), encoding="utf-8")
    with pytest.raises(ReportError, match=says):
        read_requirements(tmp_path / "a.reqif")
    done = validate(tmp_path / "a.reqif")
    assert done.returncode == 1
    assert "0 schema issues" not in done.stdout


@pytest.mark.slow
def test_sphinx_needs_imports_all_ids(tmp_path: Path) -> None:
    pytest.importorskip("sphinx_needs")
    report = made(requirement_results("R3", unchecked=("R4",)))
    (tmp_path / "in.json").write_text(outputs.needs_json(gather_evidence(report), outputs.facts_of(report)))
    (tmp_path / "conf.py").write_text('extensions = ["sphinx_needs"]\n')
    (tmp_path / "index.rst").write_text("Evidence\n========\n\n.. needimport:: in.json\n")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "needs", str(tmp_path), str(tmp_path / "out")]
    subprocess.run(command, check=True, capture_output=True)
    found = read_requirements(tmp_path / "out" / "needs.json")
    assert {entry.id for entry in found} == CHECKED


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.csv", "name,title\nx,y\n", ":1: no column `id`; found name, title"),
        ("a.csv", 'id\n"x', "not CSV"),
        ("a.csv", "id\nx\nx\n", "two requirements have the id 'x'"),
        ("a.csv", "id,title\n,y\n", "a requirement has no id"),
        ("a.json", "{}", "current_version"),
        ("a.json", '{"current_version": [], "versions": {}}', "current_version"),
        ("a.json", '{"current_version": "2", "versions": {}}', "no version '2'"),
        ("a.json", "{", "not JSON"),
        ("a.reqif", '<!DOCTYPE x [<!ENTITY a "b">]><REQ-IF/>', "has a document type"),
        ("a.reqif", "<a>", "not ReqIF"),
        ("a.doc", "", "expected .csv, .json, .reqif, .reqifz"),
    ],
)
def test_a_list_that_is_none_gets_a_located_sentence(name: str, text: str, says: str, tmp_path: Path) -> None:
    if name.endswith(".reqif") and "not ReqIF" in says:
        pytest.importorskip("reqif")
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(ReportError, match=says) as error:
        read_requirements(tmp_path / name)
    assert str(error.value).startswith(str(tmp_path / name))


# Against a project


@pytest.mark.slow
def test_verify_runs_tests_again_and_finds_a_changed_controller(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand", "-p", "no:xdist", "--hri-audit=off")
    assert main(["evidence", "hri-report", "-o", "evidence"]) in (0, 1)
    assert list(verify_evidence(Path("evidence"), lamps.path, 2)) == []
    code = next(path for path in lamps.path.glob("lamps/*.py") if path.name != "__init__.py")
    shutil.copyfile(code, "before.txt")
    code.write_text(code.read_text(encoding="utf-8") + "\nCHANGED = True\n", encoding="utf-8")
    problems = list(verify_evidence(Path("evidence"), lamps.path, 2))
    assert problems[0] == "the code under test is not that of the evidence: its SHA-256 differs"
