import argparse
import logging
import queue
import threading
import time

from sorter.dispatcher import Dispatcher
from sorter.gripper import Gripper

logger = logging.getLogger("sorter")

TOOLS = {"driver": 1, "pliers": 2, "hex key": 3}
PULL_N = 4.0
MAX_BINS = 8


class SorterApp:
    def __init__(self, gripper, arm):
        self.gripper = gripper
        self.arm = arm
        self.inbox = queue.Queue()
        self.outbox = queue.Queue()
        self.state = "READY"
        self.holding = None
        self._work = queue.Queue()
        self._abort = threading.Event()
        self.dispatcher = Dispatcher(self.inbox)
        self.dispatcher.register("bring", self._on_bring)
        self.dispatcher.register("sort", self._on_sort)
        self.dispatcher.register("hand", self._on_hand)
        self.dispatcher.register("stop", self._on_stop)
        self.dispatcher.register("reset", self._on_reset)
        self._worker = threading.Thread(target=self._run_jobs, name="worker", daemon=True)

    def start(self):
        self.dispatcher.start()
        self._worker.start()

    def shutdown(self):
        self._abort.set()
        self._work.put(None)
        self.dispatcher.stop()
        self._worker.join(timeout=5.0)

    # handlers, on the dispatcher's thread

    def _on_bring(self, payload):
        if self.state == "STOPPED":
            self.outbox.put(("refused", "stopped"))
            return
        tool = payload["tool"]
        if tool not in TOOLS:
            self.outbox.put(("refused", "no such tool: %s" % tool))
            return
        self._work.put((self._bring, (tool, payload.get("side", "left"))))

    def _on_sort(self, payload):
        count = int(payload.get("bins", 1))
        if self.state == "STOPPED" or not 0 < count <= MAX_BINS:
            self.outbox.put(("refused", "sort"))
            return
        self._work.put((self._sort, (count,)))

    def _on_hand(self, payload):
        if payload["distance"] < 0.25 and self.state == "MOVING":
            self._abort.set()
            self.arm.halt()
            self._set_state("STOPPED")

    def _on_stop(self, _payload):
        self._abort.set()
        self.arm.halt()
        self._set_state("STOPPED")

    def _on_reset(self, _payload):
        self._abort.clear()
        self._set_state("READY")

    # jobs, on the worker's thread

    def _run_jobs(self):
        while True:
            job = self._work.get()
            if job is None:
                return
            function, arguments = job
            if self._abort.is_set():
                continue
            function(*arguments)

    def _bring(self, tool, side):
        self._set_state("MOVING")
        self.arm.move_to("rack", TOOLS[tool])
        if not self._wait_for_arm():
            return
        self.gripper.close()
        if self.gripper.status() == "EMPTY":
            self.outbox.put(("failed", tool))
            self._set_state("READY")
            return
        self.holding = tool
        self.arm.move_to("handover", 1 if side == "left" else 2)
        if not self._wait_for_arm():
            return
        self._set_state("OFFERING")
        deadline = time.monotonic() + 15.0
        while time.monotonic() < deadline and not self._abort.is_set():
            if self.gripper.force() > PULL_N:
                self.gripper.open()
                self.holding = None
                self.outbox.put(("done", tool))
                break
            time.sleep(0.05)
        else:
            self.outbox.put(("not taken", tool))
        if self.state == "OFFERING":
            self._set_state("READY")

    def _sort(self, count):
        self._set_state("SORTING")
        for number in range(count):
            if self._abort.is_set():
                return
            self.arm.move_to("bin", number)
            if not self._wait_for_arm():
                return
        self.outbox.put(("sorted", count))
        self._set_state("READY")

    def _wait_for_arm(self):
        for _ in range(200):
            if self._abort.is_set():
                return False
            if not self.arm.is_moving():
                return True
            time.sleep(0.1)
        self._set_state("STOPPED")
        return False

    def _set_state(self, state):
        logger.info("%s -> %s", self.state, state)
        self.state = state


class PrintArm:
    def move_to(self, place, number):
        print("arm to", place, number)

    def is_moving(self):
        return False

    def halt(self):
        print("arm halts")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", default="/dev/ttyUSB0")
    options = parser.parse_args()
    app = SorterApp(Gripper(options.port), PrintArm())
    app.start()
    try:
        while True:
            word, _, rest = input("> ").partition(" ")
            app.inbox.put((word, {"tool": rest}))
    except (EOFError, KeyboardInterrupt):
        app.shutdown()


if __name__ == "__main__":
    main()
