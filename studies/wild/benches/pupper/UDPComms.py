import sys

sys.modules["pigpio"] = sys.modules["serial"] = sys.modules[__name__]
message, sleep, moved, heard = {}, None, None, None
timeout = type("timeout", (Exception,), {})


class Subscriber:
    def __init__(self, port, timeout):
        self.timeout = timeout

    def get(self):
        if not message:
            sleep(self.timeout)
            raise timeout
        return dict(message)


class Publisher:
    __init__ = lambda self, port: None
    send = lambda self, message: heard(message["ps4_color"])


class pi:
    set_PWM_frequency = set_PWM_range = lambda self, pin, value: None
    set_PWM_dutycycle = lambda self, pin, value: moved(pin, value)
