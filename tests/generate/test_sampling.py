"""Corner-biased sampling, units, and ranges as Hypothesis strategies."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize, expand
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.sampler import Constant, Sampler, Sometimes, Uniform, corners, uniform
from pytest_hricdv.strategies import concrete_tests, values
from tests.generate.table import COMMANDS, CONCRETIZATION, ROOT

TEST = AbstractTest(id="t", suite="s", target="a", beliefs=(), lines=COMMANDS, seed=5)
BOUNDS = st.tuples(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
RANGES = st.builds(lambda at, half: Uniform(at[0], at[0] + at[1], "m", open_high=half), BOUNDS, st.booleans())
SAMPLERS = RANGES | st.builds(Constant, st.floats(-9, 9)) | st.builds(Sometimes, st.floats(0, 1), RANGES)


def _is_inside(value: float, sampler: Sampler) -> bool:
    if isinstance(sampler, Sometimes):
        return value == 0.0 or (sampler.probability > 0.0 and _is_inside(value, sampler.then))
    if isinstance(sampler, Uniform):
        return sampler.contains(value)
    return isinstance(sampler, Constant) and value == sampler.value


@given(SAMPLERS, st.integers(0, 999))
def test_samplings_stay_in_the_range_and_depend_on_the_random_stream_only(sampler: Sampler, seed: int) -> None:
    for sampling in (uniform, corners):
        drawn = [sampling(sampler, make_rng("x", seed)) for _ in range(2)]
        assert drawn[0] == drawn[1]
        assert _is_inside(drawn[0], sampler)
    assert all(_is_inside(value, sampler) for value in sampler.corners())


def test_another_sampling_gives_other_ids_and_seeds() -> None:
    (plain,), (cornered,) = expand([TEST], 1), expand([TEST], 1, "corners")
    assert plain == TEST
    assert cornered.id == "t-corners"
    assert cornered.seed != plain.seed
    assert [test.id for test in expand([TEST], 2, "corners")] == ["t-corners", "t-corners-k1"]
    concrete = concretize(cornered, CONCRETIZATION, sampling="corners")
    assert concrete == concretize(cornered, CONCRETIZATION, sampling="corners")
    assert concrete != concretize(cornered, CONCRETIZATION)
    with pytest.raises(GenerateError, match="no sampling 'corner'; nearest: corners"):
        expand([TEST], 1, "corner")


def test_a_concrete_test_is_shown_with_units() -> None:
    shown = CONCRETIZATION.describe(concretize(TEST, CONCRETIZATION))
    assert len(shown) == len(COMMANDS) + 1
    lines = dict(zip([*COMMANDS, "run"], shown, strict=True))
    assert lines["bored"] == "bored"
    assert lines["receivesignal"] == "receivesignal: patience_s 60 s"
    assert lines["set_param gaze = 0"].endswith(" deg")
    assert lines["set_param pressure = 1"].endswith(" N")
    assert lines["run"].startswith("run: sensing_timeout_s ")
    unknown = replace(concretize(TEST, CONCRETIZATION), run={"other": 2.5})
    assert CONCRETIZATION.describe(unknown)[-1] == "run: other 2.5"


@given(concrete_tests(CONCRETIZATION))
def test_drawn_tests_can_be_run_and_lie_in_their_ranges(test: ConcreteTest) -> None:
    assert ConcreteTest.from_json(test.to_json()) == test
    for action in test.actions:
        samplers = CONCRETIZATION.commands[action.command]
        assert action.parameters.keys() == samplers.keys()
        assert all(_is_inside(value, samplers[name]) for name, value in action.parameters.items())
    assert test.run.keys() == CONCRETIZATION.run.keys()


class Custom(Sampler):
    """A custom sampler."""

    def sample(self, random: Random) -> float:
        """Always the same."""
        return 1.0


def test_strategies_for_unknown_commands_and_samplers_are_errors() -> None:
    with pytest.raises(GenerateError, match="no ranges are declared for command 'tell legs'; nearest: tell leg"):
        concrete_tests(CONCRETIZATION, ["tell legs"])
    with pytest.raises(GenerateError, match="no strategy for"):
        values(Custom())


def test_the_plugin_loads_without_hypothesis() -> None:
    code = (
        "import sys; sys.modules['hypothesis'] = None; import pytest_hricdv.testbench, pytest_hricdv.session.suites\n"
    )
    code += "try:\n    import pytest_hricdv.strategies\nexcept ImportError as error:\n    print(error)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "pytest_hricdv.strategies needs Hypothesis: pip install hypothesis\n"
