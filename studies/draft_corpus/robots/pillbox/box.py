"""A pill box on wheels: one dose at a time, handed to the patient whose wristband was scanned."""

import asyncio

from transitions import Machine

from .models import GRACE, Cancel, Dose, Drawer, Event, Scan, Urgency

STATES = ["stowed", "travelling", "identifying", "unlocked", "returning"]
TRANSITIONS = [
    ["dispatch", "stowed", "travelling"],
    ["arrive", "travelling", "identifying"],
    ["accept", "identifying", "unlocked"],
    ["finish", ["identifying", "unlocked"], "returning"],
    ["abort", ["travelling", "identifying"], "returning"],
    ["dock", "returning", "stowed"],
]


class PillBox:
    def __init__(self, inbox: asyncio.Queue, outbox: asyncio.Queue, travel_s: float = 5.0):
        self.inbox = inbox
        self.outbox = outbox
        self.travel_s = travel_s
        self.dose: Dose | None = None
        self.attempts = 0
        self.machine = Machine(self, states=STATES, transitions=TRANSITIONS, initial="stowed", after_state_change="tell")

    def tell(self) -> None:
        self.outbox.put_nowait(Event(name="state", detail=self.state))

    async def run(self) -> None:
        while True:
            message = await self.inbox.get()
            match message:
                case Dose():
                    await self.on_dose(message)
                case Scan(wristband=band):
                    self.on_scan(band)
                case Drawer(position="shut"):
                    if self.state == "unlocked":
                        await self.go_back()
                case Cancel():
                    if self.state in ("travelling", "identifying"):
                        self.abort()
                        await self.home()

    async def on_dose(self, dose: Dose) -> None:
        if self.state != "stowed":
            await self.outbox.put(Event(name="busy"))
            return
        self.dose, self.attempts = dose, 0
        self.dispatch()
        hurry = 0.5 if dose.urgency is Urgency.NOW else 1.0
        await asyncio.sleep(self.travel_s * hurry)
        self.arrive()
        await self.outbox.put(Event(name="please scan", detail=dose.patient))

    def on_scan(self, band: str) -> None:
        if self.state != "identifying":
            return
        if band == self.dose.patient:
            self.accept()
            asyncio.get_running_loop().call_later(GRACE.total_seconds(), self.remind)
            return
        self.attempts += 1
        self.outbox.put_nowait(Event(name="wrong patient"))
        if self.attempts >= 3:
            self.finish()
            asyncio.ensure_future(self.home())

    def remind(self) -> None:
        if self.state == "unlocked":
            self.outbox.put_nowait(Event(name="please close the drawer"))

    async def go_back(self) -> None:
        self.finish()
        await self.home()

    async def home(self) -> None:
        await asyncio.sleep(self.travel_s)
        self.dock()
