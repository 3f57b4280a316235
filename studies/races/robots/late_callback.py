"""A count is shown once the picture's future has its result, which may be before the future's callback has kept it."""

from concurrent.futures import ThreadPoolExecutor

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports, self.goes = ports, bus.subscribe(Go)
        self.pool = ThreadPoolExecutor(1)
        self.cups = 0

    def look(self, places):
        return 2 * places

    def keep(self, future):
        self.cups = future.result()

    def counted(self, future):
        future.result()
        return self.cups

    def work(self):
        places = 0
        while self.goes.wait(100.0) is not None:
            places += 1
            future = self.pool.submit(self.look, places)
            future.add_done_callback(self.keep)
            self.ports.show(self.counted(future))


class Repaired(Robot):
    def counted(self, future):
        return future.result()
