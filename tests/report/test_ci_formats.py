"""The markdown for a job's summary, GitHub's annotations, and JUnit properties."""

from __future__ import annotations

import random
import re
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from pytest_hricdv.coverage.records import CodeShare
from pytest_hricdv.report import markdown as markdown_module
from pytest_hricdv.report.annotations import Place, annotation_commands
from pytest_hricdv.report.junit import junit_properties
from tests.report import sample, sample_tests


def _failing(*names: str) -> dict[str, Any]:
    """A report whose first test failed these requirements, and no other failed any."""
    report = sample.data(tests=3)
    for number, test in enumerate(report["tests"]):
        failed = names if number == 0 else ()
        test["requirements"] = sample_tests.requirement_results(*failed, margin=1.0)
        test["outcome"] = "failed" if failed else "passed"
    return report


def markdown(data: dict[str, Any]) -> str:
    return markdown_module.markdown(sample.typed(data))


def annotation_lines(data: dict[str, Any], places: dict[str, Place]) -> tuple[str, ...]:
    return annotation_commands(sample.typed(data), places)


def test_it_has_verdicts_coverage_and_what_failed() -> None:
    text = markdown(_failing("R1"))
    assert text.startswith("## Human-robot interaction: table-assembly, failed\n")
    assert "Tests: 2 passed, 1 failed. 3/3 tests reported." in text
    assert "| R3 The robot shall not close its hand when the human hand is too close |" in text
    assert re.search(r"^\| statements, of the reachable \| \d+\.\d % of 320 \|$", text, re.M)
    assert "### 1 failure" in text
    assert "- R1 triggered at 41.2 s, violated at 51.5 s: hand\\_distance = 0.03 (margin -0.02 s)" in text
    assert "```text\nrun it again:\n  pytest " in text


def test_a_green_run_says_so_and_a_failed_gate_fails_it() -> None:
    report = _failing()
    assert markdown(report).startswith("## Human-robot interaction: table-assembly, passed\n")
    report["gates"] = {"failed": ["suite rl: statements 80 %, at least 90 % asked for"], "improved": ["R1 is better"]}
    text = markdown(report)
    assert text.startswith("## Human-robot interaction: table-assembly, failed\n")
    assert "**FAILED** suite rl: statements 80 %" in text
    assert "Better: R1 is better" in text


ODD = st.text(alphabet=st.sampled_from('|`<>&*_[]()#"\n\r\t\\%:,;a1\x1b é\u202e'), min_size=1, max_size=12)


@given(ODD, ODD)
def test_odd_names_break_no_table_and_no_fence(name: str, title: str) -> None:
    report = _failing("R1")
    report["tests"][0]["nodeid"] = name
    report["tests"][0]["errors"] = [name]
    report["requirements"]["R1"]["title"] = title
    lines = markdown(report).split("\n")
    rows = [line for line in lines if line.startswith("| R")]
    assert len(rows) == 4
    assert all(len(re.findall(r"(?<!\\)(?:\\\\)*\|", row)) == 7 for row in rows)
    assert not any("<" in re.sub(r"</?(details|summary|b)>", "", line) for line in lines if "pytest" not in line)
    fences = [number for number, line in enumerate(lines) if re.fullmatch(r"`{3,}(text)?", line)]
    assert [lines[number + 1] for number in fences[::2]] == ["run it again:"]
    assert len(fences) == 2


def test_texts_of_megabytes_are_cut_in_all_formats() -> None:
    report, text = _failing("R1"), "begin `<" + "é|" * 300_000 + " end"
    for number, test in enumerate(report["tests"]):
        test |= {"outcome": "error" if number else "failed", "failure": text, "errors": [text] * 5}
    for requirement in report["requirements"].values():
        requirement["title"] = text
    assert len(markdown(report).encode()) < 1_000_000
    assert sum(map(len, annotation_lines(report, {}))) < 1_000_000
    properties = junit_properties(sample.typed(report).tests[0], text)
    assert sum(len(name) + len(value) for name, value in properties) < 100_000


def test_an_annotation_for_each_requirement_with_the_worst_test() -> None:
    report = _failing("R1", "R2")
    report["tests"][1]["requirements"]["R1"] = sample_tests.requirement_result("Failed", 0.0) | {"margin": -5.0}
    report["tests"][1]["outcome"] = "failed"
    places = {test["nodeid"]: ("tests/hri/test_table_assembly.py", 8) for test in report["tests"]}
    first, second = annotation_lines(report, places)
    assert first.startswith(
        "::error file=tests/hri/test_table_assembly.py,line=8,title=hri%3A R1 failed in 2 tests::If gaze, pressure"
    )
    assert f"%0Aworst is {report['tests'][1]['id']}%0A" in first
    assert "hri%3A R2 failed in 1 test::" in second


def test_faults_are_in_the_summary_the_annotations_and_the_properties() -> None:
    report = _failing()
    report["tests"][0] |= {"outcome": "failed", "errors": ["the run ended at its time limit of 60 s"]}
    (line,) = annotation_lines(report, {})
    assert "1 test with a fault::first is" in line
    assert "%0Athe run ended at its time limit of 60 s%0A" in line
    text = markdown(report)
    assert "</b>: fault</summary>" in text
    assert "- the run ended at its time limit of 60 s\n" in text
    test = sample.typed(report).tests[0]
    assert ("hri.fault", "the run ended at its time limit of 60 s") in junit_properties(test, "legs")


CAUSES: list[dict[str, Any]] = [
    {
        "id": "3f2a91bc",
        "requirements": ["R1"],
        "tests": [],
        "state": "release_all",
        "minimal": ["tell leg", "receivesignal"],
        "locations": [
            {
                "file": "controller/states.py",
                "line": 58,
                "function": "discard",
                "score": 0.9,
                "likely": True,
                "text": "*y*",
            }
        ],
        "deciding_change": "passes when she steps in 2.1 s later",
    },
    {"id": "00000002", "requirements": ["R3"], "tests": [], "is_known": True},
]


def test_each_cause_is_annotated_once_at_its_place_in_the_code() -> None:
    report = _failing("R1", "R2")
    ids = [test["id"] for test in report["tests"]]
    report["causes"] = [CAUSES[0] | {"tests": ids[:1]}, CAUSES[1] | {"tests": ids[1:2]}]
    places = {test["nodeid"]: ("tests/hri/test_table_assembly.py", 8) for test in report["tests"]}
    (line,) = annotation_commands(sample.typed(report), places, lambda file: f"robot/{file}")
    title = "hri%3A cause 1 (3f2a91bc)%3A R1 in 1 test%2C first in the state release_all"
    assert line.startswith(f"::error file=robot/controller/states.py,line=58,title={title}::")
    assert "%0Awhy    passes when she steps in 2.1 s later%0A" in line
    report["causes"][0]["locations"] = []
    assert "file=tests/hri/test_table_assembly.py,line=8" in annotation_lines(report, places)[0]


def test_the_summary_has_causes_before_requirements() -> None:
    report = _failing("R1")
    for test in report["tests"]:
        test["outcome"] = "failed"
    report["causes"] = [CAUSES[0] | {"tests": [test["id"] for test in report["tests"]]}]
    text = markdown(report)
    assert text.index("### 3 tests fail for 1 cause") < text.index("### Suite rl")
    assert "**cause 1 (3f2a91bc): R1 in 3 tests, first in the state release\\_all**" in text
    assert "```text\n  where  controller/states.py:58 in discard (0.90): *y*\n" in text
    assert "<details><summary>3 tests</summary>" in text


@given(ODD, ODD)
def test_an_annotation_is_one_line_whatever_the_names(name: str, title: str) -> None:
    report = _failing("R1")
    report["tests"][0]["nodeid"] = name
    report["requirements"]["R1"]["title"] = title
    (line,) = annotation_lines(report, {report["tests"][0]["nodeid"]: (f"tests/{name}.py", 3)})
    assert line.isprintable()
    file = line[len("::error file=") : line.index(",line=3")]
    assert ":" not in file
    assert "," not in file


def test_junit_properties_are_text_and_leave_out_what_is_not_known() -> None:
    test = sample_tests.result(random.Random(0))
    code = CodeShare(statements=250, percent=77.4, bits=("0x0", None))
    test = replace(test, sim_s=131.25, code=code, outcomes=("released", "discarded"))
    properties = dict(junit_properties(test, "legs"))
    assert properties["hri.suite"] == "rl"
    assert properties["hri.id"] == test.id
    assert properties["hri.seed"] == str(test.seed)
    assert properties["hri.R4"] == "Passed"
    assert properties["hri.statements_percent"] == "77.4"
    assert properties["hri.legs"] == "released discarded"
    assert "hri.outcome" not in properties  # not known while the test runs
    unmeasured = dict(junit_properties(replace(test, code=None, record_sha256=None), "handovers"))
    assert properties.keys() - unmeasured.keys() == {"hri.statements_percent", "hri.record_sha256", "hri.legs"}
    assert unmeasured["hri.handovers"] == "released discarded"
