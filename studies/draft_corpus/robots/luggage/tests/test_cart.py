from luggage.cart import Cart, Mode
from luggage.commands import BadCommand, parse


class Wheels:
    def __init__(self):
        self.room, self.near = 0, 200

    def obstacle_cm(self):
        return self.near

    def go(self, room):
        self.room = room

    def stop(self):
        pass

    def place(self):
        return self.room


class Lift:
    answers = ("coming", "open")

    def call(self, floor):
        self.left = list(self.answers)

    def state(self):
        return self.left.pop(0)


class Lock:
    closed = True

    def open(self):
        self.closed = False

    def is_closed(self):
        return self.closed


def made():
    return Cart(Wheels(), Lift(), Lock(), wait_s=0.0)


def steps(cart, number=6):
    for _ in range(number):
        cart.step()
        if cart.mode in (Mode.AT_ROOM, Mode.HELD):
            return


def test_luggage_is_brought():
    cart = made()
    assert cart.handle(parse('{"cmd": "bring", "room": 312, "knock": "phone"}')) == "ok"
    steps(cart)
    assert cart.mode is Mode.AT_ROOM
    assert cart.handle(parse('{"cmd": "release", "pin": "2468"}')) == "ok"
    cart.lock.closed = True
    steps(cart)
    assert cart.room == 0


def test_wrong_pins_hold_it():
    cart = made()
    cart.handle(parse('{"cmd": "fetch", "room": 105, "bags": 2}'))
    steps(cart)
    for _ in range(3):
        assert cart.handle(parse('{"cmd": "release", "pin": "0000"}')) == "wrong pin"
    assert cart.mode is Mode.HELD
    assert cart.handle(parse('{"cmd": "resume"}')) == "ok"


def test_broken_lift():
    cart = made()
    cart.lift.answers = ("broken",)
    cart.handle(parse('{"cmd": "bring", "room": 201}'))
    steps(cart)
    assert cart.mode is Mode.HELD
    assert cart.handle(parse('{"cmd": "hold"}')) == "held already"


def test_bad_lines():
    for line in ("no", '{"cmd": "fly"}', '{"cmd": "fetch"}', '{"cmd": "hold", "why": 1}'):
        try:
            parse(line)
        except BadCommand:
            continue
        raise AssertionError(line)
