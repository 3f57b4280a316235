"""What the robot remembers of its work: one entry a turn, and the report on the table."""

from __future__ import annotations

from dataclasses import dataclass, field

from controller.ports import TableDone

RELEASED = "released"
DISCARDED = "discarded"
NO_HUMAN_READY = "no-human-ready"
SENSING_TIMEOUT = "sensing-timeout"
OUTCOMES = (RELEASED, DISCARDED, NO_HUMAN_READY, SENSING_TIMEOUT)


@dataclass(frozen=True)
class Turn:
    """One leg: its number from 1, how it ended, why, and when it began and ended (s)."""

    number: int
    outcome: str
    reason: str
    began_s: float
    ended_s: float


@dataclass
class Journal:
    """The turns of one table."""

    began_s: float = 0.0
    turns: list[Turn] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def begin(self, now_s: float) -> None:
        """Start a new table."""
        self.began_s = now_s
        self.turns.clear()
        self.notes.clear()

    def note(self, now_s: float, text: str) -> None:
        """Keep a remark for whoever reads the journal later."""
        self.notes.append(f"{now_s:.2f} s: {text}")

    def add(self, outcome: str, reason: str, began_s: float, now_s: float) -> Turn:
        """Count a turn that is over."""
        turn = Turn(len(self.turns) + 1, outcome, reason, began_s, now_s)
        self.turns.append(turn)
        return turn

    def released(self) -> int:
        """Legs handed over so far."""
        return sum(turn.outcome == RELEASED for turn in self.turns)

    def report(self, now_s: float, turns: int, on_time_s: float) -> TableDone:
        """The report on the table: good when every leg was handed over, on time when that took at most `on_time_s`."""
        duration_s = now_s - self.began_s
        released = self.released()
        if released < turns:
            lost = [f"{turn.number} {turn.outcome}" for turn in self.turns if turn.outcome != RELEASED]
            self.note(now_s, "table incomplete: " + ", ".join(lost))
            return TableDone(released, duration_s, on_time=False)
        slowest = max(self.turns, key=lambda turn: turn.ended_s - turn.began_s)
        self.note(now_s, f"table complete after {duration_s:.1f} s; slowest turn {slowest.number}")
        return TableDone(released, duration_s, on_time=duration_s <= on_time_s)
