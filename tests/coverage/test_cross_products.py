"""Cross products: what is a bin, what is ruled out, and what a suite hit of them."""

from __future__ import annotations

import doctest
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv import testbench
from pytest_hricdv.coverage import cross_product
from pytest_hricdv.coverage.closure import cross_closure, declare
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.cross_product import Bin, CheckedHits, CrossProduct, Proof
from pytest_hricdv.coverage.suite_coverage import RunCoverage

KINDS = {"reading": ("1", "0", "none"), "outcome": ("kept", "given")}


def test_a_hit_is_a_bin_that_is_not_ruled_out() -> None:
    cross = CrossProduct(KINDS, {("none", "*"): "nothing was read", ("0", "given"): "forbidden by R2"})
    assert len(cross.bins()) == 6
    assert cross.impossible_bins.keys() == {("none", "kept"), ("none", "given"), ("0", "given")}
    good = [("1", "given"), ("1", "given"), ("0", "kept")]
    assert cross.check(good, {}) == CheckedHits((("0", "kept"), ("1", "given"), ("1", "given")), ())
    impossible = cross.check([("0", "given"), ("0", "kept"), ("0", "given")], {})
    assert impossible.bins == (("0", "kept"),)
    assert impossible.faults == ("0 x given was hit but is declared impossible: forbidden by R2",)
    for odd in (("2", "given"), ("1",), ("1", "given", "given")):
        assert cross.check([odd], {}) == CheckedHits((), (f"{odd} is not a bin; coordinates are reading, outcome",))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (({},), "expected at least one coordinate"),
        (({"empty": ()},), r"'empty' has \(\); expected a tuple of values"),
        (({"letters": "ab"},), "'letters' has 'ab'; expected a tuple of values"),
        (({"twice": ("a", "a")},), "'twice' has a value twice"),
        (({"star": ("*",)},), "'star' has a value twice, or one named"),
        (({str(n): ("a", "b") for n in range(17)},), "more than 100000 bins"),
        ((KINDS, {("1", "lost"): "?"}), "declared impossible but is not a bin"),
        ((KINDS, {("1",): "?"}), "declared impossible but is not a bin"),
        ((KINDS, {}, {("*", "lost"): "?"}), "declared illegal but is not a bin"),
    ],
)
def test_a_product_that_makes_no_sense_is_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(CoverageError, match=message):
        CrossProduct(*arguments)


hits = st.lists(st.lists(st.sampled_from(CrossProduct(KINDS).bins()), max_size=4), max_size=5)


@given(hits)
def test_every_bin_is_hit_missing_impossible_or_illegal(runs: list[list[Bin]]) -> None:
    product = CrossProduct(KINDS, illegal={("0", "given"): "forbidden"})
    declared = {"turn": declare(product, Proof(), {("none", "given"): "the model never does"})}
    covered = cross_closure(declared, [RunCoverage("t", None, {}, cross={"turn": tuple(run)}) for run in runs])
    turn = covered.products["turn"]
    assert turn.hit + len(turn.missing) == covered.possible == turn.bins - turn.impossible - turn.illegal
    assert turn.bins == 6
    assert turn.illegal == 1
    seen = {hit for run in runs for hit in run}
    assert turn.impossible == (("none", "given") not in seen)
    assert {hit.bin for hit in turn.hits} == seen
    assert sum(hit.hits for hit in turn.hits) == sum(map(len, runs))
    assert all(hit.tests <= hit.hits for hit in turn.hits)


@pytest.mark.parametrize("module", [cross_product, testbench])
def test_the_examples_of_the_documentation_hold(module: ModuleType) -> None:
    results = doctest.testmod(module)
    assert results.attempted >= 2
    assert not results.failed
