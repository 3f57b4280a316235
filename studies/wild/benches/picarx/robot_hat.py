
from types import SimpleNamespace

world = SimpleNamespace(distance_cm=-1.0, powers={}, direction={}, changed=lambda: None, sleep=lambda s: None)
utils = SimpleNamespace(reset_mcu=lambda: None)


class Pin:
    IN, PULL_DOWN = 0, 1

    def __init__(self, pin, *mode, **further):
        self.pin = pin

    def high(self):
        world.direction[self.pin] = -1

    def low(self):
        world.direction[self.pin] = 1


class PWM(Pin):
    period = prescaler = lambda self, value: None

    def pulse_width_percent(self, value):
        world.powers[self.pin] = value
        world.changed()


class Servo(Pin):
    angle = lambda self, value: None


class ADC(Pin):
    pass


class Grayscale_Module:
    def __init__(self, *adcs, reference):
        self.reference = lambda value: None


class Ultrasonic:
    def __init__(self, trigger, echo):
        pass

    def read(self):
        world.sleep(0.02)
        return world.distance_cm


class fileDB:
    def __init__(self, *arguments):
        self.get = lambda name, default_value: default_value
