import threading

import serial


class Gripper:
    """Speaks lines of ASCII: `G0` opens, `G1` closes, `F?` asks for the force in Newton, `S?` for the status."""

    def __init__(self, port="/dev/ttyUSB0"):
        self._serial = serial.Serial(port, 115200, timeout=0.2)
        self._lock = threading.Lock()

    def _ask(self, command):
        with self._lock:
            self._serial.write((command + "\n").encode("ascii"))
            return self._serial.readline().decode("ascii").strip()

    def open(self):
        return self._ask("G0") == "OK"

    def close(self):
        return self._ask("G1") == "OK"

    def force(self):
        reply = self._ask("F?")
        try:
            return float(reply)
        except ValueError:
            return 0.0

    def status(self):
        return self._ask("S?")
