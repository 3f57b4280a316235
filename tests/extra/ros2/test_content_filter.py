"""Filters of the content of topics, in the language of DDS."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pytest_hricdv.extra.ros2.content_filter import content_filter
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import Reading, node, reading, run

_MESSAGE = SimpleNamespace(
    data="Hello World: 10",
    count=3,
    android=4,
    near=True,
    header=SimpleNamespace(frame_id="it's"),
    points=[SimpleNamespace(x=2.5)],
)


@pytest.mark.parametrize(
    ("expression", "parameters", "passes"),
    [
        ("count = 3", (), True),
        ("count <> 3", (), False),
        ("count > %0 AND count <= %1", ("2", "3"), True),
        ("data = %0", ("'Hello World: 10'",), True),
        ("data LIKE 'Hello%'", (), True),
        ("data LIKE '%:_1_'", (), True),
        ("data like 'hello%'", (), False),
        ("data MATCH 'Hello.*[0-9]+'", (), True),
        ("NOT (count = 1 OR count = 3)", (), False),
        ("count = 1 OR count = 3 AND near = FALSE", (), False),
        ("(count = 1 OR count = 3) AND near = TRUE", (), True),
        ("count BETWEEN 1 AND 3", (), True),
        ("count NOT BETWEEN %0 AND %1", ("1", "2"), True),
        (r"header.frame_id = 'it\'s'", (), True),
        ("points[0].x >= 2.5", (), True),
        ("points[0].x < -1e3", (), False),
        ("3 = count", (), True),
        ("android = 4", (), True),
    ],
)
def test_a_message_passes_or_not(expression: str, parameters: tuple[str, ...], passes: bool) -> None:
    assert content_filter(expression, parameters)(_MESSAGE) is passes


def test_a_subscription_takes_what_passes_its_filter() -> None:
    heard = []

    def robot(kernel: Kernel) -> None:
        publisher = Publisher(node("scanner"), Reading, "/scan", Profile())
        subscription = TopicSubscription(node("arm"), Reading, "/scan", Profile(), ("_range > %0", ["1"]))
        assert subscription.is_cft_enabled()

        def taken() -> None:
            for value in (1.0, 2.0):
                publisher.publish(reading(value))
            while (message := subscription.take_message(Reading, False)) is not None:
                heard.append(message[0]._range)

        taken()
        subscription.set_content_filter("_range > %0", ["2"])
        taken()
        subscription.set_content_filter("", [])
        taken()
        assert not subscription.is_cft_enabled()
        with pytest.raises(RCLError, match="content filter is not set"):
            subscription.get_content_filter()

    run(robot)
    assert heard == [2.0, 1.0, 2.0]
