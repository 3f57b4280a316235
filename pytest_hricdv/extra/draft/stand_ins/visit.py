"""What a person does in one run: the actions of the test, one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.say import Say

LOOKS_EACH_S = 0.25
"""The period (s) at which a person checks for an answer."""


@dataclass(frozen=True)
class Manners:
    """How people wait.

    Args:
        answer_s: for an answer (s).
        stays_s: most time until the robot says nothing more (s).
    """

    answer_s: float = 30.0
    stays_s: float = 150.0


@dataclass
class Visit:
    """A person who acts in one run.

    Args:
        border: of the code.
        name: of the person.
        says: command -> what is said.
        answers: classes of messages that answer what was said.
        hears: all classes of messages of the robot.
        senses: command, or its word, that sets what a device returns -> "port.name", and the text, if it is one.
        manners: how the person waits.
    """

    border: RunBorder
    name: str
    says: dict[str, Say]
    answers: tuple[type[Any], ...]
    hears: tuple[type[Any], ...]
    senses: dict[str, tuple[str, str | None]]
    manners: Manners
    manner: str = "in_time"
    """The manner of the last message."""

    def act(self) -> None:
        """The body of the person's node."""
        run = self.border.run
        bus = run.bus.port(self.name)
        answers = [bus.subscribe(kind) for kind in self.answers]
        hears = [bus.subscribe(kind) for kind in self.hears]
        run.kernel.sleep(LOOKS_EACH_S)
        for action in run.actions():
            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))
            if run.ending is not None:
                return  # the robot has ended: only earlier questions are waited for
            what, _, how = action.command.rpartition(" ")
            if action.command == "wait_answer":
                self._wait_answer(answers)
            elif action.command == "wait_quiet":
                self._wait_quiet(hears)
            elif action.command in self.senses or what in self.senses:
                name, text = self.senses.get(action.command) or self.senses[what]
                for answer in answers:
                    answer.clear()
                self.border.sense(name, action.parameters.get("value", how == "yes") if text is None else text)
            elif what in self.says:
                self.manner = how
                for answer in answers:
                    answer.clear()
                bus.publish(self.says[what].message(action.parameters))
                if how == "twice":
                    run.kernel.sleep(float(action.parameters["again_s"]))
                    if run.ending is None:
                        bus.publish(self.says[what].message(action.parameters))
        self.border.record("person_is_there", False)
        run.kernel.stop("the person has left")

    def _wait_answer(self, answers: list[Any]) -> None:
        kernel = self.border.run.kernel
        ends_s = kernel.now_s + (self.manners.answer_s if answers else LOOKS_EACH_S)
        while kernel.now_s < ends_s and all(answer.poll() is None for answer in answers):
            kernel.sleep(LOOKS_EACH_S)

    def _wait_quiet(self, hears: list[Any]) -> None:
        """Leave when nothing was said for as long as one waits for an answer."""
        kernel = self.border.run.kernel
        ends_s, quiet_s = kernel.now_s + self.manners.stays_s, kernel.now_s
        while kernel.now_s < min(ends_s, quiet_s + self.manners.answer_s):
            if [message for each in hears for message in iter(each.poll, None)]:
                quiet_s = kernel.now_s
            kernel.sleep(LOOKS_EACH_S)
