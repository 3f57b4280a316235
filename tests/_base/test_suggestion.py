"""Suggestions for names that do not exist."""

from __future__ import annotations

from pytest_hricdv._base.message import nearest


def test_similar_names_are_suggested_the_most_similar_first() -> None:
    assert nearest("leg_redy", ["request", "leg_read", "leg_ready"]) == "; nearest: leg_ready, leg_read"


def test_where_nothing_is_similar_the_known_names_are_listed_up_to_a_limit() -> None:
    assert nearest("x", ["request", "reading"]) == "; known: request, reading"
    assert nearest("x", [f"signal_{number}" for number in range(20)]).endswith(" and 8 more")


def test_where_nothing_is_known_nothing_is_said() -> None:
    assert nearest("x", []) == ""
