"""A compiled agent's mental state."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.terms import Key, Structure

from ..environment import Environment
from ..participant import Participant
from .activity import Activity, Pending
from .code import AgentCode
from .program import Store

if TYPE_CHECKING:
    from ..scheduler import Run


class CompiledMind(Participant):
    """What a compiled agent believes, is busy with and has yet to react to.

    Args:
        name: its name.
        run: the run it takes part in.
        code: its program and how it begins.
    """

    __slots__ = (
        "_listens",
        "_queues",
        "_versions",
        "activities",
        "acts_alone",
        "ahead",
        "code",
        "events",
        "feedback",
        "goes_ahead",
        "granted",
        "intentions",
        "is_watched",
        "known",
        "letters",
        "lines",
        "listed",
        "others",
        "p",
        "resumed",
        "seen_percepts",
        "tables",
    )

    def __init__(self, name: str, run: Run, code: AgentCode) -> None:
        super().__init__(name, run, takes_letters=True)
        self.is_watched = False
        """Whether what it is told has to go through :meth:`_believe`."""
        self.code = code
        self.letters = code.letters
        """The messages that it sends that are always the same."""
        self.known = code.known
        """Other messages that it sends, as far as known."""
        self.lines = code.lines
        """The actions that it does together and that are always the same."""
        self.p: Store = code.propositions.copy()
        """Beliefs without arguments: their names, and their annotations."""
        self.tables: list[Store] = [table.copy() for table in code.tables]
        """Beliefs with arguments of the predicates that the program tests."""
        self.others: dict[Key, Store] = {key: table.copy() for key, table in code.others.items()}
        """Beliefs of other predicates."""
        self.events: deque[Pending] = deque(code.events)
        self.feedback: deque[tuple[Activity, bool]] = deque()
        self.intentions: deque[Activity] = deque()
        self._queues = self.mailbox, self.events, self.feedback, self.intentions
        self.activities = 0
        """Activities so far."""
        self.resumed: Activity | None = None
        """The activity that it has gone on with last, if its plan was not selected in that cycle."""
        self.granted = 0
        """The cycles that may be done at once."""
        self.ahead = 0
        """If it goes on while another one has something to do, the cycles that it did before that."""
        self.acts_alone = type(run.environment) is Environment
        """Whether actions do nothing but succeed, so that they need not be executed."""
        self.goes_ahead = self.acts_alone and not run.watched
        """Whether it may go on after a message while others have something to do."""
        self.seen_percepts = 0
        """The version of its percepts when it last looked."""
        self.listed: tuple[Structure, ...] = ()
        """What its environment listed then."""
        self._versions = run.percept_versions(name)
        self._listens = not self.acts_alone or self._versions.get(name, 0) != 0
        self.awake = self.has_work()

    def has_work(self) -> bool:
        """Whether a reasoning cycle would do anything."""
        return bool(self.events) or self.has_news()

    def has_news(self) -> bool:
        """Whether a cycle would do anything besides reacting to an event."""
        return bool(
            self.intentions or self.mailbox or self.feedback or self.seen_percepts != self._versions.get(self.name, 0)
        )

    def look_up(self) -> None:
        """Look at more than the mailbox when it is next to do something."""
        self._listens = True

    def note_seen(self) -> None:
        """It has been put into this state, after perceiving what its environment lists."""
        self._queues = self.mailbox, self.events, self.feedback, self.intentions
        self.seen_percepts = self._versions.get(self.name, 0)
        self._listens = not self.acts_alone
        self.spin = None
        self.awake = self.has_work()
