"""Disturbances through the plugin: lines of a test that the testbench's handlers or the bus apply."""

from __future__ import annotations

import pytest

from tests.plugin.project import change, report

DECLARED = """code=("lamps",),
        disturbances={
            "brownout": Disturbance({"level": Uniform(1.0, 2.0, "%")}, lambda lamp, given: lamp.set(given["level"])),
            "lost_wish": Drop("wish"),
            "late_wish": Delay("wish", delay_s=Uniform(1.5, 2.0, "s")),
            "doubled_wish": Duplicate("wish", delay_s=Uniform(0.5, 0.6, "s")),
            "late_switched": Delay("switched", delay_s=Uniform(1.5, 2.0, "s")),
        },"""


@pytest.fixture
def disturbed(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project with disturbances."""
    change(lamps.path, "conftest.py", 'code=("lamps",),', DECLARED)
    change(lamps.path, "conftest.py", "Model, Testbench, Uniform", "Model, Testbench, Uniform\n    " + IMPORT)
    change(
        lamps.path, "conftest.py", "    lamp.set(0.0)\n", "    lamp.set(0.0)\n    run.set_disturbance_target(lamp)\n"
    )
    change(
        lamps.path,
        "conftest.py",
        "in run.actions():\n",
        "in run.actions():\n            enacted.append(action.command)\n",
    )
    change(lamps.path, "conftest.py", "    lamp = Lamp()\n", "    lamp, enacted = Lamp(), []\n")
    change(lamps.path, "conftest.py", 'outcomes=("released",)', 'outcomes=("released", *enacted)')
    return lamps


IMPORT = "from pytest_hricdv.testbench import Disturbance, Duplicate, Delay, Drop"

OWN = """
def events(result):
    return [(each.topic, each.sender) for each in result.record.messages]


def time_of(result, topic):
    (time_s,) = [each.time_s for each in result.record.messages if each.topic == topic]
    return time_s


def test_a_handler_gets_the_world_and_its_parameters_when_the_line_begins(hri_run):
    result = hri_run(["enter cellar", "disturb brownout", "greet"], level=1.5, pause_s=0.5)
    times, levels = result.record.signals["lamp_level"]
    assert (list(times), list(levels)) == ([0.0, 0.5], [0.0, 1.5])
    assert result.action_times_s == (0.0, 0.5, 0.5)
    event, greeting, *_ = result.record.messages
    assert str(event).split() == ["0.500", "test", "disturb", "brownout", "level=1.5"]
    assert greeting.time_s == 1.0


def test_a_lost_message_asks_for_no_answer(hri_run):
    result = hri_run(["enter cellar", "disturb lost_wish", "set_lamp level = 100"])
    assert events(result) == [("disturb lost_wish", "test"), ("lost wish", "visitor")]
    assert result.verdict("R1").verdict == "NC" and not result.failed


def test_only_the_next_message_is_lost(hri_run):
    result = hri_run(["disturb lost_wish", "set_lamp level = 0", "set_lamp level = 0"])
    assert result.verdict("R1").passes == 1


def test_each_of_several_disturbances_has_its_own_message(hri_run):
    result = hri_run(["disturb lost_wish", "disturb lost_wish", *["set_lamp level = 0"] * 3])
    assert result.verdict("R1").passes == 1


def test_a_late_message_is_recorded_when_it_comes(hri_run):
    result = hri_run(["disturb late_wish", "set_lamp level = 0"], delay_s=1.5, pause_s=0.5)
    assert (time_of(result, "late wish"), time_of(result, "wish")) == (0.5, 2.0)
    assert result.verdict("R1").passes == 1


def test_a_doubled_message_is_recorded_twice(hri_run):
    result = hri_run(["disturb doubled_wish", "set_lamp level = 0"])
    assert [topic for topic, _ in events(result)].count("wish") == 2
    assert result.verdict("R1").passes == 2


def test_a_message_of_the_code_under_test_is_recorded_when_it_is_said(hri_run):
    result = hri_run(["disturb late_switched", "set_lamp level = 0"])
    assert time_of(result, "switched") == time_of(result, "late switched")
    assert result.verdict("R1").passes == 1


def test_the_person_does_not_get_its_line(hri_run):
    result = hri_run(["enter cellar", "disturb brownout", "greet"])
    assert result.outcome.outcomes == ("released", "enter cellar", "greet")


def test_it_runs_again_to_the_bit_and_another_parameter_is_another_run(hri_run):
    first = hri_run(["disturb brownout"])
    assert hri_run(first.test).record.sha256 == first.record.sha256
    assert hri_run(["disturb brownout"], level=2.0).record.sha256 != first.record.sha256
"""


def test_what_a_disturbance_does(disturbed: pytest.Pytester) -> None:
    (disturbed.path / "test_own.py").write_text(OWN, encoding="utf-8")
    disturbed.runpytest_inprocess("test_own.py").assert_outcomes(passed=9)


def test_a_handler_that_only_makes_a_coroutine_fails_its_test(disturbed: pytest.Pytester) -> None:
    change(disturbed.path, "conftest.py", 'lambda lamp, given: lamp.set(given["level"])', "later")
    with (disturbed.path / "conftest.py").open("a", encoding="utf-8") as conftest:
        conftest.write("\n\nasync def later(lamp, given):\n    lamp.set(1.0)\n")
    (disturbed.path / "mine.txt").write_text("\n".join(LINES) + "\n", encoding="utf-8")
    result = disturbed.runpytest_inprocess("--hri-suite=mine.txt", "--hri-diagnose=0")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*conftest.py:*: later returned a coroutine, of which nothing has run*"])


@pytest.mark.slow
def test_no_published_method_draws_one(lamps: pytest.Pytester, request: pytest.FixtureRequest) -> None:
    options = ["--hri-suite=bdi-random,by-hand,pseudorandom", "--hri-tests=2"]
    lamps.runpytest_inprocess(*options)
    before = report(lamps.path)["tests"]
    request.getfixturevalue("disturbed").runpytest_inprocess(*options)
    after = report(lamps.path)["tests"]
    for part in ("id", "concrete", "requirements", "record_sha256"):
        assert [each[part] for each in after] == [each[part] for each in before]


LINES = ["enter hall", "disturb brownout", "set_lamp level = 10", "set_lamp level = 100"]


def test_a_test_of_a_file_is_run_exported_replayed_and_shrunk(disturbed: pytest.Pytester) -> None:
    (disturbed.path / "mine.txt").write_text("\n".join(LINES) + "\n", encoding="utf-8")
    strict = ["--hri-strict", "--hri-shrink", "--hri-export=out"]
    disturbed.runpytest_inprocess("--hri-suite=mine.txt", *strict).assert_outcomes(failed=1)
    (test,) = report(disturbed.path)["tests"]
    assert test["abstract"] == LINES
    (level,) = test["concrete"]["actions"][1]["parameters"].values()
    assert 1.0 <= level <= 2.0
    assert any("test\tdisturb brownout\t" in each for each in test["timeline"]["messages"])
    assert test["shrunk"]["R2"]["abstract"] == ["set_lamp level = 100"]
    assert "disturb brownout\n" in (disturbed.path / "out" / "mine.txt").read_text(encoding="utf-8")
    again = disturbed.runpytest_inprocess(f"--hri-replay={test['replay']}")
    again.stdout.fnmatch_lines([f"replay of {test['id']}: the same run, bit for bit"])


BAD = [
    ('"lost_wish": Drop("wish")', '"lost_wish": Drop("wih")', "disturbance 'lost_wish': topic 'wih' is not a message"),
    ('"lost_wish": Drop("wish")', '"lost wish": Drop("wish")', "disturbance 'lost wish': expected a name of one word"),
    ('"lost_wish": Drop("wish")', '"lost_wish": "wish"', "'wish'; expected a Disturbance, Delay, Drop or Duplicate"),
    ("Uniform(1.5, 2.0", "Uniform(-1.5, 2.0", "expected a Uniform or Constant of at least 0 s"),
    (', lambda lamp, given: lamp.set(given["level"])', "", "disturbance 'brownout': handler is None; expected a func"),
    (
        'Uniform(1.0, 2.0, "%")',
        "1.0",
        "'disturb brownout': parameter 'level' is 1.0; expected a Uniform, Sometimes",
    ),
    ('"leave": {},', '"leave": {}, "disturb lost_wish": {},', "has the command 'disturb lost_wish', too; rename one"),
    (
        "disturbances={",
        'state=StateField("wish.level"), disturbances={',
        "state: name is 'wish.level', which is not a string fi",
    ),
    (
        "disturbances={",
        'state=StateField(transitions=(("on", "off"),)), disturbances={',
        "state: transitions are given, but no name: expected",
    ),
]


@pytest.mark.parametrize(("old", "new", "told"), BAD, ids=[told[:30] for *_, told in BAD])
def test_a_wrong_declaration_is_refused_before_the_first_test(
    disturbed: pytest.Pytester, old: str, new: str, told: str
) -> None:
    text = (disturbed.path / "conftest.py").read_text(encoding="utf-8")
    (disturbed.path / "conftest.py").write_text(text.replace(old, new, 1), encoding="utf-8")
    result = disturbed.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    (line,) = [line for line in result.stderr.lines if told in line]
    assert "conftest.py" in line


def test_an_unknown_line_is_refused_with_the_known_ones(disturbed: pytest.Pytester) -> None:
    (disturbed.path / "mine.txt").write_text("enter hall\ndisturb brownin\n", encoding="utf-8")
    result = disturbed.runpytest_inprocess("--hri-suite=mine.txt")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    told = result.stderr.str()
    assert "'disturb brownin'" in told
    assert "disturb brownout" in told


def test_a_run_that_hands_no_world_over_is_told_when_the_line_begins(disturbed: pytest.Pytester) -> None:
    change(disturbed.path, "conftest.py", "    run.set_disturbance_target(lamp)\n", "")
    (disturbed.path / "mine.txt").write_text("enter hall\ndisturb brownout\n", encoding="utf-8")
    result = disturbed.runpytest_inprocess("--hri-suite=mine.txt")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert (
        "no world to disturb; the testbench's run has to call run.set_disturbance_target(world)" in result.stdout.str()
    )
