"""What a session says of messages that its requirements do not see, as others came at the same instant."""

from __future__ import annotations

import pytest

from tests.plugin.project import change, report


def test_a_message_that_is_followed_at_the_same_instant_is_not_seen_and_that_is_told(lamps: pytest.Pytester) -> None:
    said = "        bus.publish(Switched(level))\n"
    change(lamps.path, "lamps/guide.py", said, f"{said}        bus.publish(Switched(-1.0))\n")
    change(lamps.path, "requirements.toml", "[R1]", "\n".join((
        "[R9]", 'title = "No lamp is at 10 %"',
        'formula = "always(on(switched) & switched.level == 10 -> lamp_level < 0)"', "", "[R1]",
    )))  # fmt: skip
    result = lamps.runpytest_inprocess("-v", "--hri-suite=by-hand", "--hri-allow-nc=R9 in by-hand")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["  warning               R9 ignored * 'switched' messages: only the last message*"])
    assert report(lamps.path)["suites"][0]["requirements"]["R9"]["masked_messages"]["switched"] > 0
