"""Adapted ranges."""

from __future__ import annotations

from statistics import fmean

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.closing.cross_entropy import SWITCHED_ON, adapted, elite_size
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.sampler import Chance, Constant, Range

RANGE = Range(0.0, 10.0, open_high=True)


def drawn(sampler: Range | Chance | Constant, elite: list[float]) -> list[float]:
    """Many values."""
    rng = make_rng("adapted")
    return [adapted(sampler, elite, rng) for _ in range(500)]


def test_values_gather_where_the_elite_is() -> None:
    assert 4.5 < fmean(drawn(RANGE, [])) < 5.5
    gathered = drawn(RANGE, [8.9, 9.0, 9.1, 9.0, 9.05])
    assert fmean(gathered) > 7.5
    assert min(gathered) < 5.5  # and no value is ruled out


def test_a_single_good_run_is_no_elite() -> None:
    assert 4.5 < fmean(drawn(RANGE, [9.0])) < 5.5


@given(st.lists(st.floats(0.0, 9.99), max_size=9), st.integers())
def test_values_are_always_in_the_declared_range(elite: list[float], seed: int) -> None:
    assert RANGE.contains(adapted(RANGE, elite, make_rng("range", seed)))


def test_what_is_declared_rare_is_switched_on_often() -> None:
    values = drawn(Chance(0.02, Range(4.0, 14.0)), [])
    on = [value for value in values if value]
    assert 0.8 * SWITCHED_ON < len(on) / len(values) < 1.2 * SWITCHED_ON
    assert min(on) >= 4.0
    assert max(on) <= 14.0
    assert set(drawn(Chance(0.0, Range(4.0, 14.0)), [])) == {0.0}


def test_a_constant_stays_what_it_is() -> None:
    assert set(drawn(Constant(3.0), [1.0] * 9)) == {3.0}


def test_there_is_an_elite_as_soon_as_there_are_runs() -> None:
    assert [elite_size(runs) for runs in (0, 1, 5, 20, 21)] == [0, 1, 1, 4, 5]
