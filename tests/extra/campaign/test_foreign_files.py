"""Campaigns that somebody else made: read within limits, written nowhere but into the report, or refused on a line."""

from __future__ import annotations

import os
import sqlite3
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from pytest_hricdv.extra.campaign.__main__ import main
from pytest_hricdv.extra.campaign.plan import CampaignBasis, CampaignPlan, PlannedTest
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.results.replay import Replay
from pytest_hricdv.session.remote import WorkerName
from tests.report import sample

Doctored = Callable[..., Path]


def abstract(result: TestResult) -> AbstractTest:
    """A test of one action, with the id of a result."""
    return AbstractTest(result.id, result.suite, "plans", (), ("tell leg",), seed=result.seed)


def replay(result: TestResult) -> str:
    """A replay file's text."""
    test = abstract(result)
    concrete = ConcreteTest(test.id, test.suite, test.seed, (), {})
    return Replay(
        test=AbstractTest(test.id, test.suite, "plans", (), (), seed=test.seed),
        concrete=concrete,
        nodeid=result.nodeid,
        suite_seed=0,
        record_sha256=None,
        requirements={},
        code={},
        environment={},
    ).to_json()


def plan(report: Report) -> CampaignPlan:
    """A campaign of the tests of a report, one seed each."""
    tests = tuple(PlannedTest(test.suite, test.nodeid, abstract(test).to_data()) for test in report.tests)
    declared = msgspec.Raw(encode(report).encode())
    return CampaignPlan(CampaignBasis(("--hri-suite=rl",), "/project", tests, {}, {}, declared), 1)


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A campaign of three runs, all done, which fail no gate but their own."""
    monkeypatch.chdir(tmp_path)
    report = sample.report(tests=3)
    store = Store.create(tmp_path / "a.db", plan(report))
    store.begin("2026-01-01T00:00:00+00:00", plan(report))
    for number, test in enumerate(report.tests):
        store.add((number, 0), test, replay(test), WorkerName("tcp://w", "host", {}))
    store.close()
    return tmp_path / "a.db"


def execute(path: Path, statement: str, *values: object) -> None:
    """Change a campaign's file, as somebody who has it can."""
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        connection.executescript(statement) if not values else connection.execute(statement, values)
    connection.close()


def said(capsys: Any, *arguments: str) -> tuple[int, str, str]:
    """Exit status, output and errors of a command."""
    status = main([*arguments, "--state=a.db"])
    return status, *capsys.readouterr()


def test_a_campaign_that_nobody_touched_is_reported(state: Path, capsys: Any) -> None:
    assert said(capsys, "status")[0] == 0
    status, output, errors = said(capsys, "report")
    assert (status, errors) == (1, ""), output
    assert len(list(Path("hri-report", "failures").glob("*.json"))) == 3


@pytest.mark.parametrize("name", ["../../victim/owned", "/tmp/owned", "a/b", "..", "a\x1b[31m", ""])
def test_no_id_writes_outside_of_the_report(state: Path, capsys: Any, name: str) -> None:
    (state.parent / "victim").mkdir()
    before = sorted(state.parent.rglob("*"))
    test = msgspec.structs.replace(sample.report(tests=3).tests[0], id=name)
    execute(state, "UPDATE results SET result = ? WHERE test = 0", zlib.compress(encode(test).encode()))
    status, _, errors = said(capsys, "report")
    assert status == 2
    assert "a.db: damaged, or not a campaign (Expected `str` matching regex" in errors
    assert [path for path in state.parent.rglob("*") if path.suffix == ".json"] == []
    assert [path for path in before if not path.exists()] == []


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ("UPDATE results SET result = (SELECT result FROM results WHERE test = 1) WHERE test = 0", "has the result of"),
        ("UPDATE results SET replay = (SELECT replay FROM results WHERE test = 1) WHERE test = 0", "of another test"),
        ("UPDATE results SET result = substr(result, 1, 99)", "it is truncated"),
        ("UPDATE results SET result = 7", "Expected `bytes`, got `int`"),
        ("UPDATE campaign SET value = 'a'", "Invalid base64"),
        ("UPDATE runs SET test = 99 WHERE test = 0", "1 rows of runs are of no test of its plan"),
        ("UPDATE results SET test = -1 WHERE test = 0", "1 rows of results are of no test of its plan"),
        ("UPDATE runs SET k = 'x' WHERE test = 0", "1 rows of runs are of no test of its plan"),
        ("UPDATE runs SET outcome = 'owned'", "Invalid enum value 'owned'"),
        ("UPDATE runs SET outcome = NULL", "Expected `str`, got `null`"),
        ("UPDATE runs SET summary = json_set(summary, '$.judgements', json('[]'))", "damaged, or not a campaign"),
        ("UPDATE runs SET summary = json_set(summary, '$.judgements', 1)", "Expected `array`, got `int`"),
        ("UPDATE runs SET summary = replace(printf('%.99999c', '['), ' ', '[')", "nested too deeply"),
        ("UPDATE runs SET summary = NULL", "Expected `str`, got `null`"),
        ("UPDATE runs SET summary = json_set(summary, '$.bins', 1)", "Expected `object`, got `int`"),
        ("UPDATE runs SET summary = json_set(summary, '$.statements', 'zz')", "Expected `str` matching regex"),
        ("UPDATE runs SET sim_s = -1", "Expected `float` >= 0.0"),
        ("UPDATE workers SET versions = '[1]'", "Expected `object`, got `array`"),
        ("UPDATE workers SET versions = NULL", "Expected `str`, got `null`"),
        ("UPDATE workers SET versions = 'x'", "damaged, or not a campaign (Expecting value"),
        ("INSERT INTO again VALUES (0, 5, 'x', 1, 'z')", "a run that is not there was repeated: (0, 5)"),
        ("INSERT INTO again VALUES (0, 0, 'x', 'y', 'z')", "Expected `int`, got `str`"),
        ("UPDATE campaign SET value = x'00' WHERE name = 'plan'", "cannot be unpacked"),
        ("DROP TABLE again", "its table again is missing"),
        ("DROP TABLE runs; CREATE VIEW runs AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT 1 FROM n) "
         "SELECT * FROM n", "its table runs is another one"),
        ("DROP TABLE campaign; CREATE VIEW campaign AS WITH RECURSIVE n(name) AS (SELECT 1 UNION ALL SELECT 1 FROM n) "
         "SELECT name, 1 AS value FROM n", "expected a campaign of schema"),
        ("CREATE TRIGGER t AFTER INSERT ON sessions BEGIN DELETE FROM runs; END", "there is a trigger in it"),
        ("CREATE VIEW v AS SELECT 1", "there is a view in it"),
    ],
)  # fmt: skip
def test_what_is_no_campaign_is_refused_on_a_line(state: Path, capsys: Any, change: str, reason: str) -> None:
    execute(state, change)
    outcomes = [said(capsys, command) for command in ("status", "report")]
    assert any(reason in errors for _, _, errors in outcomes), outcomes
    for status, _, errors in outcomes:
        assert errors == "" or (status == 2 and errors.count("\n") == 1), errors


@pytest.mark.slow
def test_little_that_unpacks_to_much_is_refused(state: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    bomb = zlib.compress(b" " * 300_000_000, 9)
    assert len(bomb) < 300_000
    for statement in ("UPDATE results SET result = ?", "UPDATE results SET replay = ?"):
        execute(state, statement, bomb)
        status, _, errors = said(capsys, "report")
        assert (status, "unpacks to too much; expected at most 200,000,000 bytes" in errors) == (2, True), errors


def test_nothing_that_a_campaign_holds_reaches_the_terminal_raw(state: Path, capsys: Any) -> None:
    evil = "\x1b]0;owned\x07\u202e"
    report = sample.report(tests=3)
    planned = msgspec.structs.replace(
        plan(report).planned, arguments=(f"--hri-suite={evil}", "--basetemp=/home/me", "$(rm -rf ~)")
    )
    text = zlib.compress(CampaignPlan(planned, 1).to_json())
    execute(state, "UPDATE campaign SET value = ? WHERE name = 'plan'", text)
    execute(state, "UPDATE workers SET address = ?", evil)
    execute(state, "UPDATE runs SET outcome = 'lost', summary = json_set(summary, '$.note', ?) WHERE test = 0", evil)
    execute(state, "INSERT INTO again VALUES (1, 0, 'x', 1, ?)", evil)
    for arguments in (("status",), ("report",)):
        status, output, errors = said(capsys, *arguments)
        assert status in (0, 1), errors
        assert "owned" in output
        assert [char for char in output if not char.isprintable() and char != "\n"] == []


@pytest.mark.parametrize("ending", ["-wal", "-shm", "-journal", ".lock"])
def test_no_link_beside_a_campaign_is_written_through(state: Path, capsys: Any, ending: str, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / f"a.db{ending}").symlink_to(victim)
    if ending == ".lock":
        with pytest.raises(Exception, match=r"a\.db: "):
            Store.open(state).hold()
    else:
        status, _, errors = said(capsys, "status")
        assert (status, "a symbolic link, which is not followed here" in errors) == (2, True)
    assert victim.read_text() == "precious"


def test_no_link_in_a_report_lets_a_campaign_delete_or_write_elsewhere(
    state: Path, capsys: Any, tmp_path: Path
) -> None:
    victim = tmp_path / "victim"
    victim.mkdir()
    (victim / "package.json").write_text("precious")
    (tmp_path / "hri-report").mkdir()
    os.symlink(victim, tmp_path / "hri-report" / "failures")
    status, _, errors = said(capsys, "report")
    assert status == 2
    assert "a symbolic link is in the way, which is not followed there: remove it" in errors
    assert [path.name for path in victim.iterdir()] == ["package.json"]
