"""The robot as its states see it: the ports, what it heard, what it holds, and its motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from controller.journal import DISCARDED, Journal
from controller.ports import Arm, Bus, Clock, Hand, HumanReady, JointPose, PlanningError, Reading, Request, TurnDone
from controller.settings import Settings


@dataclass
class Robot:
    """Ports and memory of one run: the sensors' last `reading`, and the `outcome` of this turn with its `reason`."""

    bus: Bus
    clock: Clock
    arm: Arm
    hand: Hand
    settings: Settings
    journal: Journal = field(default_factory=Journal)
    reading: Reading | None = None
    outcome: str = DISCARDED
    reason: str = ""
    turn_began_s: float = 0.0

    def __post_init__(self) -> None:
        self.requests = self.bus.subscribe(Request)
        self.readies = self.bus.subscribe(HumanReady)

    @property
    def turn(self) -> int:
        """Number of the turn that is going on, from 1."""
        return len(self.journal.turns) + 1

    def move(self, waypoints: Sequence[JointPose]) -> bool:
        """Plan and follow a way through `waypoints`; False, with a note, when the arm does not get there."""
        try:
            path = self.arm.plan(waypoints, self.settings.max_speed_rad_s)
        except PlanningError as error:
            self.note(f"no plan: {error}")
            return False
        if not self.arm.follow(path):
            self.note(f"arm did not arrive within {path.duration_s:.1f} s")
            return False
        return True

    def note(self, text: str) -> None:
        """Write into the journal."""
        self.journal.note(self.clock.now_s(), text)

    def listen(self) -> None:
        """Listen for requests from now on: what was spoken while the robot was busy does not count."""
        self.requests.clear()

    def begin_turn(self) -> None:
        """Forget what belongs to the leg before; a turn in which nothing else is known ends as discarded."""
        self.turn_began_s = self.clock.now_s()
        self.reading = None
        self.outcome = DISCARDED
        self.reason = ""

    def end_turn(self) -> None:
        """Count the turn and tell everybody how it ended."""
        turn = self.journal.add(self.outcome, self.reason, self.turn_began_s, self.clock.now_s())
        self.bus.publish(TurnDone(turn.number, turn.outcome))
