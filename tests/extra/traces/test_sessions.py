"""Runs as MCAP files, read back with MCAP's own reader."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from jsonschema import validate
from mcap.reader import make_reader

from pytest_hricdv.extra.traces.trace_writer import ObservedWorld
from pytest_hricdv.runtime import Recorder
from pytest_hricdv.testbench import Body
from tests.plugin import project

ASKED = ("--hri-suite=by-hand", "-p", "no:cacheprovider")


def messages(path: Path) -> Iterator[tuple[str, float, dict[str, Any], dict[str, str]]]:
    """Topic, time (s), content and metadata of each message, in order; each fits its schema."""
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            content = json.loads(message.data)
            validate(content, json.loads(schema.data))
            assert message.log_time == message.publish_time
            yield channel.topic, message.log_time // 1000 / 1e6, content, channel.metadata


def record_hash(path: Path) -> str:
    """The hash of the record that a trace has, made anew from its messages and signals."""
    recorder = Recorder()
    for topic, time_s, content, metadata in messages(path):
        if topic.startswith("/signals/"):
            recorder.signal(time_s, topic.removeprefix("/signals/"), content["value"])
        elif topic == "/hricdv/disturbances":
            recorder.disturbance(time_s, metadata["sender"], content["event"], content["fields"])
        elif not topic.startswith("/hricdv/"):
            recorder.message(time_s, metadata["sender"], topic.removeprefix("/"), content)
    return recorder.finish().sha256


def facts(path: Path) -> dict[str, str]:
    with path.open("rb") as file:
        (metadata,) = make_reader(file).iter_metadata()
    return metadata.metadata


def traces(lamps: pytest.Pytester) -> dict[str, Path]:
    """Test -> its trace, by the report."""
    tests = project.report(lamps.path)["tests"]
    return {test["id"]: lamps.path / "hri-report" / test["trace"]["file"] for test in tests if "trace" in test}


@pytest.mark.parametrize("workers", [["-p", "no:xdist"], pytest.param(["-n", "2"], marks=pytest.mark.slow)])
def test_a_trace_has_the_record_and_the_verdicts(lamps: pytest.Pytester, workers: list[str]) -> None:
    result = lamps.runpytest_inprocess(*ASKED, "--hri-mcap-all", *workers)
    found, report = traces(lamps), project.report(lamps.path)
    assert len(found) == len(report["tests"]) == 4
    for test in report["tests"]:
        path = found[test["id"]]
        assert record_hash(path) == test["record_sha256"] == facts(path)["record_sha256"]
        assert facts(path)["verdict of R1"] == test["requirements"]["R1"]["verdict"]
        every = list(messages(path))
        assert next(each[2] for each in every if each[0] == "/hricdv/end")["verdicts"]["R1"] == "Passed"
        said = [content["message"] for topic, _, content, _ in every if topic == "/hricdv/log"]
        assert len(said) == sum(len(of["violations"]) for of in test["requirements"].values()) + len(
            test["action_times_s"]
        )
    result.stdout.fnmatch_lines(["traces: 4 of 4 tests, next to the report"])


@pytest.mark.slow
def test_without_more_the_failing_tests_have_one_and_it_is_the_same_each_time(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(*ASKED, "-p", "no:xdist", "--hri-mcap")
    outcomes, found = project.outcomes(lamps.path), traces(lamps)
    assert found.keys() == {name for name, outcome in outcomes.items() if outcome == "known-violation"} != set()
    before = {name: path.read_bytes() for name, path in found.items()}
    violated = [each for path in found.values() for each in messages(path) if each[0] == "/hricdv/violations"]
    assert {content["requirement"] for _, _, content, _ in violated} == {"R2"}
    lamps.runpytest_inprocess(*ASKED, "-p", "no:xdist", "--hri-mcap")
    assert {name: path.read_bytes() for name, path in traces(lamps).items()} == before


def test_without_its_library_it_says_what_to_install(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.traces.feature.find_spec", lambda name: None)
    result = lamps.runpytest_inprocess(*ASKED, "-p", "no:xdist", "--hri-mcap")
    result.stderr.fnmatch_lines(['ERROR: --hri-mcap: mcap is not installed: pip install "pytest-hricdv[traces]"'])


@pytest.mark.slow
def test_a_trace_that_cannot_be_written_is_a_note(lamps: pytest.Pytester) -> None:
    (lamps.path / "hri-report").mkdir()
    (lamps.path / "hri-report" / "traces").write_text("in the way", encoding="utf-8")
    result = lamps.runpytest_inprocess(*ASKED, "-p", "no:xdist", "--hri-mcap-all")
    result.stdout.fnmatch_lines(["traces: 0 of 4 tests, next to the report", "  4 not written: *"])
    assert set(project.outcomes(lamps.path).values()) == {"passed", "known-violation"}


def test_bodies_that_move_come_and_go_are_noted_without_stopping_the_world() -> None:
    class World:
        def __init__(self) -> None:
            self.asked: list[int] = []

        def advance(self, target_us: int) -> int:
            self.asked.append(target_us)
            return target_us

        def observe(self) -> None:
            pass

    def bodies(world: World) -> list[Body]:
        moved = Body("ball", "sphere", (0.1, 0.1, 0.1), (0.0, 0.0, float(len(world.asked) // 2)))
        wall = Body("wall", "box", (1.0, 0.1, 1.0), (0.0, 1.0, 0.0))
        return [moved, wall] if len(world.asked) < 6 else [moved]

    world = World()
    observed = ObservedWorld(world, bodies, period_us=100)
    for target_us in (60, 120, 180, 240, 300, 360, 420):
        observed.advance(target_us)
    assert world.asked == [60, 120, 180, 240, 300, 360, 420]
    seen = [(each.time_us, [body.name for body in each.moved], each.gone) for each in observed.changes]
    assert seen == [(0, ["ball", "wall"], ()), (120, ["ball"], ()), (240, ["ball"], ()), (360, ["ball"], ("wall",))]
