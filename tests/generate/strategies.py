"""Hypothesis strategies: words, commands and abstract tests."""

from __future__ import annotations

from hypothesis import strategies as st

from pytest_hricdv.generate.abstract import AbstractTest

words = st.from_regex(r"[a-z][A-Za-z0-9_]{0,8}", fullmatch=True)
values = words | st.integers(-99, 99).map(str) | st.sampled_from(["0.5", "-1.25", "2e-3"])
commands = (
    words
    | st.tuples(words, values).map(lambda parts: "{} {}".format(*parts))
    | st.tuples(words, values, values).map(lambda parts: "{} {} = {}".format(*parts))
)
phrases = st.lists(st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1), max_size=4).map(" ".join)
chosen = st.dictionaries(words, st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=3)
abstract_tests = st.builds(
    lambda values, **fields: AbstractTest(
        **fields, values={number: each for number, each in values.items() if number <= len(fields["lines"])}
    ),
    values=st.dictionaries(st.integers(0, 5), chosen, max_size=2),
    id=st.from_regex(r"[A-Za-z0-9_-]{1,20}", fullmatch=True),
    suite=st.from_regex(r"[A-Za-z0-9_-]{1,20}", fullmatch=True),
    target=phrases.filter(bool),
    beliefs=st.lists(words, max_size=4).map(tuple),
    lines=st.lists(commands, max_size=5).map(tuple),
    plans=st.dictionaries(words, st.lists(words, max_size=3).map(tuple), max_size=2),
    seed=st.integers(0, 2**63 - 1),
    name=phrases,
)
