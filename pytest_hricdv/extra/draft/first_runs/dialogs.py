"""Dialogs that lead far into the code: what a person says, in an order that was found by trying.

A robot that carries parcels has to be told to load, where to go, and that its lid is closed, before it drives. No order
of messages in the source says so, and hardly any drawn one does it. So some are run, those are kept that execute what
others do not, and these are continued, those first from which fewest have gone on, as in Go-Explore (Ecoffet et al.,
Nature 590, 2021).
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence

from pytest_hricdv.extra.draft.reading.naming import word
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.model import levels

Dialog = tuple[str, ...]
"""Commands of a test, one after the other."""

Reached = frozenset[str]
"""What runs came to: statements and branches of the code, changes of texts, and situations, which are all that texts
are at one time."""

CODE = ("statement", "branch")
TEXT = "text"
"""What begins a point of the code, and one of a change of a text."""

AT_END = "at the end"
"""What a situation begins with in which a run ended."""

WAITS = "wait_answer"
"""The command of who waits until the robot says something."""

GENERATIONS, OF_EACH = 6, 32
"""So often so many are tried. Chosen on the porter, whose pin is five steps away: it is found in the fourth generation
(`python -m pytest_hricdv init --from porter`)."""

LONGEST = 20
"""Steps of a dialog; more would take too long (chosen)."""

MOST = 6
"""So many are kept (chosen: a test begins with one of them or with another order)."""

LEAST_SAID = 2
"""With fewer things to say and to sense, there is no order to be found."""


def alphabet(draft: Draft) -> tuple[str, ...]:
    """What a person says, in time, and what sensors are made to say; of texts with other numbers, the usual ones."""
    said = []
    for thing in draft.things:
        first = {kind.values: command for command, kind in reversed(thing.commands)}
        said += [f"{command} in_time" for command, kind in thing.commands
                 if not kind.values or first[kind.values] == command]  # fmt: skip
    sensed = [f"set_{word(sensor.name)} {level}" for sensor in draft.sensors for level in levels(sensor)]
    return (*said, *sensed)


def found_dialogs(
    draft: Draft, covered: Callable[[Sequence[Dialog]], Mapping[Dialog, Reached]], reached: Reached
) -> tuple[Dialog, ...]:
    """The dialogs that execute what other runs do not, and each what those before it do not.

    Args:
        draft: whose person says them.
        covered: runs dialogs, and returns what each executes; those that failed are left out. Nothing ends the search.
        reached: what the other runs execute.
    """
    words = alphabet(draft)
    if not draft.things or len(words) < LEAST_SAID:
        return ()
    drawn = random.Random(0)
    tried: dict[Dialog, Reached] = {}
    continued: dict[Dialog, list[Dialog]] = {}
    for _ in range(GENERATIONS):
        ends = _shortest(tried, reached) or [()]
        for end in ends:
            continued.setdefault(end, _continued(end, words, drawn))
        new: list[Dialog] = []
        while len(new) < OF_EACH and any(continued[end] for end in ends):
            dialog = continued[max(ends, key=lambda end: len(continued[end]))].pop()
            new += [] if dialog in tried or dialog in new else [dialog]
        executed = covered(new) if new else {}
        if not executed:
            break
        tried |= executed
    return tuple(_cover(tried, reached)[:MOST])


def _shortest(tried: dict[Dialog, Reached], reached: Reached) -> list[Dialog]:
    """The shortest dialog to each end, and to each point that others do not come to; the latest first."""
    shortest = dict[str, Dialog]()
    for dialog, points in tried.items():
        for point in (point for point in points if point.startswith(AT_END) or point not in reached):
            shortest[point] = min(shortest.get(point, dialog), dialog, key=len)
    return [dialog for dialog in reversed(tried) if dialog in {*shortest.values()}]


def _continued(dialog: Dialog, words: Sequence[str], drawn: random.Random) -> list[Dialog]:
    """All that can be said next, each with a wait for an answer, and pairs of it without one between; in any order."""
    words_alone = [(*dialog, word, WAITS) for word in drawn.sample(words, len(words))]
    pairs = [(*dialog, *drawn.choices(words, k=2), WAITS) for _ in words]
    longer = [*pairs, *words_alone, (*dialog, WAITS)]  # the last ones are tried first
    return [steps for steps in longer if len(steps) <= LONGEST]


def _cover(tried: Mapping[Dialog, Reached], reached: Reached) -> list[Dialog]:
    """The dialogs that together come to all code and changes of texts: those first that add most, and the shortest."""
    left = {dialog: frozenset(point for point in points if point.startswith((*CODE, TEXT)))
            for dialog, points in tried.items()}  # fmt: skip
    chosen = list[Dialog]()
    while left:
        best = max(left, key=lambda dialog: (len(left[dialog] - reached), -len(dialog)))
        if left[best] <= reached:
            break
        reached |= left.pop(best)
        chosen.append(best)
    return chosen


def text_of(dialogs: Sequence[Dialog]) -> str:
    """A file of abstract tests, one for each dialog."""
    return "\n".join("\n".join(dialog) + "\n" for dialog in dialogs)
