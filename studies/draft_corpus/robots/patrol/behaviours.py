import py_trees
from py_trees.common import Access, Status


class PersonClose(py_trees.behaviour.Behaviour):
    def __init__(self, name, limit_m):
        super().__init__(name)
        self.limit_m = limit_m
        self.board = self.attach_blackboard_client(name=name)
        self.board.register_key("person", access=Access.READ)

    def update(self):
        person = self.board.person
        if person is None or person["distance"] > self.limit_m:
            return Status.FAILURE
        self.feedback_message = "person at %.1f m" % person["distance"]
        return Status.SUCCESS


class Speak(py_trees.behaviour.Behaviour):
    def __init__(self, name, speaker, text):
        super().__init__(name)
        self.speaker = speaker
        self.text = text

    def initialise(self):
        self.speaker.say(self.text)

    def update(self):
        return Status.RUNNING if self.speaker.is_talking() else Status.SUCCESS


class Confirmed(py_trees.behaviour.Behaviour):
    """Whether the person answered that all is well."""

    def __init__(self, name):
        super().__init__(name)
        self.board = self.attach_blackboard_client(name=name)
        self.board.register_key("answer", access=Access.READ)

    def update(self):
        if self.board.answer == "yes":
            return Status.SUCCESS
        if self.board.answer == "help":
            return Status.FAILURE
        return Status.RUNNING


class CallNurse(py_trees.behaviour.Behaviour):
    def __init__(self, name, phone):
        super().__init__(name)
        self.phone = phone

    def update(self):
        self.phone.call("nurse")
        return Status.SUCCESS


class GoTo(py_trees.behaviour.Behaviour):
    def __init__(self, name, base):
        super().__init__(name)
        self.base = base
        self.board = self.attach_blackboard_client(name=name)
        self.board.register_key("waypoints", access=Access.WRITE)
        self.target = None

    def initialise(self):
        self.target = self.board.waypoints[0]
        self.base.send_goal(self.target)

    def update(self):
        result = self.base.result()
        if result == "running":
            return Status.RUNNING
        if result == "succeeded":
            self.board.waypoints = self.board.waypoints[1:] + [self.target]
            return Status.SUCCESS
        return Status.FAILURE

    def terminate(self, new_status):
        if new_status == Status.INVALID:
            self.base.cancel()


class Battery(py_trees.behaviour.Behaviour):
    def __init__(self, name, low=20.0):
        super().__init__(name)
        self.low = low
        self.board = self.attach_blackboard_client(name=name)
        self.board.register_key("battery", access=Access.READ)

    def update(self):
        return Status.SUCCESS if self.board.battery < self.low else Status.FAILURE
