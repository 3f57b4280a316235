"""Exhaustive exploration of a model: every abstract test that a belief set can give, with the plans executed.

The belief sets are those with one start belief and any of the others. If the BDI engine can enumerate the runs of the
model, not all sets have to be run; otherwise a small space is explored set by set, and a large one is not explored.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.model import ExploredRun

if TYPE_CHECKING:
    from pytest_hricdv.generate.model_runner import ModelRunner

SCHEMA = "hricdv-exploration/1"
MAX_OTHERS = 9
"""A space with at most this many beliefs beside the start beliefs is explored set by set: 512 runs per start belief."""
TOO_LARGE = "too large: the model has too many different runs"
NOT_ENUMERABLE = (
    "too large: the model's runs cannot be told apart piece by piece, and there are too many sets of beliefs"
)
_FIRST_CODE = ord("0")
"""In the cache, commands are single characters from this one on: none of these is a comma or ends a line."""


@dataclass(frozen=True)
class Exploration:
    """All runs of the model, or the reason why they are not known.

    Args:
        plans: agent and label of each coverage plan, by the number of its bit.
        beliefs: the beliefs, by the number of their bit.
        runs: those with few beliefs first.
        reason: why these are not all runs; empty if they are.
    """

    plans: tuple[tuple[str, str], ...] = ()
    beliefs: tuple[str, ...] = ()
    runs: tuple[ExploredRun, ...] = ()
    reason: str = ""

    @property
    def complete(self) -> bool:
        """Whether these are all runs that exist."""
        return not self.reason

    def belief_set(self, bits: int) -> tuple[str, ...]:
        """The beliefs of a set, in declared order."""
        return tuple(belief for place, belief in enumerate(self.beliefs) if bits >> place & 1)

    def to_json(self) -> dict[str, Any]:
        """Plain data for a cache."""
        commands = sorted({line for run in self.runs for line in run.lines})
        codes = {line: chr(_FIRST_CODE + place) for place, line in enumerate(commands)}
        runs = [f"{''.join([codes[line] for line in run.lines])},{run.plans:x},{run.beliefs:x}" for run in self.runs]
        texts = {"schema": SCHEMA, "reason": self.reason, "commands": commands, "runs": "\n".join(runs)}
        return {**texts, "plans": [list(plan) for plan in self.plans], "beliefs": list(self.beliefs)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Exploration:
        """The exploration that `to_json` gave.

        Raises:
            GenerateError: it is of another version, or incomplete.
        """
        try:
            if data["schema"] != SCHEMA:
                raise GenerateError(f"an exploration of schema {data['schema']!r}; expected {SCHEMA!r}")
            commands = {chr(_FIRST_CODE + place): line for place, line in enumerate(data["commands"])}
            runs = []
            for text in data["runs"].split("\n") if data["runs"] else ():
                lines, plans, beliefs = text.split(",")
                runs.append(ExploredRun(tuple([commands[code] for code in lines]), int(plans, 16), int(beliefs, 16)))
            known = tuple((agent, label) for agent, label in data["plans"])
            return cls(known, tuple(data["beliefs"]), tuple(runs), data["reason"])
        except (KeyError, AttributeError, TypeError, ValueError) as error:
            raise GenerateError(f"an exploration that cannot be read: {error!r}") from None


def explore_exhaustively(runner: ModelRunner) -> Exploration:
    """Find all runs of a model.

    Raises:
        GenerateError: the model fails.
    """
    from pytest_hricdv.bdi import TooLargeError

    plans = tuple((agent, label) for agent, labels in runner.plan_labels.items() for label in labels)
    beliefs = runner.space.beliefs
    try:
        runs = runner.all_runs(plans)
    except TooLargeError:
        return Exploration(plans, beliefs, reason=TOO_LARGE)
    if runs is None:
        if len(runner.space.others) > MAX_OTHERS:
            return Exploration(plans, beliefs, reason=NOT_ENUMERABLE)
        runs = list(_set_by_set(runner, plans))
    runs.sort(key=lambda run: (run.beliefs.bit_count(), run.beliefs, run))
    return Exploration(plans, beliefs, tuple(runs))


def _set_by_set(runner: ModelRunner, plans: tuple[tuple[str, str], ...]) -> Iterator[ExploredRun]:
    """Each distinct run once, by running all belief sets, the smallest first."""
    seen: set[tuple[tuple[str, ...], int]] = set()
    others, bits = runner.space.others, runner.space.bits
    for size in range(len(others) + 1):
        for start in runner.space.start:
            for chosen in combinations(others, size):
                run = runner.run((start, *chosen))
                mask = sum(1 << place for place, (agent, label) in enumerate(plans) if label in run.plans[agent])
                if (run.lines, mask) not in seen:
                    seen.add((run.lines, mask))
                    yield ExploredRun(run.lines, mask, sum(bits[belief] for belief in run.beliefs))
