"""`PerceptMapping` declares which event of a run an agent perceives, and as which belief or goal.

Testbenches use it for interactive agents and for the model as an oracle; `coupling.events` parses it.
"""

from __future__ import annotations

from dataclasses import dataclass

from pytest_hricdv._base.message import InputError

PERCEPT = "percept"
"""The default source of a belief: perceived, not told by another agent."""


class CouplingError(InputError):
    """A declaration of percepts or acts does not fit the model or the run; the message says what was expected."""


@dataclass(frozen=True)
class PerceptMapping:
    """The belief or goal that an agent gets when an event happens in the run.

    The belief stays: it is not removed when the condition of the event ends, and adding it again has no effect. To
    remove it, map the end as an event of its own, whose plan removes the belief with its source,
    `-smoke[source(percept)]`. A goal is adopted each time.

    Args:
        literal: a belief, or a goal to achieve (`!serve(cup)`). A variable in it is the value of a field of the event's
            message, or of a signal: `reading(Gaze, Pressure, Location)` has the fields `gaze`, `pressure` and
            `location`. True is 1, false is 0, a string becomes an atom or stays a string.
        when: the event, in the language of requirements: `on(request)`.
        source: the agent that says so; by default it is a percept.
    """

    literal: str
    when: str
    source: str = PERCEPT

    @property
    def is_goal(self) -> bool:
        """Whether the agent is given a goal."""
        return self.literal.startswith("!")

    @property
    def owner(self) -> str:
        """Its name in errors."""
        return f"PerceptMapping({self.literal!r})"
