"""The person: gives orders, walks about, calls the dog, and says in the end that there are no more orders."""

from __future__ import annotations

from carebot.messages import Accepted, Order
from house.flat import PLACES
from house.house import House

from people.dog import DogCalled
from people.ranges import ENDED, PUBLISHED_S
from pytest_hricdv.run import ConcreteAction
from pytest_hricdv.testbench import Run

WALKS_S = 60.0
"""A walk through the whole flat takes 20 s at most; with the robot in the way, the person gives up (chosen)."""

SAYS_AGAIN_S = 60.0
"""Until the person says once more that there are no more orders, where the robot has not heard it (chosen)."""


class Person:
    """The person of a run.

    Args:
        run: its test says what the person does.
        house: where the person is.
    """

    def __init__(self, run: Run, house: House) -> None:
        self._run, self._house = run, house
        self._bus = run.bus.port("person")
        self._accepted = self._bus.subscribe(Accepted)
        self._has_ended = False

    def live(self) -> None:
        """Do one thing after the other; the body of the person's node."""
        self._run.kernel.sleep(self._run.test.run["first_order_s"])
        for action in self._run.actions():
            self._do(action)
        while not (self._has_ended and self._is_heard()):
            self._order(ENDED)

    def _do(self, action: ConcreteAction) -> None:
        name, _, argument = action.command.partition(" ")
        if name == "ask" or name in PUBLISHED_S or name == ENDED:
            self._order(argument or name)
        elif name == "walk":
            self._walk(argument, action.parameters["speed_m_s"])
        elif name == "sit":
            self._house.person.sit(action.parameters["speed_m_s"])
            self._arrive()
        elif name == "call_dog":
            self._bus.publish(DogCalled())
        self._run.kernel.sleep(action.parameters.get("wait_s", 0.0))

    def _order(self, kind: str) -> None:
        self._has_ended = self._has_ended or kind == ENDED
        self._bus.publish(Order(kind))

    def _is_heard(self) -> bool:
        """Whether the robot has accepted the end of orders, before it is time to say it again."""
        while (answer := self._accepted.wait(SAYS_AGAIN_S)) is not None:
            if answer.order == ENDED:
                return True
        return False

    def _walk(self, place: str, speed_m_s: float) -> None:
        self._house.person.go(PLACES[place], speed_m_s)
        self._arrive()

    def _arrive(self) -> None:
        person = self._house.person
        if not self._house.wait(lambda: not person.walking, WALKS_S):
            person.stay()


def spawn_person(run: Run, house: House) -> None:
    """Start the person's node."""
    run.kernel.spawn("person", Person(run, house).live)
