"""The survey of a model: every abstract test that its belief sets can come to, and the plans on the way.

A belief set that counts has one start belief and any of the others. Where the BDI engine can tell runs apart piece by
piece, runs are surveyed without trying all sets; a small space is tried set by set; of others nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

from .error import GenerateError

if TYPE_CHECKING:
    from .explorer import Explorer

SCHEMA = "hricdv-survey/1"
MAX_OTHERS = 9
"""A space with at most so many beliefs beside the start beliefs is tried set by set: 512 runs for each of these."""
TOO_LARGE = "too large: the model has too many different runs"
NOT_APART = "too large: the model's runs cannot be told apart piece by piece, and there are too many sets of beliefs"
_FIRST = ord("0")
"""Commands are kept as single characters, from this one on: none of these is a comma or ends a line."""


class SurveyedRun(NamedTuple):
    """A run of the model; a named tuple because there are thousands.

    Args:
        lines: its abstract test.
        plans: the coverage plans executed, as bits.
        beliefs: the smallest belief set found for it, as bits.
    """

    lines: tuple[str, ...]
    plans: int
    beliefs: int


@dataclass(frozen=True)
class Survey:
    """All runs, or the reason why they are not known.

    Args:
        plans: agent and label of each coverage plan, by the number of its bit.
        beliefs: the beliefs, by the number of their bit.
        runs: those with few beliefs first.
        reason: why these are not all runs; empty if they are.
    """

    plans: tuple[tuple[str, str], ...] = ()
    beliefs: tuple[str, ...] = ()
    runs: tuple[SurveyedRun, ...] = ()
    reason: str = ""

    @property
    def proven(self) -> bool:
        """Whether these are all runs that there are."""
        return not self.reason

    def chosen(self, bits: int) -> tuple[str, ...]:
        """The beliefs of a set, in declared order."""
        return tuple(belief for place, belief in enumerate(self.beliefs) if bits >> place & 1)

    def to_json(self) -> dict[str, Any]:
        """Plain data for a cache."""
        commands = sorted({line for run in self.runs for line in run.lines})
        signs = {line: chr(_FIRST + place) for place, line in enumerate(commands)}
        runs = [f"{''.join([signs[line] for line in run.lines])},{run.plans:x},{run.beliefs:x}" for run in self.runs]
        texts = {"schema": SCHEMA, "reason": self.reason, "commands": commands, "runs": "\n".join(runs)}
        return {**texts, "plans": [list(plan) for plan in self.plans], "beliefs": list(self.beliefs)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Survey:
        """What `to_json` gave.

        Raises:
            GenerateError: it is of another version, or incomplete.
        """
        try:
            if data["schema"] != SCHEMA:
                raise GenerateError(f"a survey of schema {data['schema']!r}; expected {SCHEMA!r}")
            signs = {chr(_FIRST + place): line for place, line in enumerate(data["commands"])}
            runs = []
            for text in data["runs"].split("\n") if data["runs"] else ():
                lines, plans, beliefs = text.split(",")
                runs.append(SurveyedRun(tuple([signs[sign] for sign in lines]), int(plans, 16), int(beliefs, 16)))
            known = tuple((agent, label) for agent, label in data["plans"])
            return cls(known, tuple(data["beliefs"]), tuple(runs), data["reason"])
        except (KeyError, AttributeError, TypeError, ValueError) as error:
            raise GenerateError(f"a survey that cannot be read: {error!r}") from None


def survey(explorer: Explorer) -> Survey:
    """Survey a model.

    Raises:
        GenerateError: the model fails.
    """
    from pytest_hricdv.bdi import TooLargeError

    plans = tuple((agent, label) for agent, labels in explorer.plan_labels.items() for label in labels)
    beliefs = explorer.space.beliefs
    bit = {belief: 1 << place for place, belief in enumerate(beliefs)}
    try:
        found = explorer.every_run(plans)
    except TooLargeError:
        return Survey(plans, beliefs, reason=TOO_LARGE)
    if found is None:
        if len(explorer.space.others) > MAX_OTHERS:
            return Survey(plans, beliefs, reason=NOT_APART)
        found = list(_tried(explorer, plans))
    runs = [SurveyedRun(lines, mask, sum([bit[belief] for belief in chosen])) for lines, mask, chosen in found]
    runs.sort(key=lambda run: (run.beliefs.bit_count(), run.beliefs, run))
    return Survey(plans, beliefs, tuple(runs))


def _tried(
    explorer: Explorer, plans: tuple[tuple[str, str], ...]
) -> Iterator[tuple[tuple[str, ...], int, Iterable[str]]]:
    """Each run once, tried with all belief sets, the smallest first."""
    seen: set[tuple[tuple[str, ...], int]] = set()
    others = explorer.space.others
    for size in range(len(others) + 1):
        for start in explorer.space.start:
            for chosen in combinations(others, size):
                run = explorer.explore((start, *chosen))
                mask = sum(1 << place for place, (agent, label) in enumerate(plans) if label in run.plans[agent])
                if (run.lines, mask) not in seen:
                    seen.add((run.lines, mask))
                    yield run.lines, mask, run.beliefs
