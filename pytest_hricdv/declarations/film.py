"""`Film` declares how a testbench is filmed: its camera, key moments and state. The feature `film` makes the films."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from pytest_hricdv.runtime.kernel import US_PER_S

if TYPE_CHECKING:
    from PIL.Image import Image

    from pytest_hricdv.monitor import Vocabulary
    from pytest_hricdv.runtime.world import Body


class Camera(Protocol):
    """Takes pictures of a world. It does not change the world, which stands still meanwhile."""

    def picture(self, *, fine: bool = False) -> Image:
        """The scene now, as an RGB picture that always has the same size.

        Returns the same object as the last call if nothing has moved since. `fine` pictures may be slow to render.
        """

    def close(self) -> None:
        """Release what the camera holds."""


@dataclass(frozen=True)
class Film:
    """How the runs of a testbench are filmed.

    Args:
        camera: makes a camera in the world of a run (`run.kernel.world`).
        moments: the key frames besides violation and end, in the order of an interaction: title -> the message, or the
            bool signal that becomes true, after which the frame is taken.
        state: the message and field with the robot's state, for instance "state.name"; empty: not shown.
        period_s: pictures are taken at multiples of this. Use the world's control period: the run then stops for
            pictures only where it stops anyway, and filming does not change it.
        bodies: gives the shapes in the world of a run now, for the 3-D scene of `--hri-mcap`; None: there is none.

    Raises:
        ValueError: a period that is not a positive number of microseconds.
    """

    camera: Callable[[Any], Camera]
    moments: Mapping[str, str] = field(default_factory=dict, hash=False)
    state: str = ""
    period_s: float = 0.05
    bodies: Callable[[Any], Sequence[Body]] | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.period_s) and self.period_us > 0):
            raise ValueError(f"period_s of a film is {self.period_s!r}: expected a microsecond or more")

    @property
    def period_us(self) -> int:
        """The period in whole microseconds."""
        return round(self.period_s * US_PER_S)

    def faults(self, vocabulary: Vocabulary, topics: Mapping[str, frozenset[str]]) -> list[str]:
        """Names in it that the testbench does not have, one message each.

        Args:
            vocabulary: the testbench's signals.
            topics: its messages, topic -> names of all fields.
        """
        flags = [name for name, kind in vocabulary.signals.items() if kind is bool]
        names = sorted([*topics, *flags])
        faults = [
            f"film moment {shown!r} comes with {event!r}, neither a message nor a bool signal; there are {names}"
            for shown, event in self.moments.items()
            if event not in names
        ]
        topic, _, name = self.state.partition(".")
        if self.state and name not in topics.get(topic, ()):
            fields = sorted(f"{topic}.{field}" for topic in topics for field in topics[topic])
            faults.append(f"film state is {self.state!r}, which is not a field of a message; there are {fields}")
        return faults
