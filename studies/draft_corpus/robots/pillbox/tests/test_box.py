import asyncio

from pillbox.box import PillBox
from pillbox.models import Cancel, Dose, Drawer, Scan, Urgency


async def scene(*messages):
    inbox, outbox = asyncio.Queue(), asyncio.Queue()
    box = PillBox(inbox, outbox, travel_s=0.01)
    task = asyncio.create_task(box.run())
    for message in messages:
        inbox.put_nowait(message)
        await asyncio.sleep(0.05)
    task.cancel()
    return box


def test_the_dose_is_handed_over():
    box = asyncio.run(scene(Dose(patient="p7", pills=2), Scan(wristband="p7"), Drawer(position="shut")))
    assert box.state == "stowed"


def test_wrong_patient():
    wrong = [Scan(wristband="p1")] * 3
    box = asyncio.run(scene(Dose(patient="p7", pills=1, urgency=Urgency.NOW), *wrong))
    assert box.state == "stowed"


def test_cancel():
    box = asyncio.run(scene(Dose(patient="p7", pills=1), Cancel(reason="asleep")))
    assert box.state == "stowed"
