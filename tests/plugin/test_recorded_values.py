"""What worlds and controllers record: numbers of any library, and located errors for what is not as declared."""

from __future__ import annotations

import pytest

from tests.plugin import project

SIGNAL = 'run.recorder.signal(run.kernel.now_s, "lamp_level", level)'
SWITCHED = "bus.publish(Switched(level))"
NUMPY = '__import__("numpy")'
RUN = ("--hri-suite=bdi-random", "--hri-tests=2", "-p", "no:cacheprovider", "-p", "no:xdist")


@pytest.mark.slow
def test_a_bool_of_numpy_is_a_bool(lamps: pytest.Pytester) -> None:
    project.change(
        lamps.path,
        "conftest.py",
        '{"lamp_level": Signal(float, "%")}',
        '{"lamp_level": Signal(float, "%"), "lit": bool}',
    )
    lit = f'run.recorder.signal(run.kernel.now_s, "lit", {NUMPY}.bool_(level > 0))'
    project.change(lamps.path, "conftest.py", SIGNAL, f"{SIGNAL}\n            {lit}")
    lamps.runpytest_subprocess(*RUN).assert_outcomes(passed=2, deselected=1)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("None", "signal lamp_level is None at 0.000000 s: expected a number, a bool or a string"),
        ("[level]", "signal lamp_level is [0.0] at 0.000000 s: expected a number, a bool or a string"),
        ("str(level)", "signal lamp_level is '0.0' at 0.000000 s: the testbench declares it as float"),
        ("level > 0", "signal lamp_level is False at 0.000000 s: the testbench declares it as float"),
    ],
)
def test_a_signal_that_is_not_as_declared_is_an_error_with_its_name(
    lamps: pytest.Pytester, value: str, said: str
) -> None:
    project.change(lamps.path, "conftest.py", SIGNAL, SIGNAL.replace(" level)", f" {value})"))
    result = lamps.runpytest(*RUN)
    result.assert_outcomes(failed=2, deselected=1)
    assert f"TypeError: {said}" in result.stdout.str()


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("None", "switched.level is None at "),
        ("'high'", "switched.level is 'high' at "),
    ],
)
def test_a_field_that_is_not_as_declared_is_an_error_with_its_name(
    lamps: pytest.Pytester, value: str, said: str
) -> None:
    project.change(lamps.path, "lamps/guide.py", SWITCHED, SWITCHED.replace("level", value))
    result = lamps.runpytest(*RUN)
    assert said in result.stdout.str()
    assert "lamps/guide.py:21: TypeError" in result.stdout.str()


def test_a_message_in_a_message_and_a_list_in_it_are_fields_that_requirements_compare(lamps: pytest.Pytester) -> None:
    said = '    """The guide says that the lamp is as it was asked for."""\n\n    level: float\n'
    place = "@dataclass(frozen=True)\nclass Place:\n    room: str\n    lamps: list[str]\n\n\n"
    project.change(lamps.path, "lamps/messages.py", said, f"{said}    where: Place\n")
    head = "@dataclass(frozen=True)\nclass Switched:"
    project.change(lamps.path, "lamps/messages.py", head, f"{place}{head}")
    project.change(lamps.path, "lamps/guide.py", "Switched, Wish", "Place, Switched, Wish")
    project.change(lamps.path, "lamps/guide.py", SWITCHED, "bus.publish(Switched(level, Place('hall', ['left'])))")
    project.change(lamps.path, "requirements.toml", "[R1]", "\n".join((
        "[R8]", 'title = "The left lamp of the hall"',
        """formula = 'always(on(switched) -> switched.where.room == "hall" & switched.where.lamps.length == 1)'""",
        "", "[R1]",
    )))  # fmt: skip
    lamps.runpytest(*RUN).assert_outcomes(passed=2, deselected=1)
    verdicts = {test["requirements"]["R8"]["verdict"] for test in project.report(lamps.path)["tests"]}
    assert "Passed" in verdicts
