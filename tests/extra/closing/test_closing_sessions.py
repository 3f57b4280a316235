"""Sessions with the suite `closure`: what it depends on, what is kept, interruption, errors, and wrong input."""

from __future__ import annotations

import os
from typing import Any

import pytest

from pytest_hricdv.extra.closing.strategy import Archive
from tests.plugin.project import A_WORKER, change, outcomes, report
from tests.plugin.test_bad_input import refused

SUITE = ("--hri-suite=closure", "--hri-close-runs=40")

DOUBLED = '        disturbances={"wish_doubled": Duplicate("wish", Uniform(0.4, 0.8, "s"))},\n'
BEFORE = "        level = level_for(wish)\n"
REPEATED = "        if level == before:\n            repeated()\n        before = level\n"


def disturb(project: pytest.Pytester) -> None:
    """The guide does something that only a doubled wish leads to; without one, nobody wishes twice."""
    change(project.path, "conftest.py", "        suites=", f"{DOUBLED}        suites=")
    change(project.path, "conftest.py", "Concretization, CrossProduct,", "Concretization, CrossProduct, Duplicate,")
    change(project.path, "lamps/guide.py", BEFORE, BEFORE + REPEATED)
    change(project.path, "lamps/guide.py", "    while True:\n", "    before = None\n    while True:\n")
    change(project.path, "lamps/guide.py", "def serviced", "def repeated():\n    return None\n\n\ndef serviced")


def ids(project: pytest.Pytester) -> list[str]:
    """Of the tests of the last report, in order."""
    return [test["id"] for test in report(project.path)["tests"]]


@pytest.mark.slow
def test_what_only_a_disturbance_leads_to_is_reached_and_exported_and_runs_again(lamps: pytest.Pytester) -> None:
    disturb(lamps)
    lamps.runpytest_inprocess(*SUITE, "--hri-export=kept")
    found = report(lamps.path)
    text = (lamps.path / "kept" / "closure.txt").read_text(encoding="utf-8")
    assert "disturb wish_doubled" in text
    assert "# values" in text
    assert found["suites"][0]["code"]["statements"]["covered"] == found["suites"][0]["code"]["statements"]["total"] - 1
    assert lamps.runpytest_inprocess("--hri-suite=kept/closure.txt").ret == 0
    again = report(lamps.path)
    hashes = [{test["id"]: test["record_sha256"] for test in each["tests"]} for each in (found, again)]
    assert hashes[0] == hashes[1]
    assert again["suites"][0]["code"] == found["suites"][0]["code"]


@pytest.mark.slow
def test_the_suite_depends_on_the_seed_and_not_on_the_number_of_processes(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    disturb(lamps)
    monkeypatch.setattr(os, "cpu_count", lambda: 3)
    found = []
    for options in (A_WORKER, (), ("--hri-seed=1",)):
        lamps.runpytest_inprocess(*SUITE, "-p", "no:cacheprovider", *options)
        found.append([(test["id"], test["record_sha256"]) for test in report(lamps.path)["tests"]])
    assert sorted(found[0]) == sorted(found[1]) != sorted(found[2])


@pytest.mark.slow
def test_a_kept_suite_holds_as_long_as_nothing_has_changed_that_its_runs_loaded(lamps: pytest.Pytester) -> None:
    def closed() -> bool:
        result = lamps.runpytest_inprocess(*SUITE, "--hri-close-runs=10")
        return any("closing ended" in line for line in result.outlines)

    assert [closed(), closed()] == [True, False]
    with (lamps.path / "conftest.py").open("a", encoding="utf-8") as file:
        file.write("\n# a comment\n")
    assert [closed(), closed()] == [True, False]
    change(lamps.path, "requirements.toml", "[0:2]", "[0:1.5]")
    assert closed()


@pytest.mark.slow
def test_after_another_suite_only_what_it_left_open_is_closed(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-close", "--hri-close-runs=40")
    result.stdout.fnmatch_lines(["hricdv: running the 4 tests of the other suites first ..."])
    suites = {suite["name"]: suite for suite in report(lamps.path)["suites"]}
    assert [*suites] == ["by-hand", "closure"]
    per_suite = [test["suite"] for test in report(lamps.path)["tests"]]
    assert (per_suite.count("by-hand"), per_suite.count("closure")) == (4, 4)


@pytest.mark.slow
def test_ctrl_c_keeps_what_was_reached_and_says_so(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    add = Archive.add

    def interrupted(self: Archive, *given: Any) -> Any:
        if len(self.entries) == 3:
            raise KeyboardInterrupt
        return add(self, *given)

    monkeypatch.setattr(Archive, "add", interrupted)
    result = lamps.runpytest_inprocess(*SUITE, no_reraise_ctrlc=True)
    assert 1 <= len(ids(lamps)) <= 3
    result.stdout.fnmatch_lines(
        [
            "hricdv: closing ended (interrupted) after 3 runs, *",
            "hricdv: what was reached until Ctrl-C is kept and runs now; Ctrl-C again ends all",
        ]
    )
    result = lamps.runpytest_inprocess(*SUITE, no_reraise_ctrlc=True)
    result.stdout.fnmatch_lines(["hricdv: closing ended (interrupted) *"])  # and is not kept as if it were the suite


LAMP = "    lamp = Lamp()\n"
GREETS = 'any(action.command == "greet" for action in run.test.actions)'


@pytest.mark.slow
def test_runs_that_err_are_noted_and_the_others_make_the_suite(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", LAMP, f"    if {GREETS}:\n        {{}}[run.test.seed]\n{LAMP}")
    lamps.runpytest_inprocess(*SUITE)
    (note,) = (note for note in report(lamps.path)["suites"][0]["generation"]["notes"] if "did not end" in note)
    assert "the first: KeyError: " in note
    assert {*outcomes(lamps.path).values()} == {"passed"}


@pytest.mark.slow
def test_a_run_that_kills_its_process_is_an_error_of_that_run(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", LAMP, f"    if {GREETS}:\n        os.kill(os.getpid(), 9)\n{LAMP}")
    change(lamps.path, "conftest.py", "from pathlib", "import os\nfrom pathlib")
    lamps.runpytest_inprocess(*SUITE)
    notes = report(lamps.path)["suites"][0]["generation"]["notes"]
    assert any("ended by SIGKILL" in note for note in notes)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--hri-close-runs=0"], "--hri-close-runs=0: expected at least 1"),
        (["--hri-close-runs=many"], "--hri-close-runs=many: expected a whole number"),
        (["--hri-close-seconds=0"], "--hri-close-seconds=0: expected at least 1"),
        (
            ["--hri-sampling=corners"],
            "--hri-sampling and the suite closure: the closing loop chooses parameters itself",
        ),
    ],
)
def test_wrong_options_are_refused(lamps: pytest.Pytester, options: list[str], told: str) -> None:
    assert told in refused(lamps, "--hri-suite=closure", *options)


def test_a_model_that_is_broken_is_an_error_before_any_run(lamps: pytest.Pytester) -> None:
    (lamps.path / "models" / "visitor.asl").write_text("@v1 +hall <- enter(hall", encoding="utf-8")
    assert "visitor.asl" in refused(lamps, *SUITE)


@pytest.mark.slow
def test_a_model_with_too_many_beliefs_to_enumerate_is_closed_by_drawn_belief_sets(lamps: pytest.Pytester) -> None:
    hats = ", ".join(f'"hat{number}"' for number in range(10))
    change(lamps.path, "conftest.py", '"wish": ("bright"', f'"hat": ({hats}), "wish": ("bright"')
    visitor = lamps.path / "models" / "visitor.asl"
    mentioned = "".join(f"+!never : hat{number} <- true.\n" for number in range(10))
    visitor.write_text(f"{visitor.read_text(encoding='utf-8')}\n{mentioned}", encoding="utf-8")
    lost = '        disturbances={"wish_lost": Drop("wish")},\n'
    change(lamps.path, "conftest.py", "        suites=", f"{lost}        suites=")
    change(lamps.path, "conftest.py", "Concretization, CrossProduct,", "Concretization, CrossProduct, Drop,")
    result = lamps.runpytest_inprocess(*SUITE)
    result.stdout.fnmatch_lines(
        ["hricdv: too large: 15 beliefs besides the start *agent 'usher' does other things *; so 264 sets of beliefs *"]
    )
    whole = report(lamps.path)
    assert len(whole["tests"]) >= 3
    assert whole["closing"]["end_reason"] == "runs"
    assert any("15 beliefs beside" in note for note in whole["suites"][0]["generation"]["notes"])
    assert "disturbances" in whole["closing"]["strategies"]


def test_no_test_is_made_of_beliefs_to_which_no_plan_applies(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", 'start=("hall", "cellar")', 'start=("attic", "hall", "cellar")')
    visitor = lamps.path / "models" / "visitor.asl"
    visitor.write_text(f"{visitor.read_text(encoding='utf-8')}\n+!never : attic <- true.\n", encoding="utf-8")
    lamps.runpytest_inprocess(*SUITE)
    tests = report(lamps.path)["tests"]
    assert tests
    assert all(test["action_times_s"] for test in tests)


LIFT = '''
"""The lift of the hall."""

from lamps.messages import Left

ENTERS_S = 2.0


def called(bus, clock, at_s):
    """Somebody on another floor calls after a time: the lift leaves, whoever is in its door."""
    clock.sleep(at_s)
    bus.publish(Left(from_door_s=abs(at_s - ENTERS_S)))
'''

LEFT = '''

@dataclass(frozen=True)
class Left:
    """The lift has left, so long before or after a robot was in its door (s)."""

    from_door_s: float
'''

DOOR = """
[R9]
title = "The lift does not leave while a robot is in its door"
formula = "always(on(left) -> left.from_door_s > 0.02)"
"""


def add_lift(project: pytest.Pytester) -> None:
    """A lift that leaves as the robot enters, once in a hundred runs; nothing that is covered depends on it."""
    (project.path / "lamps" / "lift.py").write_text(LIFT.lstrip("\n"), encoding="utf-8")
    for name, text in (("lamps/messages.py", LEFT), ("requirements.toml", DOOR)):
        path = project.path / name
        path.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")
    change(
        project.path,
        "conftest.py",
        "import Answer, Greeting, Switched, Wish\n",
        "import Answer, Greeting, Left, Switched, Wish\n",
    )
    change(project.path, "conftest.py", "messages=(Answer,", "messages=(Left, Answer,")
    change(project.path, "conftest.py", "run={", 'run={"called_s": Uniform(0.0, 4.0, "s"), ')
    change(project.path, "lamps/guide.py", '\n\ndef serviced():\n    return "by hand"\n', "")
    spawned = '    run.kernel.spawn("guide",'
    lift = (
        "    from lamps.lift import called\n\n"
        '    port, at_s = run.bus.port("lift"), run.test.run["called_s"]\n'
        '    run.kernel.spawn("lift", run.measured(lambda: called(port, run.kernel, at_s)))\n'
    )
    change(project.path, "conftest.py", spawned, lift + spawned)


@pytest.mark.slow
def test_a_lift_that_leaves_as_the_robot_enters_is_found_by_the_search_after_closing(lamps: pytest.Pytester) -> None:
    add_lift(lamps)
    options = ("--hri-suite=closure", "--hri-close-runs=200", "-p", "no:cacheprovider")
    closed = lamps.runpytest_inprocess("-vv", *options, "--hri-close-search=0")
    before = report(lamps.path)["closing"]
    assert closed.ret == 0
    assert "violated" not in closed.stdout.str()
    (lift,) = [near for near in before["closest_runs"] if near["requirement"] == "R9"]
    assert lift["margin"] > 0.02
    assert before.get("searched", 0) == lift["searched"] == 0
    assert before["estimated_undetected"]["kinds"] == 0
    closed.stdout.fnmatch_lines(["  no new violation in * runs: below * of runs show another (95 %)"])
    searched = lamps.runpytest_inprocess(*options, "--hri-close-search=64")
    after = report(lamps.path)["closing"]
    assert searched.ret == 1
    assert after["end_reason"] == before["end_reason"] == "closed"
    assert after["runs"] <= 200
    assert after["searched"] == after["runs"] - before["runs"] == after["strategies"]["violations"]["runs"]
    (kind,) = [violation for violation in after["violations"] if not violation.get("known")]
    assert kind["requirement"] == "R9"
    failed = [test["id"] for test in report(lamps.path)["tests"] if test["outcome"] == "failed"]
    assert failed == [kind["test"]]
    assert {near["requirement"]: near["searched"] for near in after["closest_runs"]}[
        "R2"
    ] == 0  # it is known, whatever violates it
