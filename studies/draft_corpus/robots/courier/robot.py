import logging
import queue
import threading
import time

log = logging.getLogger(__name__)

DESKS = {"anna": (2.0, 1.0), "ben": (4.5, 0.5), "lab": (7.0, 3.0)}


class Courier:
    def __init__(self, base, speaker, jobs=None):
        self.base = base
        self.speaker = speaker
        self.jobs = jobs if jobs is not None else queue.Queue()
        self.mode = "idle"
        self._paused = threading.Event()
        self._running = True
        self._thread = None

    def start(self):
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def stop(self):
        self._running = False
        self._thread.join()

    def _work(self):
        while self._running:
            try:
                job = self.jobs.get(timeout=0.5)
            except queue.Empty:
                self._check_battery()
                continue
            kind = job["kind"]
            if kind == "deliver":
                self._deliver(job["to"], job.get("weight", 0.0))
            elif kind == "pause":
                self._paused.set()
                self.mode = "paused"
            elif kind == "resume":
                self._paused.clear()
                self.mode = "idle"
            elif kind == "home":
                self._drive(0.0, 0.0)
                self.mode = "idle"
            else:
                log.warning("unknown job %s", job)
                self.speaker.say("I do not understand")

    def _check_battery(self):
        if self.base.battery() < 20 and self.mode != "charging":
            self.mode = "charging"
            self.base.dock()
        elif self.mode == "charging" and self.base.battery() > 80:
            self.mode = "idle"

    def _deliver(self, to, weight):
        if self._paused.is_set():
            self.speaker.say("I am paused")
            return
        if to not in DESKS:
            self.speaker.say("I do not know " + to)
            return
        if weight > 5.0:
            self.speaker.say("too heavy")
            return
        self.mode = "delivering"
        self._drive(*DESKS[to])
        self.mode = "handing over"
        self.speaker.say("your parcel is here")
        for _ in range(40):
            if not self.base.has_load():
                self.speaker.say("goodbye")
                break
            time.sleep(0.5)
        else:
            self.speaker.say("nobody took it")
        self.mode = "idle"

    def _drive(self, x, y):
        self.base.go_to(x, y)
        while not self.base.arrived():
            time.sleep(0.1)
