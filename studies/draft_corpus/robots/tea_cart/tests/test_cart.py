import time

from tea_cart.cart import TeaCart
from tea_cart.messages import CartSays, CupTaken, SpillSeen, TeaWish


class Loopback:
    def __init__(self):
        self.callbacks = {}
        self.sent = []

    def publish(self, message):
        self.sent.append(message)

    def subscribe(self, kind, callback):
        self.callbacks[kind] = callback

    def give(self, message):
        self.callbacks[type(message)](message)


def test_tea_is_served():
    bus = Loopback()
    TeaCart(bus, brew_s=0.1)
    bus.give(TeaWish("12", "mint", 1))
    bus.give(TeaWish("13", "green", 1))
    time.sleep(0.3)
    bus.give(CupTaken("12"))
    bus.give(SpillSeen(0.7))
    assert CartSays("tea is ready") in bus.sent
