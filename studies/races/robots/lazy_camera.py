"""Both threads find that nobody has opened the camera yet, and each opens it."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.camera = None

    def listen(self, number):
        while True:
            if self.doors[number].wait(100.0) is not None:
                self.serve(number)

    def open_camera(self):
        self.ports.begin()
        return object()

    def serve(self, number):
        if self.camera is None:
            self.camera = self.open_camera()

    def work(self):
        threading.Thread(target=self.listen, args=(0,), daemon=True).start()
        self.listen(1)


class Repaired(Robot):
    def serve(self, number):
        with self.lock:
            super().serve(number)
