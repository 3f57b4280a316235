"""The battery: linear, as nobody needs more of it."""

from __future__ import annotations

import math

LASTS_S = 4.5 * 3600.0
"""From full to empty (chosen: makers name 4 to 5 hours)."""

CHARGES_S = 2.0 * 3600.0
"""From empty to full (chosen)."""

GRAIN = 0.01
"""Requirements see its level in steps of this, so that time may jump in between."""

_ROUNDING = 1e-10
"""Of a level: what is this near to a step is on it."""


class Battery:
    """It is charged while the robot stands at its charger.

    Its level is computed from when it was last plugged in or out: it does not depend on how often somebody looks.

    Args:
        level: at the beginning, 0 to 1.
    """

    def __init__(self, level: float) -> None:
        self._then, self._then_us, self._charging = level, 0, False

    def level(self, now_us: int) -> float:
        """How full it is, 0 to 1."""
        rate = 1.0 / CHARGES_S if self._charging else -1.0 / LASTS_S
        return min(1.0, max(0.0, self._then + rate * (now_us - self._then_us) / 1e6))

    def plug(self, now_us: int, *, charging: bool) -> None:
        """From now on it is charged, or not."""
        if charging != self._charging:
            self._then, self._then_us, self._charging = self.level(now_us), now_us, charging

    def is_at(self, level: float, now_us: int) -> None:
        """It is this full now, whatever it was before."""
        self._then, self._then_us = level, now_us

    def shown(self, now_us: int) -> float:
        """The level as requirements see it."""
        return round(math.floor((self.level(now_us) + _ROUNDING) / GRAIN) * GRAIN, 2)

    def changes_us(self, now_us: int) -> float:
        """When `shown` is another one (us), if nobody plugs it in or out; infinity: never."""
        shown = self.shown(now_us)
        if self._charging:
            due_s = (shown + GRAIN - self._then - 0.99 * _ROUNDING) * CHARGES_S if shown < 1.0 else math.inf
        else:
            due_s = (self._then - shown + 1.01 * _ROUNDING) * LASTS_S if shown > 0.0 else math.inf
        return math.inf if due_s == math.inf else max(now_us + 1, self._then_us + math.ceil(due_s * 1e6))
