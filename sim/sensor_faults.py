"""Faults of the sensors beside their usual errors: silent, late, stuck, or one of them the wrong way round."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from controller.ports import Reading


@dataclass
class SensorFaults:
    """What is wrong with the sensors; at first nothing. Times are simulated (s).

    Args:
        silent_until_s: no reading is taken before.
        late_s: how long the next reading takes from its measurement until it is heard.
        stuck_until_s: until then readings are as the last one before.
        flipped: the sensors that read the opposite; by the names of the fields of `Reading`.
    """

    silent_until_s: float = 0.0
    late_s: float = 0.0
    stuck_until_s: float = 0.0
    flipped: set[str] = field(default_factory=set)
    _last: Reading | None = None

    def applied(self, reading: Reading, now_s: float) -> Reading:
        """What the sensors say instead of `reading`."""
        if now_s < self.stuck_until_s and self._last is not None:
            return self._last
        self._last = replace(reading, **{name: not getattr(reading, name) for name in self.flipped})
        return self._last

    def delay_s(self) -> float:
        """How late the next reading is; the ones after it are not."""
        late_s, self.late_s = self.late_s, 0.0
        return late_s
