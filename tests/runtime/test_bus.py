"""The typed bus and the record."""

from __future__ import annotations

import dataclasses
import enum
import math

import pytest

from pytest_hricdv.runtime import Bus, Kernel, MessageFault, Recorder


@dataclasses.dataclass(frozen=True)
class Ping:
    number: int


@dataclasses.dataclass(frozen=True)
class HumanReady: ...


class Colour(enum.Enum):
    RED = "red"


class Finish(enum.IntEnum):
    MATT = 1


@dataclasses.dataclass(frozen=True)
class Paint:
    colour: Colour
    finish: Finish


def make() -> tuple[Kernel, Bus, Recorder]:
    kernel, recorder = Kernel(), Recorder()
    return kernel, Bus(kernel, (Ping, HumanReady), recorder), recorder


def test_an_undeclared_message_is_refused_with_the_declared_ones() -> None:
    _, bus, _ = make()
    with pytest.raises(TypeError, match="str is not a message of this bus; declared: HumanReady, Ping"):
        bus.publish("x", "hello")
    with pytest.raises(TypeError, match="is not a message"):
        bus.subscribe(int)


def test_the_record_has_every_message_and_every_change_of_a_signal() -> None:
    _, bus, recorder = make()
    bus.publish("human", Ping(3))
    recorder.signal(0.0, "speed", 0.0)
    recorder.signal(0.5, "speed", 0.0)
    recorder.signal(1.0, "speed", 0.2)
    record = recorder.finish()
    assert [str(message).split() for message in record.messages] == [["0.000", "human", "ping", "number=3"]]
    times, values = record.signals["speed"]
    assert (list(times), list(values)) == ([0.0, 1.0], [0.0, 0.2])


@pytest.mark.parametrize(("first", "then"), [("auto", 1.0), (1.0, "auto"), (True, "auto")])
def test_a_signal_keeps_its_type(first: float | str, then: float | str) -> None:
    recorder = Recorder()
    recorder.signal(0.0, "mode", first)
    with pytest.raises(
        ValueError, match=r"signal mode is .* at 1\.500000 s, and was .* before: expected values of one"
    ):
        recorder.signal(1.5, "mode", then)


def test_a_member_of_an_enumeration_is_recorded_as_its_text_and_heard_as_it_is() -> None:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, (Paint,), recorder)
    heard = bus.subscribe(Paint)
    bus.publish("robot", Paint(Colour.RED, Finish.MATT))
    assert heard.poll() == Paint(Colour.RED, Finish.MATT)
    assert recorder.finish().messages[0].fields == {"colour": "red", "finish": "MATT"}


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_signal_that_is_not_finite_is_refused_with_name_and_time(value: float) -> None:
    with pytest.raises(ValueError, match=r"signal speed is .* at 1\.500000 s"):
        Recorder().signal(1.5, "speed", value)


LOST, LATE, DOUBLED = MessageFault("lost"), MessageFault("late", (0.5,)), MessageFault("doubled", (0.0, 0.5))


@pytest.mark.parametrize(
    ("fault", "heard_s", "recorded_s"),
    [(LOST, [], []), (LATE, [1.5], [1.5]), (DOUBLED, [1.0, 1.5], [1.0, 1.5])],
    ids=["lost", "late", "doubled"],
)
@pytest.mark.parametrize("by_code", [False, True], ids=["of the environment", "of the code under test"])
def test_a_fault_happens_to_the_next_message_of_its_topic_only(
    fault: MessageFault, heard_s: list[float], recorded_s: list[float], by_code: bool
) -> None:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, (Ping, HumanReady), recorder, lambda: by_code)
    heard: list[tuple[float, int]] = []

    def listener() -> None:
        subscription = bus.subscribe(Ping)
        while (ping := subscription.wait(10.0)) is not None:
            heard.append((kernel.now_s, ping.number))

    def talker() -> None:
        bus.disturb("ping", fault)
        kernel.sleep(1.0)
        bus.publish("talker", HumanReady())
        bus.publish("talker", Ping(1))
        kernel.sleep(1.0)
        bus.publish("talker", Ping(2))

    kernel.spawn("listener", listener)
    kernel.spawn("talker", talker)
    kernel.run(limit_s=10.0)
    assert heard == [*((time_s, 1) for time_s in heard_s), (2.0, 2)]
    events = [(message.time_s, message.topic) for message in recorder.messages]
    assert events[:2] == [(1.0, "human_ready"), (1.0, f"{fault.name} ping")]
    assert [time_s for time_s, topic in events if topic == "ping"] == [*([1.0] if by_code else recorded_s), 2.0]


def test_listeners_do_not_hear_of_disturbances_and_the_hash_does() -> None:
    class Deaf:
        def message(self, *event: object) -> None:
            raise AssertionError(event)

        signal = message

    recorder = Recorder([Deaf()])
    before = recorder.finish().sha256
    recorder.disturbance(1.0, "test", "disturb outage", {"turn": 2.0})
    (event,) = recorder.finish().messages
    assert event.is_disturbance
    assert recorder.finish().sha256 != before
    with pytest.raises(ValueError, match="disturbance 'outage': expected at least two words"):
        recorder.disturbance(1.0, "test", "outage", {})
