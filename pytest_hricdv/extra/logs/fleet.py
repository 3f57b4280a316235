"""A fleet: what many logs show together, and how that compares with the tests of a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.extra.logs.judging import JudgedRun
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.results.model import Report

SHOWN = 8
"""Names of a difference that the terminal shows."""


@dataclass
class Fleet:
    """What logs show.

    Args:
        requirements: ids, in order.
        products: the cross products of the testbench.
        exempt: requirements that need not be checked.
    """

    requirements: Sequence[str]
    products: Mapping[str, CrossProduct]
    exempt: Collection[str] = ()
    runs: int = 0
    verdicts: dict[str, Counter[str]] = field(default_factory=dict)
    triggers: Counter[str] = field(default_factory=Counter)
    new_failures: int = 0
    hits: dict[str, dict[Bin, int]] = field(default_factory=dict)
    commands: set[str] = field(default_factory=set)
    faults: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.verdicts = {name: Counter() for name in self.requirements}

    def add(self, judged: JudgedRun, known: Mapping[str, str]) -> dict[str, tuple[Bin, ...]]:
        """Add a run; returns its hits of cross products, completed with its verdicts.

        Args:
            judged: the run.
            known: requirements whose violation is known.
        """
        self.runs += 1
        self.commands |= judged.commands
        for each in judged.verdicts:
            self.verdicts[each.requirement][each.verdict] += 1
            self.triggers[each.requirement] += sum(part.triggers for part in each.stretches)
            self.new_failures += each.verdict == "Failed" and not is_known(each.requirement, judged, known)
        words = {each.requirement: "NC" if each.verdict == "unknown" else each.verdict for each in judged.verdicts}
        bins: dict[str, tuple[Bin, ...]] = {}
        for name, found in judged.hits.items():
            checked = self.products[name].check(sorted(_without_verdicts(self.products[name], found, words)), words)
            self.faults += [f"{judged.run.name}: {name}: {fault}" for fault in checked.faults]
            bins[name] = tuple(dict.fromkeys(checked.bins))
            for hit in bins[name]:
                counts = self.hits.setdefault(name, {})
                counts[hit] = counts.get(hit, 0) + 1
        return bins

    @property
    def is_good(self) -> bool:
        """Whether each requirement has passed in a log, and no violation is new."""
        return not (self.new_failures or self.faults or self.gaps)

    @property
    def gaps(self) -> list[str]:
        """Requirements that were checked in no log, and are not exempt."""
        checked = {name for name, count in self.verdicts.items() if count["Passed"] + count["Failed"]}
        return [name for name in self.verdicts if name not in checked and name not in self.exempt]

    def lines(self) -> Iterator[str]:
        """For the terminal: requirements, and cross products."""
        words = ("Passed", "Failed", "NC", "unknown")
        yield f"\n  {'':<8}{''.join(f'{word:>9}' for word in words)} triggers"
        for name, count in self.verdicts.items():
            yield f"  {name:<8}{''.join(f'{count[word]:>9}' for word in words)}{self.triggers[name]:>9}"
        for name, hits in self.hits.items():
            possible = len(set(self.products[name].bins()) - self.products[name].impossible_bins.keys())
            yield f"  {name}: {len(hits)} of {possible} bins in the logs"
        yield from (f"  {fault}" for fault in self.faults)


def is_known(name: str, judged: JudgedRun, known: Mapping[str, str]) -> bool:
    """Whether the violations of a requirement in a run are known ones."""
    verdict = next(each for each in judged.verdicts if each.requirement == name)
    return name in known and not verdict.result.outside


def _without_verdicts(product: CrossProduct, hits: Iterable[Bin], verdicts: Mapping[str, str]) -> Iterator[Bin]:
    """Hits as a run reports them; a trace has them with the verdicts."""
    places = [place for place, name in enumerate(product.coordinates) if name not in verdicts]
    for hit in hits:
        yield tuple(hit[place] for place in places) if len(hit) == len(product.coordinates) else hit


@dataclass(frozen=True)
class FleetDifference:
    """What only tests have, or only logs: requirements that were triggered, bins that were hit, and commands."""

    requirements: tuple[str, ...]
    bins: Mapping[str, tuple[Bin, ...]]
    commands: tuple[str, ...]

    def lines(self, title: str) -> Iterator[str]:
        """For the terminal."""
        kinds = {"requirements": self.requirements, "actions": self.commands}
        kinds |= {f"bins of {name}": tuple(map(" x ".join, bins)) for name, bins in self.bins.items()}
        if not any(kinds.values()):
            yield f"  {title}: nothing"
        for kind, names in kinds.items():
            if names:
                more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
                yield f"  {title}: {len(names)} {kind}: {', '.join(names[:SHOWN])}{more}"

    @property
    def data(self) -> dict[str, Any]:
        """For JSON."""
        return {"requirements": self.requirements, "bins": self.bins, "actions": self.commands}


def compare(fleet: Fleet, report: Report) -> tuple[FleetDifference, FleetDifference]:
    """What the tests of a report show and no log does, and the other way round.

    Actions are compared where the map says what they are in a log.
    """
    runs = [run for test in report.tests for run in test.runs]
    triggered = {name for run in runs for name, result in run.requirements.items() if result.triggers}
    seen = {name for name, count in fleet.triggers.items() if count}
    bins = {name: {hit for run in runs for hit in (run.cross or {}).get(name, ())} for name in fleet.products}
    logged = {name: set(fleet.hits.get(name, {})) for name in fleet.products}
    commands = {line for run in runs for line in run.abstract} if fleet.commands else set()
    here = [name for name in fleet.requirements if name in report.requirements]
    return (
        FleetDifference(
            tuple(name for name in here if name in triggered - seen),
            _bins_of_first(bins, logged),
            tuple(sorted(commands - fleet.commands, key=natural)),
        ),
        FleetDifference(
            tuple(name for name in here if name in seen - triggered),
            _bins_of_first(logged, bins),
            tuple(sorted(fleet.commands - commands, key=natural)),
        ),
    )


def _bins_of_first(first: Mapping[str, set[Bin]], second: Mapping[str, set[Bin]]) -> dict[str, tuple[Bin, ...]]:
    """The bins that only the first have; of products that neither hits, nothing."""
    found = {name: tuple(sorted(bins - second[name])) for name, bins in first.items()}
    return {name: bins for name, bins in found.items() if bins}
