"""Logs are judged as runs are; what they do not have is unknown, and never passed."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv._base.message import InputError
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.extra.logs.fleet import Fleet
from pytest_hricdv.extra.logs.judging import LogVerdict, judge
from pytest_hricdv.extra.logs.log_map import LogMap, MessageSource, SignalSource, draft_map, of_own_trace, read_map
from pytest_hricdv.extra.logs.logged_run import LoggedRun, LogReader, TopicTimes
from pytest_hricdv.monitor import Vocabulary, load_requirements
from pytest_hricdv.recordings.recording import RecordingReader, recording_readers
from pytest_hricdv.results.codec import load
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


def reading(file: Path) -> RecordingReader:
    (reader,) = recording_readers([file], lambda kind: None)
    return reader


def reader_of(folder: Path, made: Sequence[Entry], text: str = MAP) -> LogReader:
    (folder / "map.toml").write_text(text)
    return LogReader(
        reading(write_mcap(folder / "run.mcap", made)), read_map(folder / "map.toml", VOCABULARY), VOCABULARY
    )


def judged(folder: Path, made: Sequence[Entry], text: str = MAP) -> list[tuple[LoggedRun, dict[str, LogVerdict]]]:
    (folder / "requirements.toml").write_text(REQUIREMENTS)
    requirements = load_requirements(folder / "requirements.toml", VOCABULARY)
    runs = judge(reader_of(folder, made, text), requirements)
    return [(each.run, {verdict.requirement: verdict for verdict in each.verdicts}) for each in runs]


def events(reader: LogReader, name: str) -> list[tuple[float, object]]:
    """The values of a signal, or the fields of a message, with their times."""
    return [(round(time_s, 6), value) for _, time_s, event, value in reader.events(reader.runs()) if event.name == name]


def test_a_map_says_what_is_what_with_units_scales_and_truths(tmp_path: Path) -> None:
    made = entries([0.1 * n for n in range(30)])
    reader = reader_of(tmp_path, made)
    assert events(reader, "level")[0] == (0.0, 1.0)
    assert events(reader, "is_open")[0] == (0.0, True)
    assert events(reader, "wish") == [(1.0, {"level": 0.5})]
    assert events(reader, "switched") == [(1.5, {})]
    ((_, verdicts),) = judged(tmp_path, made)
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
    level = events(reader_of(tmp_path, made, 'time = "header"\n' + MAP), "level")
    assert level == [(0.0, 0.01), (0.0, 0.02)]


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
    fields = {sample.topic: sample.fields for _, sample in reading(file).samples(lambda topic: {})}
    (tmp_path / "map.toml").write_text("\n".join(draft_map(fields, VOCABULARY)))
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
    assert check_traces(lamps.path) == (0, 4)  # a violation is known
    foreign = write_mcap(lamps.path / "foreign.mcap", [(0.0, "/wish", {})])
    status, logs, said = check(lamps.path, "conftest.py", str(foreign), "hri-report/traces")
    assert (status, len(logs)) == (2, 4)
    assert "conftest.py: the file is neither *.mcap nor *.db3" in said
    assert "error: check: foreign.mcap: no trace of --hri-mcap: expected --map" in said


def test_a_signal_may_be_resampled_and_computed_from_several_fields(tmp_path: Path) -> None:
    made: list[Entry] = [(0.1 * n, "/base", {"speed": {"x": 3.0, "y": 4.0 * n}}) for n in range(10)]
    text = '[signals.level]\ntopic = "/base"\nevery_s = 0.25\n'
    reader = reader_of(tmp_path, made, text + 'value = { expression = "hypot(speed.x, -speed.y) / 2", unit = "cm" }')
    expected: list[Any] = [
        (pytest.approx(time_s), pytest.approx(math.hypot(3.0, 40 * time_s) / 200)) for time_s in (0.0, 0.3, 0.6, 0.9)
    ]
    assert events(reader, "level") == expected


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed.x +", "invalid syntax"),
        ("__import__('os').system('x')", r"expected fields, numbers, \+ - \* / and abs"),
        ("[].x", "expected a field, as pose.position.x"),
        ("1 + " * 300 + "1", "has more than 1,000 characters"),
    ],
)
def test_an_expression_that_is_none_is_said(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=said):
        reader_of(tmp_path, [], f'[signals.level]\ntopic = "/base"\nvalue = {{ expression = "{text}" }}')


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed.z", "no field speed.z"),
        ("1 / speed.x", "division by zero"),
        ("abs(speed.x, 1)", "abs"),
        ("name", "name is none"),
    ],
)
def test_an_expression_without_a_value_is_said(text: str, said: str, tmp_path: Path) -> None:
    text = f'[signals.level]\ntopic = "/base"\nvalue = {{ expression = "{text}" }}'
    with pytest.raises(InputError, match=said):
        events(reader_of(tmp_path, [(0.0, "/base", {"speed": {"x": 0.0}, "name": "a"})], text), "level")


@given(st.lists(st.floats(0.01, 9.0), max_size=60), st.floats(0.0, 9.0), st.floats(0.05, 5.0))
def test_gaps_are_the_waits_that_are_too_long(waits: list[float], rest_s: float, limit_s: float) -> None:
    times = [*accumulate(waits, initial=0.5)]
    topic = TopicTimes(times[0], times[0])
    for time_s in times[1:]:
        topic.add(time_s)
    end_s = times[-1] + rest_s
    expected = [span for span in pairwise((0.0, *times, end_s)) if span[1] - span[0] > limit_s]
    assert len(topic.gaps(end_s, limit_s)) == len(expected)
    for found, span in zip(topic.gaps(end_s, limit_s), expected, strict=True):
        assert list(found) == pytest.approx(list(span))


def test_a_topic_with_thousands_of_gaps_is_unknown_as_a_whole(tmp_path: Path) -> None:
    ((_, verdicts),) = judged(tmp_path, entries([3.0 * n for n in range(1200)]))
    assert verdicts["R2"].unknown == "no data of level from 0.000 to 3597.000 s"


def test_messages_that_cannot_be_read_make_what_reads_them_unknown(tmp_path: Path) -> None:
    made = [*entries([0.1 * n for n in range(30)]), (2.95, "/cell/state", b"{")]
    ((_, verdicts),) = judged(tmp_path, made)
    assert (verdicts["R1"].verdict, verdicts["R2"].unknown) == ("Passed", "1 message of level cannot be read")


def test_numbers_that_are_not_finite_make_what_reads_them_unknown(tmp_path: Path) -> None:
    text = MAP.replace('{ path = "height", unit = "cm" }', '{ expression = "height * 1e300 * 1e-302" }')
    made = [*entries([0.1 * n for n in range(30)]), (2.95, "/cell/state", {"height": 1e9, "door": "open"})]
    ((_, verdicts),) = judged(tmp_path, made, text)
    assert (verdicts["R1"].verdict, verdicts["R2"].unknown) == ("Passed", "1 value of level is not finite")
    ((_, verdicts),) = judged(tmp_path, [*made, (2.96, "/cell/state", {"height": 9e3, "door": "open"})], text)
    assert verdicts["R2"].verdict == "Failed"


def test_what_was_never_triggered_has_its_nearest_miss(tmp_path: Path) -> None:
    made = entries([0.1 * n for n in range(30)], height=-5.0)
    ((_, verdicts),) = judged(tmp_path, made)
    (part,) = verdicts["R2"].stretches
    assert part.near_miss is not None
    assert part.near_miss.missing == ("level > 0",)
    assert part.near_miss.distance == pytest.approx(0.05)


PRODUCT = CrossProduct({"room": ("hall", "cellar"), "R1": ("Passed", "Failed", "NC")})


def test_many_logs_are_compared_with_tests(tmp_path: Path) -> None:
    text = MAP + '[cross.rides]\ntopic = "/cell/ride"\ncoordinates = { room = "room" }\n'
    (tmp_path / "map.toml").write_text(text)
    (tmp_path / "requirements.toml").write_text(REQUIREMENTS)
    requirements = load_requirements(tmp_path / "requirements.toml", VOCABULARY)
    fleet = Fleet(["R1", "R2"], {"rides": PRODUCT})
    made = read_map(tmp_path / "map.toml", VOCABULARY, {"rides": PRODUCT})
    for room in ("hall", "attic"):
        file = write_mcap(
            tmp_path / "run.mcap", [*entries([0.1 * n for n in range(30)]), (2.9, "/cell/ride", {"room": room})]
        )
        (each,) = judge(LogReader(reading(file), made, VOCABULARY), requirements)
        fleet.add(each, {})
    assert fleet.hits == {"rides": {("hall", "Passed"): 1}}
    assert fleet.faults == ["run.mcap: rides: ('attic',) is not a bin; coordinates are room"]
    assert not fleet.is_good
    with pytest.raises(InputError, match=r"cross\.rides: the testbench has no such cross product; nearest: ride"):
        read_map(tmp_path / "map.toml", VOCABULARY, {"ride": PRODUCT})


@pytest.mark.slow
def test_logs_have_a_page_and_say_what_only_tests_cover(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand", "-p", "no:cacheprovider", "-p", "no:xdist", "--hri-mcap-all")
    traces = sorted((lamps.path / "hri-report" / "traces").iterdir())
    arguments = [str(traces[0]), "--against", "hri-report", "-o", "logs"]
    status, (_, difference), _ = check(lamps.path, *arguments)
    assert status in (0, 1)
    assert difference["only_logs"] == {"requirements": [], "bins": {}, "actions": []}
    report = load(lamps.path / "logs")
    assert [(test.suite, test.name, test.sim_s > 0) for test in report.tests] == [("logs", f"{traces[0].name}", True)]
    ran = {test.trace.file: test for test in load(lamps.path / "hri-report").tests}  # type: ignore[attr-defined]
    (same,) = [test for file, test in ran.items() if file.endswith(traces[0].name)]
    assert report.tests[0].requirements == {name: same.requirements[name] for name in report.tests[0].requirements}
    assert report.tests[0].cross == same.cross == {"light": (("cellar", "100"),)}
    hits = {hit for test in ran.values() for hit in (test.cross or {})["light"]}
    assert {*map(tuple, difference["only_tests"]["bins"]["light"])} == hits - {("cellar", "100")}
    assert "Compared with the tests of hri-report" in (lamps.path / "logs" / "index.html").read_text(encoding="utf-8")


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
