#!/usr/bin/env python3
"""Gate at the lift: the robot asks by UDP to pass, people have a button that stops everything."""
import argparse
import socket
import time

PORT = 5005
OPEN_TIME = 6.0


class Gatekeeper:
    CLOSED, OPENING, OPEN, BLOCKED = range(4)
    NAMES = ("closed", "opening", "open", "blocked")

    def __init__(self, motor, light_barrier, port=PORT):
        self.motor = motor
        self.barrier = light_barrier
        self.sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sock.bind(("", port))
        self.sock.settimeout(0.2)
        self.status = self.CLOSED
        self.opened_at = None
        self.owner = None

    def serve(self):
        while True:
            try:
                data, sender = self.sock.recvfrom(256)
            except socket.timeout:
                data = b""
            if data:
                words = data.decode("ascii", "ignore").strip().split()
                answer = self.command(words[0].upper(), words[1:]) if words else "ERR empty"
                self.sock.sendto(answer.encode(), sender)
            self.step()

    def command(self, verb, rest):
        if verb == "PASS":
            if not rest:
                return "ERR who?"
            if self.status == self.BLOCKED:
                return "NO blocked"
            if self.owner not in (None, rest[0]):
                return "NO busy"
            self.owner = rest[0]
            self.status = self.OPENING
            self.motor.up()
            return "OK"
        if verb == "DONE":
            if rest and rest[0] == self.owner:
                self.close()
                return "OK"
            return "ERR not yours"
        if verb == "STOP":
            self.motor.halt()
            self.status = self.BLOCKED
            return "OK"
        if verb == "RESET":
            if self.status == self.BLOCKED:
                self.close()
            return "OK"
        if verb == "STATUS":
            return self.NAMES[self.status]
        return "ERR unknown"

    def close(self):
        self.motor.down()
        self.owner = None
        self.opened_at = None
        self.status = self.CLOSED

    def step(self):
        if self.status == self.OPENING and self.motor.at_top():
            self.status = self.OPEN
            self.opened_at = time.time()
        elif self.status == self.OPEN and time.time() - self.opened_at > OPEN_TIME:
            if self.barrier.is_interrupted():
                self.opened_at = time.time()
            else:
                self.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=PORT)
    options = parser.parse_args()
    from gate_hardware import Barrier, Motor

    Gatekeeper(Motor(), Barrier(), options.port).serve()


if __name__ == "__main__":
    main()
