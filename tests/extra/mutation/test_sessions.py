"""Seeded faults through the plugin: what becomes of each, the budget, the gate, and what is wrong input."""

from __future__ import annotations

import importlib.util
import os
from typing import Any

import pytest

from pytest_hricdv.extra.mutation import mutating
from pytest_hricdv.session.collection import Collection
from tests import json_schema
from tests.plugin.project import change, report
from tests.plugin.test_bad_input import refused

SUITE = "--hri-suite=by-hand"
ASKED = (SUITE, "--hri-mutate", "--hri-known=R3")

GUIDE = '''
"""A guide with few places for faults; it answers no greeting."""

from lamps.messages import Switched, Wish


def serve(bus, clock, lamp, patience_s):
    """Serve wishes until none has come for a while."""
    wishes = bus.subscribe(Wish)
    while (wish := wishes.wait(patience_s)) is not None:
        bus.publish(Switched(wish.level))


def serviced():
    """Nobody calls it."""
    return True
'''


@pytest.fixture
def guide(lamps: pytest.Pytester) -> pytest.Pytester:
    """The project with a smaller guide, which has no lamp to glare with."""
    allow = "pythonpath = .\nhri_allow_nc = R2: it has no lamp"
    change(lamps.path, "pytest.ini", "pythonpath = .", allow)
    (lamps.path / "lamps" / "guide.py").write_text(GUIDE, encoding="utf-8")
    return lamps


def mutation(project: pytest.Pytester) -> dict[str, Any]:
    """What the report says of mutants, without what depends on the machine."""
    written = report(project.path)
    json_schema.REPORT.validate(written)
    found: dict[str, Any] = written["mutation"]
    return found | {"wall_s": 0, "processes": 0}


def fates(found: dict[str, Any]) -> dict[str, tuple[str, set[str]]]:
    """Of each mutant, by its operator and new text, or the old one that is gone: what became of it, what failed."""
    return {
        f"{each['operator']}: {each['before'] if each['after'] == 'pass' else each['after']}": (
            each["status"],
            {oracle for run in each["runs"] for oracle in run["assertions"]},
        )
        for each in found["mutants"]
    }


@pytest.mark.slow
def test_each_fault_is_noticed_or_not_and_the_report_says_why(guide: pytest.Pytester) -> None:
    change(guide.path, "requirements.toml", "[R1]\n", '[R1]\ngroup = "light"\n')
    result = guide.runpytest_inprocess("-vv", *ASKED)
    assert result.ret == 0
    found, loop = mutation(guide), "while (wish := wishes.wait(patience_s"
    assert fates(found) == {
        f"loop left early: {loop})) is not None: ... break": ("unchanged", set()),
        "returned early: return": ("killed", {"ending"}),  # a run in which no time passes simulated nothing
        f"time or speed scaled: {loop} * 0.1)) is not None:": ("survived", set()),
        f"time or speed scaled: {loop} * 10)) is not None:": ("killed", {"ending"}),
        f"another keyword: {loop})) is None:": ("killed", {"R1"}),
        "message dropped: bus.publish(Switched(wish.level))": ("killed", {"R1"}),
        "call repeated: bus.publish(Switched(wish.level)); bus.publish(Switched(wish.level))": ("survived", set()),
        "true or false: return False": ("no coverage", set()),
    }
    score = {"mutants": 8, "killed": 4, "survived": 2, "unchanged": 1, "no_coverage": 1, "not_run": 0}
    assert found["total"] == found["suites"]["by-hand"] == score | {"percent": 50.0}
    assert found["assertions"]["R1"] == found["groups"]["light"] == {"killed": 2, "killed_only_by": 2}
    result.stdout.fnmatch_lines(
        [
            "hricdv: trying 8 mutants on 4 tests, *",
            "mutants: 50.0 % killed (4 of 8), 17 runs in *",
            "  R1 *2 *2",
            "  ending *2 *2",
            "  group light *2 *2",
            "  2 survived: a record changed, and nothing failed: an oracle is missing",
            "    lamps/guide.py:11  call repeated: bus.publish(Switched(wish.level)) ->*",
            "      by-hand-cellar-polite-*: at * `switched(level=100)` is extra",
            "  1 unchanged: no record changed: a stimulus is missing, or it is equivalent",
            "  1 no coverage: no test executes the statement",
        ]
    )
    page = (guide.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert page.count("lamps/guide.py:10") >= 5
    assert (guide.path / "lamps" / "guide.py").read_text(encoding="utf-8") == GUIDE


@pytest.mark.slow
def test_the_result_depends_on_the_seed_and_not_on_the_number_of_processes(
    guide: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for processes in (1, 3):
        monkeypatch.setattr(os, "cpu_count", lambda count=processes: count)
        guide.runpytest_inprocess(*ASKED, "--hri-mutate-faults=3", "--hri-seed=3")
        found.append(mutation(guide))
    assert found[0] == found[1]
    assert (len(found[0]["mutants"]), found[0]["generated"], found[0]["seed"]) == (3, 8, 3)


@pytest.mark.slow
def test_when_time_is_over_no_fault_is_begun_and_the_summary_says_so(
    guide: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    # Runs are so slow that the second is over before all faults are tried.
    change(guide.path, "conftest.py", "    lamp = Lamp()\n", "    lamp = Lamp()\n    __import__('time').sleep(0.3)\n")
    result = guide.runpytest_inprocess("-vv", *ASKED, "--hri-mutate-seconds=1")
    found = mutation(guide)
    assert found["end_reason"] == "seconds"
    assert 0 < found["total"]["not_run"] < 8
    result.stdout.fnmatch_lines([f"  {found['total']['not_run']} not run: time ran out *"])


@pytest.mark.slow
def test_ctrl_c_keeps_what_was_found(guide: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    say = Collection.say

    def interrupted(self: Collection, text: str) -> None:
        say(self, text)
        if "1 of 7 mutants" in text:
            raise KeyboardInterrupt

    monkeypatch.setattr(Collection, "say", interrupted)
    result = guide.runpytest_inprocess("-vv", *ASKED, no_reraise_ctrlc=True)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    found = mutation(guide)
    assert found["end_reason"] == "interrupted"
    assert sum(each["complete"] and bool(each["runs"]) for each in found["mutants"]) == 1
    # Two are tried at a time: by then the other one may have been found out, though not in all of its tests.
    not_run = found["total"]["not_run"]
    assert not_run in (5, 6)
    result.stdout.fnmatch_lines([f"  {not_run} mutants not tried: it was interrupted"])


@pytest.mark.slow
def test_a_run_that_depends_on_its_test_function_is_found_out(guide: pytest.Pytester) -> None:
    planted = "def test_lamps(hri_case, monkeypatch):\n    monkeypatch.setattr('lamps.guide.Switched', answer)"
    change(guide.path, "test_lamps.py", "def test_lamps(hri_case):", planted)
    change(
        guide.path,
        "test_lamps.py",
        '"""The host test."""',
        "import lamps.messages\n\n\ndef answer(level):\n    return lamps.messages.Answer()",
    )
    result = guide.runpytest_inprocess(*ASKED, "--hri-known=R1")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED --hri-mutate: no mutant was tried: by-hand-*: another record, where *"])


TENS = """

PARTS = 1
SHARE = 100 / PARTS


def tens(level):
    while level > 0:
        level -= 10
    return level
"""


@pytest.mark.slow
def test_what_cannot_be_imported_never_ends_or_crashes_is_noticed(
    guide: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mutating, "LEAST_RUN_S", 1)
    monkeypatch.setattr(mutating, "FACTOR", 0)
    change(
        guide.path,
        "lamps/guide.py",
        "        bus.publish(Switched(wish.level))\n",
        "        bus.publish(Switched(tens(wish.level) / PARTS))\n",
    )
    with (guide.path / "lamps" / "guide.py").open("a", encoding="utf-8") as file:
        file.write(TENS)
    guide.runpytest_inprocess(*ASKED)
    found = fates(mutation(guide))
    assert found["off by one: PARTS = (0)"] == ("killed", {"exception"})
    assert found["another operator: level += 10"] == ("killed", {"ending"})
    assert found["assignment forgotten: level -= 10"] == ("killed", {"ending"})


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (
            ["--hri-mutate", "--hri-no-cov"],
            "--hri-mutate and --hri-no-cov: which tests to try a mutant on is known from",
        ),
        (["--hri-mutate", "--hri-shard=1/2"], "--hri-mutate and --hri-shard: give one of them"),
        (["--hri-fail-under=mutants=80"], "--hri-fail-under=mutants=80: add --hri-mutate, or there are no mutants"),
        (["--hri-mutate", "--hri-mutate-tests=some"], "--hri-mutate-tests=some: expected a whole number, or all"),
        (["--hri-mutate", "--hri-mutate-seconds=0"], "--hri-mutate-seconds=0: expected at least 1"),
        (["--hri-mutate", "--hri-mutate-faults=-1"], "--hri-mutate-faults=-1: expected at least 1"),
    ],
)
def test_wrong_options_are_refused(lamps: pytest.Pytester, options: list[str], told: str) -> None:
    assert told in refused(lamps, SUITE, *options)


def test_without_the_library_it_is_said_what_to_install(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *more: None if name == "mutmut" else find(name, *more)
    )
    assert "--hri-mutate needs mutmut: pip install pytest-hricdv[mutation]" in refused(lamps, SUITE, "--hri-mutate")
