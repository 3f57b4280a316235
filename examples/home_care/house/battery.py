"""The battery: linear, as nobody needs more of it."""

from __future__ import annotations

import math

LASTS_S = 4.5 * 3600.0
"""From full to empty (chosen: makers name 4 to 5 hours)."""

CHARGES_S = 2.0 * 3600.0
"""From empty to full (chosen)."""

GRAIN = 0.01
"""Requirements see its level in steps of this, so that time may jump in between."""


class Battery:
    """Its level, 0 to 1; it is charged while the robot stands at its charger."""

    def __init__(self, level: float) -> None:
        self.level = level
        self.charging = False

    def step(self, duration_s: float) -> None:
        """Let time pass."""
        per_s = 1.0 / CHARGES_S if self.charging else -1.0 / LASTS_S
        self.level = min(1.0, max(0.0, self.level + per_s * duration_s))

    @property
    def shown(self) -> float:
        """The level as requirements see it."""
        return round(math.floor(self.level / GRAIN + 1e-9) * GRAIN, 2)

    def changes_in_s(self) -> float:
        """How long `shown` stays as it is (s); infinite where it does."""
        if self.charging:
            return math.inf if self.level >= 1.0 else max(0.0, self.shown + GRAIN - self.level) * CHARGES_S
        return math.inf if self.shown <= 0.0 else (self.level - self.shown + 1e-10) * LASTS_S
