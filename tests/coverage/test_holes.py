"""Holes: groups of bins that no test hit."""

from __future__ import annotations

from itertools import product

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.gaps import MAX_PROJECTIONS, Hole, holes

NAMES = ("place", "mood", "end")
BINS = tuple(product(("hall", "cellar"), ("glad", "sad", "tired"), ("done", "left")))


def test_a_value_that_was_never_there_is_one_hole() -> None:
    missing = [bin_ for bin_ in BINS if bin_[1] == "tired"]
    assert holes(NAMES, BINS, missing) == (Hole((("mood", "tired"),), 4),)


def test_larger_ones_come_first_and_share_no_bin() -> None:
    missing = [bin_ for bin_ in BINS if bin_[1] == "tired" or bin_ == ("hall", "glad", "left")]
    assert holes(NAMES, BINS, missing) == (
        Hole((("mood", "tired"),), 4),
        Hole((("place", "hall"), ("mood", "glad"), ("end", "left")), 1),
    )


def test_of_a_huge_product_each_bin_is_one() -> None:
    bins = [(str(number), "a") for number in range(MAX_PROJECTIONS)]
    assert holes(("n", "letter"), bins, bins[:2]) == tuple(Hole((("n", n), ("letter", "a")), 1) for n in "01")


@given(st.sets(st.sampled_from(BINS)), st.sets(st.sampled_from(BINS)))
def test_they_have_each_missing_bin_and_no_other(possible: set[tuple[str, ...]], hit: set[tuple[str, ...]]) -> None:
    missing = sorted(possible - hit)
    largest_first = holes(NAMES, sorted(possible), missing)
    within = {
        bin_
        for bin_ in possible
        for hole in largest_first
        if all(bin_[NAMES.index(name)] == value for name, value in hole.values)
    }
    assert within == set(missing)
    assert sum(hole.bins for hole in largest_first) == len(missing)
    assert [hole.bins for hole in largest_first] == sorted((hole.bins for hole in largest_first), reverse=True)
