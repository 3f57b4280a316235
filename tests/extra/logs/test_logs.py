"""Logs are judged as runs are; what they do not have is unknown, and never passed."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.logs.judging import LoggedRun, LogVerdict, judge, runs_of
from pytest_hricdv.extra.logs.log_map import LogMap, MessageSource, SignalSource, draft_map, of_own_trace, read_map
from pytest_hricdv.monitor import Vocabulary, load_requirements
from pytest_hricdv.recordings.recording import Recording, read_recordings
from tests.plugin import project
from tests.recordings.bags import Entry, write_mcap

VOCABULARY = Vocabulary(
    signals={"level": float, "is_open": bool},
    messages={"wish": {"level": float}, "switched": {}},
    units={"level": "m", "wish.level": "m"},
)
REQUIREMENTS = """
[R1]
title = "A wish is fulfilled within a second"
formula = "always(on(wish) -> eventually[0:1](on(switched)))"

[R2]
title = "The level stays below"
formula = "always(level > 0 -> level <= 80)"
"""
MAP = """
[messages.wish]
topic = "/cell/wish"
fields.level = { path = "percent", scale = 0.01 }

[messages.switched]
topic = "/cell/done"

[signals.level]
topic = "/cell/state"
value = { path = "height", unit = "cm" }
gap_s = 2.0

[signals.is_open]
topic = "/cell/state"
value = { path = "door", equals = "open" }
"""


def entries(times_s: Sequence[float], height: float = 100.0) -> list[Entry]:
    states: list[Entry] = [(t, "/cell/state", {"height": height, "door": "open"}) for t in times_s]
    wishes: list[Entry] = [(1.0, "/cell/wish", {"percent": 50.0}), (1.5, "/cell/done", {})]
    return sorted([*states, *wishes], key=lambda entry: entry[0])


def reading(file: Path) -> Recording:
    (recording,) = read_recordings([file], lambda topic: True, lambda kind: None)
    return recording


def judged(folder: Path, made: Sequence[Entry], text: str = MAP) -> list[tuple[LoggedRun, dict[str, LogVerdict]]]:
    (folder / "map.toml").write_text(text)
    (folder / "requirements.toml").write_text(REQUIREMENTS)
    requirements = load_requirements(folder / "requirements.toml", VOCABULARY)
    own = read_map(folder / "map.toml", VOCABULARY)
    runs = runs_of(reading(write_mcap(folder / "run.mcap", made)), own, VOCABULARY)
    return [(run, {verdict.requirement: verdict for verdict in judge(requirements, run)}) for run in runs]


def test_a_map_says_what_is_what_with_units_scales_and_truths(tmp_path: Path) -> None:
    ((run, verdicts),) = judged(tmp_path, entries([0.1 * n for n in range(30)]))
    assert run.log.signals["level"][1][0] == pytest.approx(1.0)
    assert run.log.signals["is_open"][1][0] is True
    assert [(message.topic, dict(message.fields)) for message in run.log.messages] == [
        ("wish", {"level": 0.5}),
        ("switched", {}),
    ]
    assert [verdicts[name].verdict for name in ("R1", "R2")] == ["Passed", "Passed"]
    assert verdicts["R1"].margin == pytest.approx(0.5)
    assert verdicts["R2"].margin == pytest.approx(79.0)


def test_where_there_is_no_data_what_reads_it_is_unknown(tmp_path: Path) -> None:
    ((_, verdicts),) = judged(tmp_path, entries([*(0.1 * n for n in range(30)), *(9.0 + 0.1 * n for n in range(30))]))
    assert (verdicts["R1"].verdict, verdicts["R1"].unknown) == ("Passed", "")
    assert (verdicts["R2"].verdict, verdicts["R2"].unknown) == ("unknown", "no data of level from 2.900 to 9.000 s")


def test_what_fails_beside_a_gap_fails(tmp_path: Path) -> None:
    late = entries([9.0 + 0.1 * n for n in range(30)], height=9000.0)
    ((_, verdicts),) = judged(tmp_path, [*entries([0.1 * n for n in range(30)]), *late[2:]])
    assert verdicts["R2"].verdict == "Failed"
    assert [violation.time_s for part in verdicts["R2"].stretches for violation in part.violations] == [9.0]


def test_a_periodic_topic_that_pauses_has_a_gap_by_itself(tmp_path: Path) -> None:
    made = entries([*(0.1 * n for n in range(30)), *(4.0 + 0.1 * n for n in range(30))])
    ((run, _),) = judged(tmp_path, made, MAP.replace("gap_s = 2.0\n", ""))
    assert {name: [(round(a, 3), round(b, 3)) for a, b in spans] for name, spans in run.gaps.items()} == {
        "level": [(2.9, 4.0)],
        "is_open": [(2.9, 4.0)],
    }


def test_what_a_log_lacks_is_unknown(tmp_path: Path) -> None:
    made = [entry for entry in entries([0.1 * n for n in range(30)]) if entry[1] != "/cell/done"]
    ((_, verdicts),) = judged(tmp_path, made)
    assert (verdicts["R1"].verdict, verdicts["R1"].unknown) == ("unknown", "the log has no switched")


def test_a_log_whose_clock_jumps_is_judged_in_parts(tmp_path: Path) -> None:
    made = [*entries([0.1 * n for n in range(30)]), *((t - 50.0, *rest) for t, *rest in entries([0.0, 1.0, 2.0]))]
    parts = judged(tmp_path, made)
    assert [run.name for run, _ in parts] == ["run.mcap, part 1", "run.mcap, part 2"]
    assert [verdicts["R1"].verdict for _, verdicts in parts] == ["Passed", "Passed"]


def test_times_may_be_those_of_headers(tmp_path: Path) -> None:
    stamped = {"header": {"stamp": {"sec": 7, "nanosec": 500_000_000}}, "height": 1.0, "door": "shut"}
    made: list[Entry] = [(0.0, "/cell/state", stamped), (5.0, "/cell/state", {**stamped, "height": 2.0})]
    ((run, _),) = judged(tmp_path, made, 'time = "header"\n' + MAP)
    assert run.log.signals["level"][0] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[messages.wish]", "[messages.wishes]", "messages.wishes: the testbench has no such message"),
        ("fields.level", "fields.levels", "messages.wish.fields.levels: the message has no such field"),
        ('unit = "cm"', 'unit = "deg"', "level: its unit is m, which is none of deg"),
        ("gap_s = 2.0", "gaps = 2.0", "unknown key 'gaps'; nearest: gap_s"),
        ("gap_s = 2.0", "gap_s = inf", "expected a finite number"),
        ("[signals.level]", "[signals.level", "map.toml:9:15: not TOML"),
    ],
)
def test_what_is_wrong_with_a_map_is_said(old: str, new: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(MAP.replace(old, new))
    with pytest.raises(InputError, match=said):
        read_map(tmp_path / "map.toml", VOCABULARY)


@pytest.mark.parametrize(("old", "new"), [("percent", "percents"), ("height", "door")])
def test_a_message_without_its_field_is_said(old: str, new: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"level: (its messages have no field percents|door is 'open'; expected)"):
        judged(tmp_path, entries([0.0, 1.0]), MAP.replace(f'path = "{old}"', f'path = "{new}"'))


def test_the_draft_of_a_map_is_one(tmp_path: Path) -> None:
    file = write_mcap(tmp_path / "run.mcap", [(0.0, "/wish", {"level": 1.0}), (0.5, "/level", {"data": 2.0})])
    (tmp_path / "map.toml").write_text("\n".join(draft_map([reading(file)], VOCABULARY)))
    made = read_map(tmp_path / "map.toml", VOCABULARY)
    assert made.messages["wish"] == MessageSource(topic="/wish", fields={"level": "level"})
    assert made.signals["level"] == SignalSource(topic="/level", value="data")
    assert made.messages["switched"].topic == ""


def test_the_map_of_own_traces_has_no_gaps() -> None:
    own = of_own_trace({"/wish": "", "/signals/level": ""}, VOCABULARY)
    assert own.is_own
    assert not LogMap().is_own
    assert [*own.sources] == ["wish", "level"]


def check(folder: Path, *arguments: str) -> tuple[int, list[dict[str, Any]], str]:
    """The status, the lines of JSON, and what was said of it."""
    command = [sys.executable, "-m", "pytest_hricdv", "check", *arguments, "--json"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()], done.stderr


def check_traces(folder: Path) -> tuple[int, int]:
    """Check the traces of a report: status, and how many have the verdicts and margins of their tests."""
    status, logs, said = check(folder, "hri-report/traces")
    assert said == ""
    tests = {test["trace"]["file"]: test["requirements"] for test in project.report(folder)["tests"]}
    for log in logs:
        expected = {name: (each["verdict"], each["margin"]) for name, each in tests.pop(log["log"]).items()}
        assert {n: (each["verdict"], each["margin"]) for n, each in log["requirements"].items()} == expected
    assert tests == {}
    return status, len(logs)


@pytest.mark.slow
def test_traces_of_tests_have_the_verdicts_and_margins_of_their_runs(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand", "-p", "no:cacheprovider", "-p", "no:xdist", "--hri-mcap-all")
    project.change(lamps.path, "pytest.ini", "[pytest]\n", "[pytest]\nfilterwarnings = error\n")
    assert check_traces(lamps.path) == (1, 4)
    foreign = write_mcap(lamps.path / "foreign.mcap", [(0.0, "/wish", {})])
    status, logs, said = check(lamps.path, "conftest.py", str(foreign), "hri-report/traces")
    assert (status, len(logs)) == (2, 4)
    assert "conftest.py: the file is neither *.mcap nor *.db3" in said
    assert "error: check: foreign.mcap: no trace of --hri-mcap: expected --map" in said


ACTIONS = """
[actions.enter]
topic = "/door"
command = "enter {room}"
since = "pause_s"

[actions.greet]
topic = "/speech"
command = "greet"
only = { said = "hello" }
since = "pause_s"

[actions.wish]
topic = "/wish"
command = "set_lamp level = {percent}"
parameters.pause_s = { path = "thought_ms", scale = 0.001 }
"""
FIELD_LOG: list[Entry] = [
    (0.0, "/door", {"room": "hall"}),
    (0.75, "/speech", {"said": "hello"}),
    (1.0, "/speech", {"said": "well"}),
    (4.0, "/wish", {"percent": 10.0, "thought_ms": 900.0}),
]


def to_tests(folder: Path, made: Sequence[Entry], actions: str = ACTIONS) -> subprocess.CompletedProcess[str]:
    """What `--to-tests` makes of a log, in `logged.txt`."""
    write_mcap(folder / "field.mcap", made)
    (folder / "map.toml").write_text(actions)
    command = [sys.executable, "-m", "pytest_hricdv", "check", "field.mcap", "--map=map.toml", "--to-tests=logged.txt"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_what_the_person_did_in_a_log_is_a_test_that_runs(lamps: pytest.Pytester) -> None:
    done = to_tests(lamps.path, FIELD_LOG)
    assert (done.returncode, done.stdout) == (0, "1 test in logged.txt; now: pytest --hri-suite=logged.txt\n"), done
    assert done.stderr == (
        "note: field.mcap: action 1, enter hall: pause_s is 0, outside of its range [0.5, 1] s: it is drawn\n"
    )
    text = (lamps.path / "logged.txt").read_text()
    assert "# values 2: pause_s 0.75\n# values 3: pause_s 0.9\nenter hall\ngreet\nset_lamp level = 10\n" in text
    assert lamps.runpytest_inprocess("--hri-suite=logged.txt", "-p", "no:xdist").ret == 0
    (test,) = project.report(lamps.path)["tests"]
    assert test["concrete"]["actions"][1]["parameters"]["pause_s"] == 0.75


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"hall"', '"attic"', "field.mcap: /door is 'enter attic', which the testbench has no command for; nearest: "),
        ('"{room}"', '"{rom}"', "/door: its messages have no field rom; nearest: room"),
        ('command = "greet"', 'command = "greet("', "/speech: 'greet(' is not a command; expected "),
        ('"thought_ms"', '"thought"', "actions./wish.pause_s: thought is None; expected a number; nearest: thought_ms"),
        ("parameters.pause_s", "parameters.paus_s", "has no parameter paus_s; nearest: pause_s"),
        ("hello", "bye", ""),
    ],
)
def test_an_action_that_cannot_be_one_is_refused_with_its_topic(
    lamps: pytest.Pytester, old: str, new: str, told: str
) -> None:
    made = [(t, topic, {k: "attic" if v == "hall" and old == '"hall"' else v for k, v in fields.items()})
            for t, topic, fields in FIELD_LOG]  # fmt: skip
    old, new = old.strip('"'), new.strip('"')
    done = to_tests(lamps.path, made, ACTIONS.replace(old, new))
    assert told in done.stderr
    assert (done.returncode == 0) == (not told)
    assert (lamps.path / "logged.txt").exists() == (not told)
