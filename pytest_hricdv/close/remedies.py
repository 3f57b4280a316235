"""Remedies: doses that change what an interaction lacks to come to a goal.

What it lacks are letters, where texts of one length differ, as patterns of bits do: what a dose does to one of several
sensors, it does whatever the others say. Only where no letter is lacking, it is whole texts: what else differs may be a
consequence of a pattern.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from itertools import chain
from typing import NamedTuple

from pytest_hricdv.close.interactions import Dose, Effect, Treatment
from pytest_hricdv.close.recipes import Recipes

BLURRED = 0.3
"""What comes after an earlier interaction was disturbed counts so much: disturbances may last."""

DOUBT = 1.0
"""What other doses of the same disturbance did weighs as much as so many tries of a dose."""


class Lack(NamedTuple):
    """What an effect lacks.

    Args:
        number: of a text in it.
        place: of a letter in the text; -1: all of it.
        wanted: there.
        present: the text instead, where all of it is lacking: what another one becomes says nothing of it.
    """

    number: int
    place: int
    wanted: str
    present: str = ""


class Shift(NamedTuple):
    """What most often came of a treatment instead of what is usual, and how probably."""

    treatment: Treatment
    effect: Effect
    chance: float


def lacking(effect: Effect, wanted: Effect) -> tuple[Lack, ...]:
    """What an effect lacks to be the one that is wanted."""
    texts = [*enumerate(zip(chain(*effect), chain(*wanted), strict=False))]
    letters = [
        Lack(number, place, letters[1])
        for number, (one, other) in texts
        if len(one) == len(other)
        for place, letters in enumerate(zip(one, other, strict=True))
        if letters[0] != letters[1]
    ]
    return tuple(letters or [Lack(number, -1, other, one) for number, (one, other) in texts if one != other])


def has(effect: Effect, lack: Lack) -> bool:
    """Whether an effect has what another one lacks."""
    texts, place = tuple(chain(*effect)), lack.place
    if lack.number >= len(texts):
        return False
    return (texts[lack.number] if place < 0 else texts[lack.number][place : place + 1]) == lack.wanted


class Remedies:
    """What single doses have done.

    Args:
        recipes: what is known; nothing more is learned while this is used.
    """

    def __init__(self, recipes: Recipes) -> None:
        self._singles: list[tuple[Dose, Effect, Effect, float]] = []
        """A dose, what is usual without it, what came with it, and how much that counts."""
        for planned, treatment, effect, is_clean, _ in recipes.seen:
            usual = recipes.usual(planned)
            if len(treatment) == 1 and usual is not None and _comparable(usual, effect):
                self._singles.append((treatment[0], usual, effect, 1.0 if is_clean else BLURRED))
        self._shifts: dict[Effect, list[Shift]] = {}
        self._known: dict[Lack, dict[Dose, float]] = {}

    def against(self, lack: Lack) -> dict[Dose, float]:
        """Dose -> how probably it mends what is lacking. Those that never have are left out."""
        found = self._known.get(lack)
        if found is None:
            tries: dict[Dose | str, float] = defaultdict(float)
            came: dict[Dose | str, float] = defaultdict(float)
            for dose, before, after, weight in self._singles:
                if not has(before, lack) and lack.present in ("", _text(before, lack.number)):
                    for key in (dose, dose.name):
                        tries[key] += weight
                        came[key] += weight * has(after, lack)
            found = self._known[lack] = {
                dose: (came[dose] + DOUBT * came[dose.name] / (tries[dose.name] + DOUBT)) / (tries[dose] + DOUBT)
                for dose in came
                if isinstance(dose, Dose) and came[dose]
            }
        return found

    def shifts(self, usual: Effect) -> list[Shift]:
        """The doses that made something else of what is usual."""
        found = self._shifts.get(usual)
        if found is None:
            came: dict[Dose, dict[Effect, float]] = {}
            for dose, before, after, weight in self._singles:
                if before == usual:
                    shares = came.setdefault(dose, {})
                    shares[after] = shares.get(after, 0.0) + weight
            most = {dose: max(counts, key=lambda effect: (counts[effect], effect)) for dose, counts in came.items()}
            found = self._shifts[usual] = [
                Shift((dose,), effect, came[dose][effect] / (sum(came[dose].values()) + DOUBT))
                for dose, effect in most.items()
                if effect != usual
            ]
        return found

    def promise(self, names: Iterable[str], usual: Effect, lack: Lack) -> dict[str, float]:
        """Disturbance -> how often its doses probably change what is in question, whatever it becomes.

        Of two tries before all, one is taken to have done so: what was hardly tried is promising.

        Args:
            names: of the disturbances.
            usual: what lacks it: only what was seen of texts of the same length counts.
            lack: in question.
        """
        tries, changed = dict.fromkeys(names, 2.0), dict.fromkeys(names, 1.0)
        number, place = lack.number, lack.place
        size = len(_text(usual, number))
        for dose, before, after, weight in self._singles:
            one, other = _text(before, number), _text(after, number)
            if len(one) == size and dose.name in tries:
                tries[dose.name] += weight
                differs = one != other if place < 0 else len(one) == len(other) and one[place] != other[place]
                changed[dose.name] += weight * differs
        return {name: changed[name] / tries[name] for name in tries}


def _text(effect: Effect, number: int) -> str:
    return tuple(chain(*effect))[number]


def _comparable(one: Effect, other: Effect) -> bool:
    """Whether effects are of the same cross products."""
    return [each[0] for each in one] == [each[0] for each in other]
