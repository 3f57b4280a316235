"""What the report keeps of a run: few places of a signal, but every extreme; messages and triggers in full."""

from __future__ import annotations

import json
from array import array

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.monitor import Trigger, Verdict
from pytest_hricdv.results.timeline import SPANS, thin_signal, timeline
from pytest_hricdv.runtime import Recorder

changes = st.lists(st.tuples(st.floats(0.001, 2.0), st.integers(-5, 5).map(float)), min_size=1, max_size=4 * SPANS)


@given(changes=changes, rest_s=st.floats(0, 100))
def test_thinning_keeps_order_ends_and_extremes(changes: list[tuple[float, float]], rest_s: float) -> None:
    times, values, now_s = array("d"), array("d"), 0.0
    for step_s, value in changes:
        now_s += step_s
        times.append(now_s)
        values.append(value)
    kept = list(thin_signal(times, values, now_s + rest_s))
    assert kept == sorted(set(kept))
    assert len(kept) <= 2 * SPANS + 2
    assert (kept[0], kept[-1]) == (0, len(times) - 1)
    assert min(values[n] for n in kept) == min(values)
    assert max(values[n] for n in kept) == max(values)


def test_a_timeline_is_plain_text_by_the_second() -> None:
    recorder = Recorder()
    recorder.message(0.5, "ro\tbot", "state", {"name": "Wait \t é", "turn": 1})
    recorder.signal(0.0, "speed", 0.123456)
    recorder.signal(1 / 3, "speed", 2.0)
    recorder.signal(0.0, "mode", "manual \t")
    recorder.signal(1 / 3, "mode", "auto")
    history = (Trigger(0.5, 1.25, "passed"), Trigger(1.0, 2.0, "failed"), Trigger(3.0, 4.0, "pending"))
    verdicts = [
        Verdict(
            requirement="R1",
            verdict="Failed",
            triggers=3,
            passes=1,
            failures=1,
            untriggered=0,
            pending=1,
            violations=(),
            margin=None,
            margin_time_s=None,
            history=history,
        )
    ]
    made = timeline(recorder.finish(), verdicts, 4.0)
    assert made.signals == {"speed": "0 0.1235 0.333 2"}
    assert made.texts == {"mode": ((0.0, "manual \t"), (0.333, "auto"))}
    assert made.triggers == {"R1": "0.5-1.25 1-2! 3-4?"}
    time_s, sender, topic, fields = made.messages[0].split("\t")
    assert (time_s, sender, topic) == ("0.5", "ro bot", "state")
    assert json.loads(fields) == {"name": "Wait \t é", "turn": 1}
