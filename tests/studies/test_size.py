"""The limits that the figures of the package are held to."""

from __future__ import annotations

from studies.size import excesses


def test_what_is_over_its_limit_is_listed() -> None:
    assert list(excesses({"lines": 1200, "modules": 3}, {"lines": 1000, "modules": 3, "rooms": 1})) == [
        "lines: 1,200; at most 1,000",
        "[tool.hricdv-size]: there is no figure 'rooms'",
    ]
