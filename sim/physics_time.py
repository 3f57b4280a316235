"""The time of physics: whole steps of 1/120 s, next to the kernel's microseconds. See docs/convergence.md."""

from __future__ import annotations

from dataclasses import dataclass

STEP_HZ = 120
"""Physics steps a second: measured joint speeds equal the planned ones (tests/sim/test_robot.py)."""

STEP_S = 1.0 / STEP_HZ
TICK_HZ = 20
TICK_STEPS = STEP_HZ // TICK_HZ
"""Control and sensing every so many steps."""

_US_PER_S = 1_000_000


def steps_until(time_us: int) -> int:
    """Number of whole steps that lie before or at a time (us): integers only, so nothing drifts."""
    return time_us * STEP_HZ // _US_PER_S


def time_of(step: int) -> int:
    """First whole microsecond at which a step is over."""
    return -(-step * _US_PER_S // STEP_HZ)


@dataclass
class PhysicsTime:
    """Where physics stands: `step` steps done or passed over, `now_us` the simulated time reached (us)."""

    step: int = 0
    now_us: int = 0

    @property
    def now_s(self) -> float:
        """Simulated time, in seconds."""
        return self.now_us / 1_000_000

    def step_in(self, duration_s: float) -> int:
        """The first step that ends at least `duration_s` from now."""
        return self.step + max(1, -int(-duration_s * STEP_HZ // 1))
