"""The cart: a machine of python-statemachine, told by messages of a bus."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Protocol

from statemachine import State, StateMachine

from tea_cart.messages import CartSays, CartState, CupTaken, SpillSeen, TeaWish


class Bus(Protocol):
    def publish(self, message: object) -> None: ...

    def subscribe(self, kind: type, callback: Callable[[Any], None]) -> None: ...


class CartMachine(StateMachine):
    parked = State(initial=True)
    brewing = State()
    offering = State()
    cleaning = State()

    wish = parked.to(brewing)
    brewed = brewing.to(offering)
    taken = offering.to(parked)
    spill = parked.to(cleaning) | brewing.to(cleaning) | offering.to(cleaning)
    cleaned = cleaning.to(parked)


class TeaCart:
    def __init__(self, bus: Bus, brew_s: float = 3.0) -> None:
        self._bus = bus
        self._brew_s = brew_s
        self._left = 0
        self._lock = threading.Lock()
        self.machine = CartMachine()
        bus.subscribe(TeaWish, self._on_wish)
        bus.subscribe(CupTaken, self._on_taken)
        bus.subscribe(SpillSeen, self._on_spill)

    def _tell(self) -> None:
        self._bus.publish(CartState(self.machine.current_state.id))

    def _on_wish(self, wish: TeaWish) -> None:
        with self._lock:
            if self.machine.current_state.id != "parked":
                self._bus.publish(CartSays("one moment"))
                return
            if wish.cups > 4:
                self._bus.publish(CartSays("so many"))
                return
            self._left = wish.cups
            self.machine.wish()
            self._tell()
        threading.Timer(self._brew_s, self._brewed).start()

    def _brewed(self) -> None:
        with self._lock:
            if self.machine.current_state.id == "brewing":
                self.machine.brewed()
                self._tell()
                self._bus.publish(CartSays("tea is ready"))

    def _on_taken(self, _: CupTaken) -> None:
        with self._lock:
            if self.machine.current_state.id != "offering":
                return
            self._left -= 1
            if self._left <= 0:
                self.machine.taken()
                self._tell()

    def _on_spill(self, spill: SpillSeen) -> None:
        if spill.severity < 0.2:
            return
        with self._lock:
            if self.machine.current_state.id == "cleaning":
                return
            self.machine.spill()
            self._tell()
        threading.Timer(8.0, self._cleaned).start()

    def _cleaned(self) -> None:
        with self._lock:
            self.machine.cleaned()
            self._tell()
