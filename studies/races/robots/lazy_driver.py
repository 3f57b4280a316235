"""Two hatches share a gripper that the first of them makes: the other may use it before it is connected."""

import threading

from messages import Done, Go


class Gripper:
    def __init__(self, bus):
        self.bus = bus
        self.is_connected = False

    def connect(self):
        self.is_connected = True

    def hand_over(self):
        if self.is_connected:
            self.bus.publish(Done())


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.hatches = [bus.subscribe(Go), bus.subscribe(Go)]
        self.lock = threading.Lock()
        self.gripper = None

    def make(self):
        self.gripper = Gripper(self.bus)
        self.gripper.connect()

    def get_gripper(self):
        if self.gripper is None:
            with self.lock:
                if self.gripper is None:
                    self.make()
        return self.gripper

    def serve(self, hatch):
        while True:
            if hatch.wait(100.0) is not None:
                self.get_gripper().hand_over()

    def work(self):
        threading.Thread(target=self.serve, args=(self.hatches[0],), daemon=True).start()
        self.serve(self.hatches[1])


class Repaired(Robot):
    def make(self):
        gripper = Gripper(self.bus)
        gripper.connect()
        self.gripper = gripper
