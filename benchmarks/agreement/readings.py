"""Which turn had which reading: a report tells the readings of a run, but not in the order of its turns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from benchmarks.agreement.asked import Asked
from benchmarks.agreement.pair import errs

Fits = Callable[[str, str], bool]


def in_turn(legs: Sequence[str], decisions: Iterable[Sequence[str]], requests: Sequence[Asked]) -> tuple[str, ...]:
    """The reading of each turn.

    Of the turns that ended alike, those get a reading first that read what the person did, then those whose reading a
    sensor error explains, then the rest: what remains unexplained then is so in whatever order the readings came.

    Args:
        legs: how each turn ended.
        decisions: reading and outcome of each turn, in any order.
        requests: what the person did for each turn.

    Raises:
        ValueError: the decisions are not those of the legs.
    """
    left = [(reading, outcome) for reading, outcome in decisions]
    if sorted(outcome for _, outcome in left) != sorted(legs):
        raise ValueError(f"turns that ended {', '.join(legs)} have the decisions {left}")
    poses = [*(turn.pose for turn in requests), *[""] * len(legs)][: len(legs)]
    found: dict[int, str] = {}
    rounds: tuple[Fits, ...] = (lambda pose, reading: pose == reading, _explained, lambda pose, reading: True)
    for fits in rounds:
        for place, (pose, leg) in enumerate(zip(poses, legs, strict=True)):
            if place in found:
                continue
            fitting = [each for each in left if each[1] == leg and fits(pose, each[0])]
            if fitting:
                left.remove(fitting[0])
                found[place] = fitting[0][0]
    return tuple(found[place] for place in range(len(legs)))


def _explained(pose: str, reading: str) -> bool:
    return len(pose) == len(reading) == 3 and errs(pose, reading)
