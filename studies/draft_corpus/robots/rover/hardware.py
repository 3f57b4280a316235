import RPi.GPIO as GPIO

LEFT, RIGHT, BUMPER = 12, 13, 21


class Motors:
    def __init__(self):
        GPIO.setmode(GPIO.BCM)
        GPIO.setup([LEFT, RIGHT], GPIO.OUT)
        self._left = GPIO.PWM(LEFT, 1000)
        self._right = GPIO.PWM(RIGHT, 1000)
        self._left.start(0)
        self._right.start(0)

    def set(self, forward, turn):
        self._left.ChangeDutyCycle(min(100, abs(forward - turn) * 100))
        self._right.ChangeDutyCycle(min(100, abs(forward + turn) * 100))

    def stop(self):
        self.set(0, 0)


class Bumper:
    def __init__(self):
        GPIO.setup(BUMPER, GPIO.IN)

    def pressed(self):
        return GPIO.input(BUMPER) == GPIO.LOW
