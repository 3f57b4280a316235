"""Remedies: doses that change what an interaction lacks to come to a goal.

What it lacks are letters, where texts of one length differ, as patterns of bits do: what a dose does to one of several
sensors, it does whatever the others say. What else differs may be a consequence of a pattern. Only where no letter is
lacking, it is all that differs together.
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

CONTRARY = 0.3
"""That a dose changed a letter to another one counts so much for changing it back."""

DOUBT = 1.0
"""What other doses of the same disturbance did weighs as much as so many tries of a dose."""


class Letter(NamedTuple):
    """A letter that an effect lacks: in which of its texts, of which length, where in the text, and which one."""

    number: int
    size: int
    place: int
    wanted: str


class Whole(NamedTuple):
    """An effect that is present instead of the one that is wanted."""

    present: Effect
    wanted: Effect


Lack = Letter | Whole


class Shift(NamedTuple):
    """What most often came of a treatment instead of what is usual, and how probably."""

    treatment: Treatment
    effect: Effect
    chance: float


def lacking(effect: Effect, wanted: Effect) -> tuple[Lack, ...]:
    """What an effect lacks to be the one that is wanted."""
    letters = tuple(
        Letter(number, len(one), place, there)
        for number, (one, other) in enumerate(zip(chain(*effect), chain(*wanted), strict=False))
        if len(one) == len(other)
        for place, (here, there) in enumerate(zip(one, other, strict=True))
        if here != there
    )
    return letters or ((Whole(effect, wanted),) if effect != wanted else ())


def has(effect: Effect, lack: Lack) -> bool:
    """Whether an effect has what another one lacks."""
    if isinstance(lack, Whole):
        return effect == lack.wanted
    return _letter(effect, lack) == lack.wanted


def apart(one: Effect, two: Effect) -> float:
    """How far two effects are apart: 1 for each text that differs, but for texts of one length, as patterns of bits
    are, the share of their characters that differ."""
    texts = zip(chain(*one), chain(*two), strict=False)
    return sum(_differing(left, right) for left, right in texts)


def _differing(left: str, right: str) -> float:
    if left == right or len(left) != len(right):
        return float(left != right)
    return sum(a != b for a, b in zip(left, right, strict=True)) / len(left)


class Remedies:
    """What single doses have done.

    Args:
        recipes: what is known; nothing more is learned while this is used.
    """

    def __init__(self, recipes: Recipes) -> None:
        self._singles: list[tuple[Dose, Effect, Effect, float]] = []
        """A dose, what is usual without it, what came with it, and how much that counts."""
        for planned, treatment, effect, is_clean, *_ in recipes.seen:
            usual = recipes.usual(planned)
            if len(treatment) == 1 and usual is not None and _comparable(usual, effect):
                self._singles.append((treatment[0], usual, effect, 1.0 if is_clean else BLURRED))
        self._shifts: dict[Effect, list[Shift]] = {}
        self._known: dict[Lack, dict[Dose, float]] = {}

    def against(self, lack: Lack) -> dict[Dose, float]:
        """Dose -> how probably it mends what is lacking. Those that never have, nor the contrary, are left out.

        What makes the contrary of a letter probably does both, as what inverts a sensor does.
        """
        found = self._known.get(lack)
        if found is None:
            tries: dict[Dose | str, float] = defaultdict(float)
            came: dict[Dose | str, float] = defaultdict(float)
            for dose, before, after, weight in self._singles:
                if isinstance(lack, Whole):
                    tried = weight * max(0.0, 1.0 - apart(before, lack.present))
                    mended = tried * has(after, lack)
                elif not _letter(before, lack):
                    continue
                elif not has(before, lack):
                    tried, mended = weight, weight * has(after, lack)
                else:
                    tried, mended = CONTRARY * weight, CONTRARY * weight * _changes(before, after, lack)
                for key in (dose, dose.name):
                    tries[key] += tried
                    came[key] += mended
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

    def promise(self, names: Iterable[str], lack: Lack) -> dict[str, float]:
        """Disturbance -> how often its doses probably change what is in question, whatever it becomes.

        Of two tries before all, one is taken to have done so: what was hardly tried is promising.

        Args:
            names: of the disturbances.
            lack: in question.
        """
        tries, changed = dict.fromkeys(names, 2.0), dict.fromkeys(names, 1.0)
        for dose, before, after, weight in self._singles:
            if dose.name in tries:
                if isinstance(lack, Whole):
                    alike, differs = max(0.0, 1.0 - apart(before, lack.present)), before != after
                else:
                    alike, differs = float(_letter(before, lack) != ""), _changes(before, after, lack)
                tries[dose.name] += weight * alike
                changed[dose.name] += weight * alike * differs
        return {name: changed[name] / tries[name] for name in tries}


def _letter(effect: Effect, lack: Letter) -> str:
    """The letter that is there; empty where the text is of another length."""
    texts = tuple(chain(*effect))
    is_alike = lack.number < len(texts) and len(texts[lack.number]) == lack.size
    return texts[lack.number][lack.place] if is_alike else ""


def _changes(before: Effect, after: Effect, lack: Letter) -> bool:
    """Whether a letter is another one in a text of the same length."""
    return _letter(after, lack) not in ("", _letter(before, lack))


def _comparable(one: Effect, other: Effect) -> bool:
    """Whether effects are of the same cross products."""
    return [each[0] for each in one] == [each[0] for each in other]
