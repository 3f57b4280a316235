"""Which parameters matter to a margin: what the runs of a search show that differ in few parameters from another one.

A test has dozens of parameters, and a requirement depends on few: a step that changes the others is a run for nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container

from pytest_hricdv.extra.closing.archive import Archive, Entry
from pytest_hricdv.generate.concrete import ConcreteTest

Parameter = tuple[str, str]
"""The command whose parameter it is, empty for one of the run, and its name."""

SAME = 0.001
"""A margin that changes by less than this share of how much margins of runs differ has not changed. Chosen: physics
changes each a little; its effect was not measured."""

PRIOR = 0.5
"""So many changes are thought to have had an effect before any was seen. Chosen; its effect was not measured."""


def values(test: ConcreteTest) -> dict[tuple[int, Parameter], float]:
    """The parameters of a test, by the number of their action (0 is the run)."""
    actions = [("", test.run), *((action.command, action.parameters) for action in test.actions)]
    return {
        (number, (command, name)): value
        for number, (command, parameters) in enumerate(actions)
        for name, value in parameters.items()
    }


class Relevance:
    """See the module.

    Args:
        way: whose runs differ little from others.
        concrete: the concrete test of a run.
    """

    def __init__(self, way: str, concrete: Callable[[Entry], ConcreteTest]) -> None:
        self._way = way
        self._concrete = concrete
        self._read = 0
        self._alike: dict[tuple[tuple[str, ...], int], list[Entry]] = {}
        self._pairs: list[tuple[Entry, Entry, list[Parameter]]] = []
        """Each run of the way with the earlier one that differs in the fewest parameters, and these."""

    def read(self, archive: Archive) -> None:
        """Learn what runs differ in that have come since."""
        for run in archive.entries[self._read :]:
            before = self._alike.setdefault((run.test.lines, run.test.seed), [])
            if run.way == self._way and before:
                nearest = min((self._changed(run, other) for other in before), key=lambda pair: len(pair[2]))
                self._pairs += [nearest] if nearest[2] else []
            before.append(run)
        self._read = len(archive.entries)

    def _changed(self, run: Entry, other: Entry) -> tuple[Entry, Entry, list[Parameter]]:
        mine, theirs = values(self._concrete(run)), values(self._concrete(other))
        return run, other, [at[1] for at, value in theirs.items() if value != mine[at]]

    def of(self, requirement: str, spread: float, without: Container[int] = ()) -> Callable[[Parameter], float]:
        """How often a change of a parameter changes the margin of a requirement, from 0 to 1; 1 of what nobody changed.

        Args:
            spread: by how much margins of runs differ.
            without: numbers of runs that are left out.
        """
        changes, effects = Counter[Parameter](), dict[Parameter, float]()
        for child, parent, changed in self._pairs:
            margins = [run.observation.margins.get(requirement) for run in (child, parent) if run.number not in without]
            if len(margins) < 2 or None in margins:
                continue
            changes.update(changed)
            if abs((margins[0] or 0.0) - (margins[1] or 0.0)) > SAME * spread:
                for parameter in changed:
                    effects[parameter] = effects.get(parameter, 0.0) + 1.0 / len(changed)
        return lambda parameter: min(1.0, (effects.get(parameter, 0.0) + PRIOR) / (changes[parameter] + PRIOR))
