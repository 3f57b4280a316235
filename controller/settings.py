"""What can be set about a handover, with the values that the robot runs with."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Settings:
    """Numbers of one run. Raises ValueError for a number that makes no sense.

    `sensing_timeout_s` is drawn once per run by whoever starts the controller, from 10 to 100 s.
    """

    turns: int = 4
    max_speed_rad_s: float = 0.25
    receive_polls: int = 60
    request_poll_s: float = 0.05
    ready_poll_s: float = 0.25
    settle_s: float = 2.0
    sensing_timeout_s: float = 30.0
    close_attempts: int = 2
    retry_s: float = 3.0
    on_time_s: float = 300.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0 < value < math.inf:
                raise unfit(field.name, value, "a number above 0")  # unreachable: the testbench sets what makes sense
            if isinstance(field.default, int) and value != int(value):
                raise unfit(field.name, value, "a whole number")  # unreachable: the testbench sets what makes sense


def unfit(name: str, value: object, expected: str) -> ValueError:
    """The error for a number that makes no sense."""
    return ValueError(f"{name} is {value!r}: expected {expected}")  # unreachable: the testbench sets what makes sense
