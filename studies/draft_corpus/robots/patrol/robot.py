"""Night patrol in a care home: a tree that is ticked at 5 Hz; callbacks of sensors write to the blackboard."""

import threading
import time

import py_trees
from py_trees.common import Access

from patrol.behaviours import Battery, CallNurse, Confirmed, GoTo, PersonClose, Speak

WAYPOINTS = ["room 1", "room 2", "hall"]


def create_root(base, speaker, phone):
    root = py_trees.composites.Selector("patrol", memory=False)
    charge = py_trees.composites.Sequence("charge", memory=False)
    charge.add_children([Battery("low battery"), Speak("tired", speaker, "I have to charge")])
    care = py_trees.composites.Sequence("care", memory=True)
    answer = py_trees.composites.Selector("answer", memory=False)
    answer.add_children([Confirmed("all well"), CallNurse("call nurse", phone)])
    care.add_children([PersonClose("person close", 1.5), Speak("ask", speaker, "Are you well?"),
                       py_trees.decorators.Timeout("wait", child=answer, duration=20.0)])
    root.add_children([charge, care, GoTo("go on", base)])
    return root


class Patrol:
    def __init__(self, base, speaker, phone, rate_hz=5.0):
        self.board = py_trees.blackboard.Client(name="patrol")
        for key, value in (("person", None), ("answer", ""), ("battery", 100.0), ("waypoints", list(WAYPOINTS))):
            self.board.register_key(key, access=Access.WRITE)
            self.board.set(key, value)
        self.tree = py_trees.trees.BehaviourTree(create_root(base, speaker, phone))
        self.tree.add_post_tick_handler(self._on_tick)
        self.period_s = 1.0 / rate_hz
        self.doing = "starting"
        self._stop = threading.Event()

    def person_callback(self, detection):
        """From the camera, ten times in a second: a dict with `distance`, or None."""
        self.board.person = detection
        if detection is None:
            self.board.answer = ""

    def speech_callback(self, text, confidence):
        if confidence < 0.5:
            return
        words = text.lower().split()
        if "help" in words:
            self.board.answer = "help"
        elif "yes" in words or "fine" in words:
            self.board.answer = "yes"

    def battery_callback(self, percent):
        self.board.battery = percent

    def _on_tick(self, tree):
        tip = tree.root.tip()
        self.doing = tip.name if tip is not None else "nothing"

    def spin(self):
        while not self._stop.is_set():
            begin = time.monotonic()
            self.tree.tick()
            time.sleep(max(0.0, self.period_s - (time.monotonic() - begin)))

    def stop(self):
        self._stop.set()
        self.tree.interrupt()
