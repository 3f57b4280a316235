"""Hypothesis strategies for the declared ranges, for property tests of a project::

    from hypothesis import given
    from pytest_hricdv.strategies import concrete_tests

    @given(concrete_tests(RANGES, ["tell leg", "receivesignal", "bored"]))
    def test_the_person_always_ends(test):
        ...

The plugin itself does not need Hypothesis. Suites are not drawn with it: its random stream changes with its version,
and the seed of a suite must mean the same tests for years.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

try:
    from hypothesis import strategies as st
except ImportError as error:
    raise ImportError("pytest_hricdv.strategies needs Hypothesis: pip install hypothesis") from error

from pytest_hricdv._base.message import nearest
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import SEED_LIMIT
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Constant, Sampler, Sometimes, Uniform

__all__ = ["concrete_tests", "parameters", "values"]

NAME = "property"


def values(sampler: Sampler) -> st.SearchStrategy[float]:
    """All values of a range, in its unit; of a chance also 0.0, to which values shrink.

    Raises:
        GenerateError: a custom sampler, whose bounds are not known.
    """
    if isinstance(sampler, Constant):
        return st.just(float(sampler.value))
    if isinstance(sampler, Uniform):
        return st.floats(sampler.low, sampler.high, exclude_max=sampler.open_high)
    if isinstance(sampler, Sometimes):
        # Hypothesis shrinks to the alternative on the left. A probability of 0 means that the other one never happens.
        return st.just(0.0) | values(sampler.then) if sampler.probability > 0.0 else st.just(0.0)
    raise GenerateError(f"no strategy for {sampler!r}; expected a Uniform, Sometimes or Constant")


def parameters(samplers: Mapping[str, Sampler]) -> st.SearchStrategy[dict[str, float]]:
    """Values of all parameters, by name."""
    return st.fixed_dictionaries({name: values(sampler) for name, sampler in samplers.items()})


def concrete_tests(
    ranges: Concretization, lines: Sequence[str] | None = None, *, max_actions: int = 20
) -> st.SearchStrategy[ConcreteTest]:
    """Concrete tests with parameters from the declared ranges and any seed, which decides about sensor errors.

    Args:
        ranges: the testbench's ranges.
        lines: the commands of the test; None: any commands.
        max_actions: the largest number of actions if `lines` is None.

    Raises:
        GenerateError: a command without declared ranges.
    """
    for line in lines or ():
        if line not in ranges.commands:
            raise GenerateError(f"no ranges are declared for command {line!r}{nearest(line, ranges.commands)}")
    actions = {
        line: st.builds(ConcreteAction, st.just(line), parameters(samplers))
        for line, samplers in ranges.commands.items()
    }
    drawn: st.SearchStrategy[tuple[ConcreteAction, ...]]
    if lines is None:
        drawn = st.lists(st.one_of(list(actions.values())), max_size=max_actions).map(tuple)
    else:
        drawn = st.tuples(*(actions[line] for line in lines))
    return st.builds(
        ConcreteTest,
        id=st.just(NAME),
        suite=st.just(NAME),
        seed=st.integers(0, SEED_LIMIT - 1),
        actions=drawn,
        run=parameters(ranges.run),
    )
