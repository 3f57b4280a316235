"""The operators of past formulas on arrays: each maps the truth of its operands at all times to its own.

Truth is a small integer: 1 true, 0 false, -1 unknown (no value yet), -2 undefined (a division by zero, a result that is
not finite). `&` and `|` evaluate from left to right, so each is one choice between the operands.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pytest_hricdv.monitor.evaluation_state import nanoseconds
from pytest_hricdv.monitor.offline.series import Times

Codes = NDArray[np.int8]

UNKNOWN, UNDEFINED = -1, -2


class Truth(NamedTuple):
    """A formula at each time, right after it, and just before it if its history starts there."""

    at: Codes
    after: Codes
    before: Codes

    def positions(self) -> Codes:
        """Instant, time after it, instant, ... up to the last instant."""
        return np.stack((self.at, self.after), axis=1).ravel()[:-1]

    def negated(self) -> Truth:
        """`!` of the formula."""
        return Truth(negated(self.at), negated(self.after), negated(self.before))


def first_fault(codes: Codes, others: Codes) -> Codes:
    """`codes` where they are unknown or undefined, else `others`."""
    return np.where(codes < 0, codes, others)


def negated(codes: Codes) -> Codes:
    """`!`: unknown and undefined are kept."""
    return np.where(codes < 0, codes, 1 - codes)


def shifted(after: Codes, before: Codes) -> Codes:
    """The value just before each time: the value right after the previous one; at the first time, of `before`."""
    return np.concatenate((before[:1], after[:-1]))


def risen(truth: Truth) -> tuple[Codes, Codes]:
    """`rise`: true at an instant if the operand becomes true there or right after; false between instants."""
    rises = (truth.at > shifted(truth.after, truth.before)) | (truth.after > truth.at)
    return rises.astype(np.int8), np.zeros(len(rises), np.int8)


def _latest(marks: NDArray[np.bool_]) -> NDArray[np.intp]:
    """At each position the latest marked position up to it; -1 if there is none."""
    return np.maximum.accumulate(np.where(marks, np.arange(len(marks)), -1))


def interleaved(truth: Truth) -> Codes:
    """Instant, time after it, instant, time after it, ..."""
    return np.stack((truth.at, truth.after), axis=1).ravel()


def since(left: Truth, right: Truth) -> tuple[Codes, Codes]:
    """`left since right`: since the latest true `right`, `left` was not false."""
    began, broken = _latest(interleaved(right) == 1), _latest(interleaved(left) == 0)
    holds = ((began >= 0) & (broken <= began)).astype(np.int8)
    return holds[::2], holds[1::2]


def once(truth: Truth, grid: Times, start_s: float, end_s: float) -> tuple[Codes, Codes]:
    """`once[a:b]`: a position of the window is true, by the number of true positions up to both ends."""
    count = np.concatenate(([0], np.cumsum(interleaved(truth) == 1)))
    start_ns = int(nanoseconds(start_s))
    results = []
    for right_after in (0, 1):
        first = np.zeros(len(grid), np.intp)
        if math.isfinite(end_s):
            first = np.maximum(_position(grid, grid - int(nanoseconds(end_s)), right_after), 0)
        last = _position(grid, grid - start_ns, right_after)
        some = (last >= 0) & (count[np.maximum(last, 0) + 1] > count[first])
        results.append(some.astype(np.int8))
    return results[0], results[1]


def _position(grid: Times, times: Times, right_after: int) -> NDArray[np.intp]:
    """The position of each time, or of the time right after it; negative before the first."""
    index = np.searchsorted(grid, times, side="right") - 1
    inside = grid[np.maximum(index, 0)] != times
    position: NDArray[np.intp] = np.where(index < 0, -1, 2 * index + (inside | bool(right_after)))
    return position


def held(codes: Codes, grid: Times, length_ns: int) -> Codes:
    """`[for d]`: the time since the operand was last false is long enough."""
    broken = _latest(codes == 0)
    began = grid[np.minimum(broken + 1, len(grid) - 1)]
    holds: NDArray[np.bool_] = (codes == 1) & (grid - began >= length_ns)
    return holds.astype(np.int8)


def with_hysteresis(holds: Codes, returned: Codes, starts: NDArray[np.intp]) -> Truth:
    """A hysteresis: at each position, the latest decision by the bound or by the shifted bound.

    Args:
        holds, returned: the comparison with its own bound, and with the bound shifted by the hysteresis, at each time.
        starts: positions at which earlier violations are forgotten.
    """
    bare = holds
    holds, returned = np.repeat(holds, 2), np.repeat(returned, 2)
    fresh = np.zeros(len(holds), bool)
    fresh[starts] = True
    fresh |= (holds >= 0) & np.concatenate(([True], holds[:-1] < 0))
    decided = np.where(fresh, holds, np.where(returned == 1, 1, 0))
    latest = _latest(fresh | (returned == 1) | (holds != 1))
    result = np.where(holds < 0, holds, decided[np.maximum(latest, 0)]).astype(np.int8)
    before = shifted(result[1::2], bare)
    return Truth(result[::2], result[1::2], np.where(before < 0, bare, before))
