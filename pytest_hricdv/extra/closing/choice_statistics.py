"""What has come of the choices of people who decided during their runs, coordinate by coordinate of the bins."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Entry
from pytest_hricdv.extra.closing.interactions import Planned, commands_of, starts_of
from pytest_hricdv.online.chooser import ANY_STATE

DOUBT = 2.0
"""So many interactions with what is usual are added to those that an option was seen in. Chosen; its effect was not
measured."""

LARGEST_LIFT = 20.0
"""No option is more than so many times as likely to lead to a bin as any, and none less than a fraction of that.
Chosen: a product of ratios of few interactions would grow without bound; its effect was not measured."""

Option = tuple[str, str, str]
"""State of the code, what was decided, and the option."""


@dataclass
class _Seen:
    """How often an option was chosen, and the coordinates of the bins that its interactions hit."""

    times: int = 0
    hits: Counter[str] = field(default_factory=Counter)
    """Cross product -> bins."""
    coordinates: Counter[tuple[str, int, str]] = field(default_factory=Counter)
    """Cross product, place and value of a coordinate -> bins."""

    def add(self, product: str, bin_: tuple[str, ...]) -> None:
        self.hits[product] += 1
        self.coordinates.update((product, place, value) for place, value in enumerate(bin_))


class ChoiceStatistics:
    """Learns from runs.

    Args:
        planned: `planned` of each cross product that has it: it tells interactions apart.
    """

    def __init__(self, planned: Mapping[str, Planned]) -> None:
        self._planned = dict(planned)
        self._all = _Seen()
        self._of: dict[Option, _Seen] = {}

    @property
    def places(self) -> tuple[tuple[str, str], ...]:
        """The states in which something was chosen, and what it was about."""
        return tuple(dict.fromkeys((state, about) for state, about, _ in self._of))

    def learn(self, entry: Entry) -> None:
        """Note what came of each choice of a run: the bins of its interaction."""
        lines, hits = entry.test.lines, entry.observation.hits
        commands = commands_of(lines)
        for product, planned in self._planned.items():
            first = starts_of(commands, planned)
            for number, hit in enumerate(hits.get(product, ())):
                self._all.add(product, hit)
                for choice in entry.observation.choices:
                    done = len(commands_of(lines[: choice.taken]))
                    if max(bisect_right(first, done) - 1, 0) == number:
                        for seen in self._seen(choice.state, choice.about, choice.option):
                            seen.add(product, hit)
        for choice in entry.observation.choices:
            for seen in self._seen(choice.state, choice.about, choice.option):
                seen.times += 1

    def times(self, option: Option) -> int:
        """How often an option was chosen."""
        return self._of[option].times if option in self._of else 0

    def lift(self, option: Option, target: Point) -> float:
        """How much likelier the target is with this option than in general, as if its coordinates were independent.

        1 for what nothing is known about, and for other points than bins.
        """
        seen = self._of.get(option)
        kind, product, *bin_ = target
        if seen is None or kind != "bin" or not seen.hits[product]:
            return 1.0
        lift = 1.0
        for place, value in enumerate(bin_):
            key = product, place, value
            # Laplace's rule of succession: as if it had come in one of two interactions more.
            usual = (self._all.coordinates[key] + 1.0) / (self._all.hits[product] + 2.0)
            lift *= (seen.coordinates[key] + DOUBT * usual) / (seen.hits[product] + DOUBT) / usual
        return min(max(lift, 1.0 / LARGEST_LIFT), LARGEST_LIFT)

    def _seen(self, state: str, about: str, option: str) -> list[_Seen]:
        keys = dict.fromkeys([(state, about, option), (ANY_STATE, about, option)])
        return [self._of.setdefault(key, _Seen()) for key in keys]
