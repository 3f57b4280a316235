import asyncio

import pytest
from pydantic import ValidationError

from waiter.messages import INCOMING
from waiter.waiter import Settings, Waiter

FAST = Settings(speed_m_s=400.0, take_s=0.3)


async def scene(*rows):
    waiter = Waiter(asyncio.Queue(), asyncio.Queue(), FAST)
    task = asyncio.create_task(waiter.run())
    for row in rows:
        waiter.incoming.put_nowait(INCOMING.validate_python(row))
        await asyncio.sleep(0.03)
    await asyncio.sleep(0.5)
    task.cancel()
    said = []
    while not waiter.outgoing.empty():
        said.append(waiter.outgoing.get_nowait())
    return waiter, said


def test_a_dish_is_served():
    waiter, said = asyncio.run(scene(
        {"kind": "order", "table": 3, "dish": "pasta"},
        {"kind": "dish_ready", "table": 3, "weight_g": 420.0},
        {"kind": "tray_weight", "grams": 420.0},
        {"kind": "tray_weight", "grams": 2.0},
    ))
    phases = [message.phase for message in said if hasattr(message, "phase")]
    assert "serving" in phases
    assert waiter.phase == "kitchen"


def test_waving_and_a_second_order():
    _, said = asyncio.run(scene(
        {"kind": "order", "table": 1, "dish": "soup", "guests": 4},
        {"kind": "order", "table": 1, "dish": "salad"},
        {"kind": "guest_waves", "table": 2, "hand": "left"},
        {"kind": "help", "text": "glass"},
    ))
    assert {message.text for message in said if hasattr(message, "text")} >= {"one moment please"}


def test_unknown_dish():
    with pytest.raises(ValidationError):
        INCOMING.validate_python({"kind": "order", "table": 1, "dish": "cake"})
