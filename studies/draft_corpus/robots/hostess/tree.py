"""A hostess that greets and seats guests: a behaviour tree of py_trees."""

import py_trees
from py_trees.common import Access, Status


class Board(py_trees.behaviour.Behaviour):
    def __init__(self, name, robot):
        super().__init__(name)
        self.robot = robot


class SeesGuest(Board):
    def update(self):
        person = self.robot.camera.nearest_person()
        return Status.SUCCESS if person and person.distance < 2.5 else Status.FAILURE


class Greet(Board):
    def initialise(self):
        self.robot.voice.say("welcome")

    def update(self):
        return Status.RUNNING if self.robot.voice.busy() else Status.SUCCESS


class Ask(Board):
    def initialise(self):
        self.robot.voice.say("a table for how many?")
        self.waited = 0

    def update(self):
        self.waited += 1
        heard = self.robot.ears.take()
        if heard == "one":
            self.robot.seats = 1
            return Status.SUCCESS
        if heard in ("two", "a couple"):
            self.robot.seats = 2
            return Status.SUCCESS
        if heard == "goodbye" or self.waited > 100:
            return Status.FAILURE
        return Status.RUNNING


class Lead(Board):
    def initialise(self):
        self.robot.base.drive_to("table %d" % self.robot.seats)

    def update(self):
        status = self.robot.base.status()
        if status == "blocked":
            self.robot.voice.say("excuse me")
            return Status.RUNNING
        return Status.SUCCESS if status == "there" else Status.RUNNING


class Return(Board):
    def initialise(self):
        self.robot.base.drive_to("door")

    def update(self):
        return Status.SUCCESS if self.robot.base.status() == "there" else Status.RUNNING


class Hostess:
    def __init__(self, camera, voice, ears, base):
        self.camera, self.voice, self.ears, self.base = camera, voice, ears, base
        self.seats = 0
        serve = py_trees.composites.Sequence("serve", memory=True)
        serve.add_children([SeesGuest("sees", self), Greet("greet", self), Ask("ask", self), Lead("lead", self),
                            Return("return", self)])
        self.tree = py_trees.trees.BehaviourTree(serve)

    def tick(self):
        self.tree.tick()
