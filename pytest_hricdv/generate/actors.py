"""The actors of a test: their lanes of actions, the causal order between these, and how the lanes interleave.

`actor_of` and `act_of` split a line of a test. `interleave` gives the order of the actions, in which `lanes` runs them.

A test with several actors says in each line who acts, as in `nurse: press call`; a test with one actor does not. The
lines of an actor are its *lane*: their order is kept. Between lanes, only the causal order of the model's run is kept
(`# after 3: 1`: the third action begins after the first is done); otherwise, the interleaving is drawn. For this, every
action of a lane has the parameter `turn`, a key from 0 to 1: of the lanes' next actions, the one with the smallest key
goes first, and of equal keys the one that is first in the text (J. C. Bean: Genetic Algorithms and Random Keys for
Sequencing and Optimization, ORSA J. Computing 6(2), 1994). So an interleaving consists of parameters, which are drawn,
searched for, shrunk and stored like all others.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from random import Random

from pytest_hricdv._base.message import quote
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.sampler import Sampler, Uniform

#: Number of an action (from 1) -> the numbers of those, of other actors, that have to be done before it begins.
After = Mapping[int, tuple[int, ...]]

NO_ORDER: After = {}
"""The order of a test with one actor."""

TURN = "turn"
"""The parameter of an action that says when its turn is, from 0 to 1."""
TURN_WAIT_S = "turn_wait_s"
"""The parameter of a run that says for how long (s) an actor waits for its turn at most."""

_ACTOR = re.compile(r"([A-Za-z_]\w*): ", re.ASCII)
# Six digits: more than any test has actions, and int() of thousands of digits takes its time.
_NUMBER = re.compile(r"[1-9]\d{0,5}\Z", re.ASCII)


@dataclass(frozen=True)
class TurnWait(Uniform):
    """How long an actor waits for its turn at most; the simplest is not to wait."""

    def simple_values(self) -> tuple[float, ...]:
        """The least first."""
        return tuple(sorted(super().simple_values()))


TURNS = Uniform(0.0, 1.0)
"""The range of turns."""

PAUSE_S = "pause_s"
"""The parameter of an action that says how long its actor does nothing before it (s). Only tests made from runs with
interactive agents have it: there, people waited for events that the test does not contain."""


@dataclass(frozen=True)
class Pause(Sampler):
    """How long somebody does nothing (s): never drawn, but stored of a run in which people decided."""

    unit: str = "s"

    def __str__(self) -> str:
        return "0 s or more"

    def sample(self, rng: Random) -> float:
        """None."""
        return 0.0

    def simple_values(self) -> tuple[float, ...]:
        """None."""
        return (0.0,)

    def contains(self, value: float) -> bool:
        """Whether it is a time."""
        return 0.0 <= value < math.inf


def stay_of(actor: str) -> str:
    """The parameter of a run that says how long an actor stays after its last action (s), as `PAUSE_S`."""
    return f"{actor}_stays_s"


def actor_of(line: str) -> str:
    """The actor of a line; empty if it names none.

    >>> actor_of("nurse: press call"), actor_of("press call")
    ('nurse', '')
    """
    match = _ACTOR.match(line)
    return match[1] if match else ""


def act_of(line: str) -> str:
    """The act of a line, without its actor.

    >>> act_of("nurse: press call"), act_of("press call")
    ('press call', 'press call')
    """
    match = _ACTOR.match(line)
    return line[match.end() :] if match else line


def actors_of(lines: Iterable[str]) -> tuple[str, ...]:
    """The actors of these lines, in the order of their first lines."""
    return tuple(dict.fromkeys(actor for line in lines if (actor := actor_of(line))))


def interleave(lines: Sequence[str], turns: Sequence[float], after: After) -> tuple[int, ...]:
    """The order in which actions begin: their numbers, from 1; lines without an actor are left out.

    Args:
        turns: the key of each line, ignored for lines without an actor. after: the actions that have to be done before.
    """
    lanes: dict[str, list[int]] = {}
    for number, line in enumerate(lines, 1):
        if actor := actor_of(line):
            lanes.setdefault(actor, []).append(number)
    order: list[int] = []
    begun: set[int] = set()
    while any(lanes.values()):
        heads = [lane[0] for lane in lanes.values() if lane and begun.issuperset(after.get(lane[0], ()))]
        # Never empty: causes come before their effects in the text, so the first line that is left has all of them.
        number = min(heads, key=lambda head: (turns[head - 1], head))
        order.append(number)
        begun.add(number)
        lanes[actor_of(lines[number - 1])].pop(0)
    return tuple(order)


def check_after(after: After, lines: Sequence[str]) -> None:
    """Check what is to come after what.

    Raises:
        GenerateError: a number of no action of an actor, or of one that comes later in the text, or in the same lane.
    """
    for number, causes in after.items():
        where = f"after {number}"
        for place in (number, *causes):
            if not 1 <= place <= len(lines) or not actor_of(lines[place - 1]):
                raise GenerateError(f"{where}: {place} is not an action of an actor; expected its number, from 1")
        for cause in causes:
            if cause >= number:
                raise GenerateError(f"{where}: {cause} comes later in the text; expected actions above it")
            if actor_of(lines[cause - 1]) == actor_of(lines[number - 1]):
                actor = actor_of(lines[number - 1])
                raise GenerateError(f"{where}: {cause} is an action of {actor}, too, and in order; expected of others")
        if not causes:
            raise GenerateError(f"{where}: nothing; expected at least one action, or no entry")


def after_to_data(after: After) -> dict[str, list[int]]:
    """Plain data for JSON, the same for equal orders."""
    return {str(number): sorted(after[number]) for number in sorted(after)}


def after_from_data(data: Mapping[str, Sequence[int]]) -> dict[int, tuple[int, ...]]:
    """What `after_to_data` gave. Raises GenerateError for a key that is not a number."""
    return {_number(key): tuple(causes) for key, causes in data.items()}


def after_from_text(text: str) -> tuple[int, ...]:
    """The numbers of a text such as `1 4`. Raises GenerateError if it has others."""
    return tuple(sorted({_number(word) for word in text.replace(",", " ").split()}))


def _number(text: str) -> int:
    if _NUMBER.match(text) is None:
        raise GenerateError(f"after: {quote(text)}; expected the number of an action, from 1")
    return int(text)


def after_of_kept(after: After, kept: Sequence[int], lines: Sequence[str]) -> dict[int, tuple[int, ...]]:
    """The order when only these actions are kept: effects of a dropped action come after its causes.

    Args:
        after: action -> its causes, of the whole test.
        kept: the numbers of the actions that are kept, ascending.
    """
    new_number = {number: place for place, number in enumerate(kept, 1)}

    def select_causes(number: int) -> set[int]:
        causes: set[int] = set()
        for cause in after.get(number, ()):
            causes |= {cause} if cause in new_number else select_causes(cause)
        return causes

    order: dict[int, tuple[int, ...]] = {}
    for number in kept:
        actor = actor_of(lines[number - 1])
        causes = {cause for cause in select_causes(number) if actor_of(lines[cause - 1]) != actor}
        if causes:
            order[new_number[number]] = tuple(sorted(new_number[cause] for cause in causes))
    return order
