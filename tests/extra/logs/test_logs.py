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
from pytest_hricdv.extra.logs.judging import JudgedRun, judge
from pytest_hricdv.extra.logs.log_map import LogMap, MessageSource, SignalSource, draft_map, map_own_trace, read_map
from pytest_hricdv.extra.logs.logged_run import LogReader, TopicTimes
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
fields.level = { expression = "percent / 100" }

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


def judged(folder: Path, made: Sequence[Entry], text: str = MAP) -> list[JudgedRun]:
    (folder / "requirements.toml").write_text(REQUIREMENTS)
    requirements = load_requirements(folder / "requirements.toml", VOCABULARY)
    return judge(reader_of(folder, made, text), requirements)


def only_run(folder: Path, made: Sequence[Entry], text: str = MAP) -> JudgedRun:
    (run,) = judged(folder, made, text)
    return run


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
    run = only_run(tmp_path, made)
    assert (run.word("R1"), run.word("R2"), run.unknown) == ("Passed", "Passed", {})
    assert run.verdicts["R1"].margin == pytest.approx(0.5)
    assert run.verdicts["R2"].margin == pytest.approx(79.0)


def test_messages_without_the_values_that_a_source_must_have_are_ignored(tmp_path: Path) -> None:
    text = '[signals.level]\ntopic = "/base"\nvalue = "height"\nonly = { unit = "m" }\n'
    made: list[Entry] = [(0.1 * n, "/base", {"height": float(n), "unit": "m" if n % 2 else "ft"}) for n in range(4)]
    assert events(reader_of(tmp_path, made, text), "level") == [(0.1, 1.0), (0.3, 3.0)]


AROUND_A_GAP = [*(0.1 * n for n in range(30)), *(9.0 + 0.1 * n for n in range(30))]


def test_a_requirement_is_unknown_where_a_source_has_a_gap(tmp_path: Path) -> None:
    run = only_run(tmp_path, entries(AROUND_A_GAP))
    assert (run.word("R1"), run.word("R2")) == ("Passed", "unknown")
    assert run.unknown == {"R2": "no data of level from 2.900 to 9.000 s"}


def test_a_failure_next_to_a_gap_counts(tmp_path: Path) -> None:
    late = entries([9.0 + 0.1 * n for n in range(30)], height=9000.0)
    run = only_run(tmp_path, [*entries([0.1 * n for n in range(30)]), *late[2:]])
    assert run.word("R2") == "Failed"
    assert [violation.time_s for violation in run.verdicts["R2"].violations] == [9.0]


def test_a_periodic_topic_that_pauses_has_a_gap(tmp_path: Path) -> None:
    made = entries([*(0.1 * n for n in range(30)), *(4.0 + 0.1 * n for n in range(30))])
    run = only_run(tmp_path, made, MAP.replace("gap_s = 2.0\n", "")).run
    gaps = {name: [(round(a, 3), round(b, 3)) for a, b in spans] for name, spans in run.gaps.items()}
    assert gaps == {"level": [(2.9, 4.0)], "is_open": [(2.9, 4.0)]}


def test_a_topic_that_is_missing_makes_its_requirements_unknown(tmp_path: Path) -> None:
    run = only_run(tmp_path, [entry for entry in entries([0.1 * n for n in range(30)]) if entry[1] != "/cell/done"])
    assert run.unknown == {"R1": "the log has no switched"}


def test_a_log_whose_clock_jumps_is_judged_in_parts(tmp_path: Path) -> None:
    made = [*entries([0.1 * n for n in range(30)]), *((t - 50.0, *rest) for t, *rest in entries([0.0, 1.0, 2.0]))]
    parts = judged(tmp_path, made)
    assert [(part.run.name, part.word("R1")) for part in parts] == [
        ("run.mcap, part 1", "Passed"),
        ("run.mcap, part 2", "Passed"),
    ]


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
        ('unit = "cm"', 'unit = "deg"', "level: its unit is m, to which deg cannot be converted"),
        ('unit = "cm"', "equals = 1.0", "level: equals is for truth values only"),
        ("gap_s = 2.0", "gaps = 2.0", "unknown key 'gaps'; nearest: gap_s"),
        ("gap_s = 2.0", "gap_s = inf", "expected a finite number"),
        ("gap_s = 2.0", "gap_s = -1.0", r"> 0.0 - at .*gap_s"),
        ("[signals.level]", "[signals.level", "map.toml:9:15: not TOML"),
    ],
)
def test_what_is_wrong_with_a_map_is_said(old: str, new: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(MAP.replace(old, new))
    with pytest.raises(InputError, match=said):
        read_map(tmp_path / "map.toml", VOCABULARY)


@pytest.mark.parametrize(
    ("old", "new"), [('path = "height", unit = "cm"', 'path = "heights"'), ('path = "height"', 'path = "door"')]
)
def test_a_message_without_its_field_is_said(old: str, new: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"level: (its messages have no field heights|door is 'open'; expected)"):
        judged(tmp_path, entries([0.0, 1.0]), MAP.replace(old, new))


def test_the_draft_of_a_map_is_one(tmp_path: Path) -> None:
    file = write_mcap(tmp_path / "run.mcap", [(0.0, "/wish", {"level": 1.0}), (0.5, "/level", {"data": 2.0})])
    fields = {sample.topic: sample.fields for _, sample in reading(file).samples(lambda topic: {})}
    (tmp_path / "map.toml").write_text("\n".join(draft_map(fields, VOCABULARY)))
    made = read_map(tmp_path / "map.toml", VOCABULARY)
    assert made.messages["wish"] == MessageSource(topic="/wish", fields={"level": "level"})
    assert made.signals["level"] == SignalSource(topic="/level", value="data")
    assert made.messages["switched"].topic == ""


def test_the_map_of_own_traces_has_no_gaps() -> None:
    own = map_own_trace({"/wish": "", "/signals/level": ""}, VOCABULARY)
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
    assert "error: check: foreign.mcap: not a trace of --hri-mcap: expected --map" in said


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
        ("[].x", "expected a field, such as pose.position.x"),
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
        ("name", "name is not one"),
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
    run = only_run(tmp_path, entries([3.0 * n for n in range(1200)]))
    assert run.unknown == {"R2": "no data of level from 0.000 to 3597.000 s"}


def test_messages_that_cannot_be_read_make_requirements_unknown(tmp_path: Path) -> None:
    run = only_run(tmp_path, [*entries([0.1 * n for n in range(30)]), (2.95, "/cell/state", b"{")])
    assert (run.word("R1"), run.unknown) == ("Passed", {"R2": "1 message of level cannot be read"})


def test_numbers_that_are_not_finite_make_requirements_unknown(tmp_path: Path) -> None:
    text = MAP.replace('{ path = "height", unit = "cm" }', '{ expression = "height * 1e300 * 1e-302" }')
    made = [*entries([0.1 * n for n in range(30)]), (2.95, "/cell/state", {"height": 1e9, "door": "open"})]
    assert only_run(tmp_path, made, text).unknown == {"R2": "1 value of level is not finite"}
    failing: list[Entry] = [*made, (2.96, "/cell/state", {"height": 9e3, "door": "open"})]
    assert only_run(tmp_path, failing, text).word("R2") == "Failed"


def test_a_requirement_that_was_never_triggered_has_its_near_miss(tmp_path: Path) -> None:
    miss = only_run(tmp_path, entries([0.1 * n for n in range(30)], height=-5.0)).verdicts["R2"].near_miss
    assert miss is not None
    assert miss.missing == ("level > 0",)
    assert miss.distance == pytest.approx(0.05)


def test_hits_of_cross_products_are_named_by_coordinates(tmp_path: Path) -> None:
    """In any order; that of the product counts."""
    text = MAP + '[cross.rides]\ntopic = "/cell/ride"\ncoordinates = { room = "room", floor = "level" }\n'
    made: list[Entry] = [*entries([0.1 * n for n in range(30)]), (2.9, "/cell/ride", {"room": "hall", "level": 1})]
    assert only_run(tmp_path, made, text).hits == {"rides": {(("room", "hall"), ("floor", "1"))}}
    product = CrossProduct({"floor": ("1", "2"), "room": ("hall", "cellar")})
    with pytest.raises(InputError, match=r"cross\.rides: the testbench has no such cross product; nearest: ride"):
        read_map(tmp_path / "map.toml", VOCABULARY, {"ride": product})


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
    (lamps.path / "map.toml").write_text(
        '[cross.light]\ntopic = "/ride"\ncoordinates = { place = "to", level = "n" }\n'
    )
    attic = write_mcap(lamps.path / "attic.mcap", [(0.0, "/ride", {"to": "attic", "n": 1.0})])
    status, _, _ = check(lamps.path, str(attic), "--map=map.toml", "-o", "logs")
    gates = load(lamps.path / "logs").gates
    assert gates is not None
    assert (status, gates.failed[-1]) == (
        1, "attic.mcap: light: ('attic', '1') is not a bin; coordinates are place, level"
    )  # fmt: skip
