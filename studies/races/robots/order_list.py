"""A waiter goes through its list of orders and then clears it, also of an order that was added since."""

import threading
import time

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.goes = bus.subscribe(Go)
        self.lock = threading.Lock()
        self.orders = []

    def add(self, order):
        self.orders.append(order)

    def bring(self, order):
        self.bus.publish(Done())

    def serve(self):
        for order in self.orders:
            self.bring(order)
        self.orders.clear()

    def listen(self):
        number = 0
        while True:
            if self.goes.wait(100.0) is not None:
                number += 1
                self.add(number)

    def work(self):
        threading.Thread(target=self.listen, daemon=True).start()
        while True:
            self.serve()
            time.sleep(0.1)


class Repaired(Robot):
    def add(self, order):
        with self.lock:
            super().add(order)

    def serve(self):
        with self.lock:
            orders, self.orders = self.orders, []
        for order in orders:
            self.bring(order)
