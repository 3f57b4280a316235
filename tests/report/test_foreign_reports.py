"""Reports that somebody else made: what merging, rebuilding and gates make of links, names and files in them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest

from pytest_hricdv.report.__main__ import main
from pytest_hricdv.report.files import supersede, write
from pytest_hricdv.results.codec import ReportError, encode, load
from pytest_hricdv.results.journal import NAME, JournalWriter, ResultRecord, SelectionRecord, StartRecord, read
from tests.report import sample


def data() -> dict[str, Any]:
    """Of a report that can be merged: without waivers of what its tests are made up to have covered."""
    made = sample.data(tests=2)
    made["code_under_test"]["waivers"] = []
    return made


@pytest.fixture
def report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A report as an artefact brings it: a folder with its JSON alone."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "artefact"
    folder.mkdir()
    (folder / "report.json").write_text(json.dumps(data()), encoding="utf-8")
    return folder


@pytest.fixture
def victim(tmp_path: Path) -> Path:
    """A folder of the user, which holds something of worth."""
    folder = tmp_path / "victim"
    folder.mkdir()
    (folder / "secret.json").write_text("precious", encoding="utf-8")
    (folder / "main.js").write_text("precious", encoding="utf-8")
    return folder


def untouched(victim: Path) -> bool:
    return {path.name: path.read_text() for path in victim.iterdir()} == dict.fromkeys(
        ("secret.json", "main.js"), "precious"
    )


def change(folder: Path, **keys: object) -> None:
    """Change keys of the first test."""
    changed = data()
    changed["tests"][0] |= keys
    (folder / "report.json").write_text(json.dumps(changed), encoding="utf-8")


FILM = {"video": None, "strip": None, "seconds": None, "frames": 0, "note": ""}
ADDRESSES = [
    *("javascript:alert(1)", "data:text/html,x", "file:///etc/passwd", "http://e", "//e/a.mcap", "/a.mcap"),
    *("traces/../../a.mcap", "traces/a.html", "traces/a\n.mcap", "traces/%2e%2e/a.mcap", "traces\\a.mcap"),
]
VIDEOS = ["javascript:x", "films/a.svg", "films/a.html", "films/../a.gif"]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("id", name) for name in ("../../victim/x", "/etc/x", "a/b", "..", ".", "", "a\x1b", "a\n", "a b", "ä")),
        *(("trace", {"file": address}) for address in ADDRESSES),
        *(("trace", {"file": None, "bag": address}) for address in ADDRESSES[:3]),
        *(("film", FILM | {"video": name}) for name in VIDEOS),
        *(("film", FILM | {"strip": name}) for name in ("javascript:x", "films/a.svg", "http://e/a.png")),
        *(("replay", name) for name in ("javascript:alert(1)", "failures/a.json\nrm -rf", "failures/a.py")),
    ],
)  # fmt: skip
def test_a_name_or_address_that_leads_elsewhere_is_refused(report: Path, key: str, value: object) -> None:
    change(report, **{key: value})
    with pytest.raises(ReportError, match=rf"Expected `str.* matching regex .* - at `\$\.tests\[0\]\.{key}"):
        load(report)


@pytest.mark.parametrize(
    "option", ["--basetemp=/home/me", "-c/tmp/e.ini", "-pevil", "--hri-report=/x", "--hri-rl-save=x"]
)
def test_no_command_to_copy_has_an_option_that_writes(report: Path, option: str) -> None:
    changed = data()
    changed["rerun_options"]["options"] = [option]
    (report / "report.json").write_text(json.dumps(changed))
    with pytest.raises(ReportError, match=r"\$\.rerun_options\.options\[0\]"):
        load(report)


@pytest.mark.parametrize("name", ["/etc/passwd", "../../secrets.py", "a/../../b.py", "a.py\nSF:/etc/passwd", "a.txt"])
def test_no_exported_coverage_names_files_that_are_no_code(report: Path, name: str) -> None:
    changed = data()
    changed["code_under_test"]["map"][0]["file"] = name
    (report / "report.json").write_text(json.dumps(changed))
    with pytest.raises(ReportError, match="expected a file of Python, without steps upwards"):
        load(report)


TIMES = ["NaN\ta\tb\t{}", "1e999\ta\tb\t{}", '"x"\ta\tb\t{}', "1\ta\tb\t[1]", "1\ta\tb\t" + "[" * 50_000, "1"]


@pytest.mark.parametrize("message", TIMES)
def test_no_baseline_is_made_of_what_no_baseline_can_have(report: Path, message: str, capsys: Any) -> None:
    changed = data()
    changed["tests"][0]["timeline"]["messages"] = [message]
    (report / "report.json").write_text(json.dumps(changed))
    assert main(["gate", str(report), "--baseline=b.json", "--update-baseline"]) == 2
    errors = capsys.readouterr().err
    assert "of a timeline: expected time, sender, topic and fields as JSON" in errors
    assert len(errors) < 1000
    assert not Path("b.json").exists()


@pytest.mark.parametrize("name", ["failures/evil.json", "traces/evil.mcap", "films/evil.png"])
def test_merging_carries_nothing_along_that_a_link_leads_to(report: Path, victim: Path, name: str, capsys: Any) -> None:
    (report / name).parent.mkdir()
    (report / name).symlink_to(victim / "secret.json")
    assert main(["merge", str(report), "-o", "merged"]) == 2
    assert "evil" in (errors := capsys.readouterr().err)
    assert "a symbolic link, which is not followed here: remove it" in errors
    assert not Path("merged").exists()


@pytest.mark.parametrize("name", ["failures", "traces", "films"])
def test_merging_carries_no_folder_along_that_is_a_link(report: Path, victim: Path, name: str) -> None:
    (report / name).symlink_to(victim)
    assert main(["merge", str(report), "-o", "merged"]) == 2
    assert not Path("merged").exists()


def test_merging_reads_no_report_that_is_a_link(report: Path, tmp_path: Path, capsys: Any) -> None:
    (report / "report.json").rename(tmp_path / "private.json")
    (report / "report.json").symlink_to(tmp_path / "private.json")
    for named in (report, report / "report.json"):
        assert main(["merge", str(named), "-o", "merged"]) == 2
        assert "a symbolic link" in capsys.readouterr().err


def test_merging_carries_replays_films_and_traces_only(report: Path, tmp_path: Path) -> None:
    for name in ("failures/a.json", "failures/a.html", "films/a.svg", "films/a.png", "traces/a.mcap", "traces/x.js"):
        (report / name).parent.mkdir(exist_ok=True)
        (report / name).write_text("{}")
    main(["merge", str(report), "-o", "merged"])
    carried = {path.name for path in Path("merged").rglob("*") if path.parent.name != "merged" and path.is_file()}
    assert carried == {"a.json", "a.png", "a.mcap"}


@pytest.mark.parametrize("name", ["failures", "details"])
def test_merging_writes_and_removes_nothing_through_a_link_in_its_output(
    report: Path, victim: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.report.html.EMBEDDED_BYTES", 0 if name == "details" else 10**9)
    (report / "failures").mkdir()
    (report / "failures" / "new.json").write_text("{}")
    Path("merged").mkdir()
    Path("merged", name).symlink_to(victim)
    assert main(["merge", str(report), "-o", "merged"]) == 2
    assert untouched(victim)


def test_leftovers_are_not_removed_through_a_link(victim: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "details").symlink_to(victim)
    write(sample.report(tests=1), tmp_path / "out")
    assert untouched(victim)


@pytest.mark.parametrize("name", ["earlier", "whole"])
def test_an_earlier_report_is_moved_into_no_folder_that_is_a_link(report: Path, victim: Path, name: str) -> None:
    (report / name).symlink_to(victim)
    with pytest.raises(ReportError, match="a symbolic link is in the way"):
        supersede(report)
    assert untouched(victim)
    assert (report / "report.json").is_file()


def test_a_journal_that_is_a_link_is_neither_read_nor_written(tmp_path: Path, victim: Path) -> None:
    for target in (victim / "secret.json", tmp_path / "new"):
        (tmp_path / NAME).unlink(missing_ok=True)
        (tmp_path / NAME).symlink_to(target)
        with pytest.raises(OSError, match="a symbolic link, which is not followed here"):
            JournalWriter(tmp_path / NAME)
        with pytest.raises(OSError, match="a symbolic link, which is not followed here"):
            read(tmp_path / NAME)
    assert untouched(victim)
    assert not (tmp_path / "new").exists()


def test_rebuilding_empties_no_file_that_its_lock_leads_to(tmp_path: Path, victim: Path, capsys: Any) -> None:
    (tmp_path / "out").mkdir()
    JournalWriter(tmp_path / "out" / NAME).close()
    (tmp_path / "out" / ".lock").symlink_to(victim / "secret.json")
    assert main(["rebuild", str(tmp_path / "out")]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert untouched(victim)


def test_a_journal_with_a_name_that_leads_elsewhere_is_refused(tmp_path: Path, capsys: Any) -> None:
    declared = sample.report(tests=1)
    evil = msgspec.structs.replace(declared.tests[0], id="../../victim/x")
    writer = JournalWriter(tmp_path / NAME)
    for record in (
        StartRecord("2026-01-01", {}),
        SelectionRecord(msgspec.Raw(encode(declared).encode())),
        ResultRecord(evil.nodeid, 1.0, msgspec.Raw(encode(evil).encode())),
    ):
        writer.append(record)
    writer.close()
    assert main(["rebuild", str(tmp_path)]) == 2
    assert "matching regex" in (errors := capsys.readouterr().err)
    assert errors.count("\n") == 1


EVIL = "::add-mask::\x1b]0;owned\x07\u202e ##[group] ##vso[task.setvariable]"


def test_nothing_that_a_report_holds_reaches_the_terminal_raw(report: Path, capsys: Any) -> None:
    changed = data() | {"testbench": EVIL, "problems": [EVIL], "units": {EVIL: EVIL}, "outcome_label": EVIL}
    changed["tests"][0] |= {"outcome": "failed", "failure": EVIL, "errors": [EVIL], "target": EVIL, "nodeid": EVIL}
    changed["suites"][0]["fidelity"] = EVIL
    (report / "report.json").write_text(json.dumps(changed), encoding="utf-8")
    for arguments in (["gate"], ["export", "--summary=a.md"], ["minimal"], ["merge", "-o", "merged"]):
        more = ["out"] if arguments[0] == "minimal" else []
        main([arguments[0], str(report), *more, *arguments[1:]])
        said = "".join(capsys.readouterr())
        assert "owned" in said or arguments[0] in ("export", "minimal")
        assert [char for char in said if not char.isprintable() and char != "\n"] == [], arguments
        assert [line for line in said.splitlines() if line.strip().startswith("::") or "##[" in line] == []
    assert [char for char in Path("a.md").read_text() if not char.isprintable() and char != "\n"] == []
