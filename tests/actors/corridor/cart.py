"""The code under test: a cart drives along the corridor, and stops while somebody is in its way.

It has a fault that takes two people: whoever sends it on is believed, even if somebody stands there. Alone, the nurse
sends it on when nobody is in the way, and the child steps out of the way before it drives on.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Protocol

LOOK_EVERY_S = 0.1


@dataclass(frozen=True)
class Near:
    """The sensor: somebody has come into the way, or nobody is there any more."""

    somebody: bool


@dataclass(frozen=True)
class SendOn:
    """The nurse sends the cart on."""


@dataclass(frozen=True)
class Arrived:
    """The cart has reached the end of the corridor."""


class Wheels(Protocol):
    """The drive of the cart."""

    def drive(self, on: bool) -> None: ...

    def is_there(self) -> bool: ...


def deliver(bus: Any, wheels: Wheels, obeys: bool = True) -> None:
    """Drive to the end of the corridor.

    Args:
        bus: of the cart.
        wheels: its drive.
        obeys: whether it drives on when it is sent on, which is the fault.
    """
    near, sent_on = bus.subscribe(Near), bus.subscribe(SendOn)
    stopped = False
    while not wheels.is_there():
        while (message := near.poll()) is not None:
            stopped = message.somebody
        if sent_on.poll() is not None and obeys:
            stopped = False
        wheels.drive(not stopped)
        time.sleep(LOOK_EVERY_S)
    wheels.drive(False)
    bus.publish(Arrived())
