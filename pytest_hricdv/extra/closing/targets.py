"""Targets: the points to be hit, of the code, the model, the cross products and the requirements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.coverage.reachability import Reachability
from pytest_hricdv.extra.closing.archive import GIVEN, Archive
from pytest_hricdv.extra.closing.observation import code_points
from pytest_hricdv.extra.closing.records import ClosingEnd, ImpossiblePoint
from pytest_hricdv.generate.abstract import Plans
from pytest_hricdv.monitor import Criterion, Requirement
from pytest_hricdv.monitor.analysis import conjuncts
from pytest_hricdv.session.collection import Collection


def target_points(
    code: CodeMap | None,
    plans: Plans,
    cross: Mapping[str, CrossProduct],
    reachability: Reachability,
    requirements: Iterable[Criterion],
    transitions: Iterable[tuple[str, str]] = (),
) -> tuple[Point, ...]:
    """All points that are to be hit, without those that are waived, forbidden, or proved impossible by the model.

    Args:
        code: under test; None if it is not measured.
        plans: the coverage plans, by agent.
        cross: the cross products.
        reachability: what exploring the model has shown.
        requirements: each of which is to be checked at least once with the result Passed, and each conjunct of whose
            antecedent is to be true and false.
        transitions: of the state of the code under test.
    """
    return (
        *(_of_code(code) if code is not None else ()),
        *_of_plans(plans, reachability),
        *_of_requirements(tuple(requirements)),
        *(("transition", *transition) for transition in transitions),
        *_of_cross(cross, reachability),
    )


def impossible_points(
    code: CodeMap | None, plans: Plans, cross: Mapping[str, CrossProduct], reachability: Reachability
) -> tuple[ImpossiblePoint, ...]:
    """The points that are waived, declared impossible, or proved impossible by the model. Arguments as above."""
    return (
        *(_waivers(code) if code is not None else ()),
        *_unreachable_plans(plans, reachability),
        *_impossible_bins(cross, reachability),
    )


def by_kind(points: Iterable[Point]) -> Counter[str]:
    """The number of points of each kind."""
    return Counter(point[0] for point in points)


def _of_code(code: CodeMap) -> Iterator[Point]:
    waived = code.waiver_bits()
    statements, branches = (1 << code.statements) - 1, (1 << code.branches) - 1
    return code_points(code, Bits(statements & ~waived.statements, branches & ~(waived.branches or 0)))


def _of_requirements(requirements: Sequence[Criterion]) -> Iterator[Point]:
    yield from (("verdict", requirement.id, "Passed") for requirement in requirements)
    for requirement in requirements:
        if isinstance(requirement, Requirement):
            for conjunct in dict.fromkeys(map(str, conjuncts(requirement.formula.antecedent))):
                yield from (("condition", requirement.id, conjunct, outcome) for outcome in ("true", "false"))


def _of_plans(plans: Plans, reachability: Reachability) -> Iterator[Point]:
    explored = reachability.exploration
    for agent, labels in plans.items():
        for label in labels:
            if explored.status != "proven" or label in (explored.plans or {}).get(agent, {}):
                yield "plan", agent, label


def _waivers(code: CodeMap) -> Iterator[ImpossiblePoint]:
    reasons = {(waiver.file, str(waiver.line)): waiver.reason for waiver in code.waivers}
    for point in code_points(code, code.waiver_bits()):
        lines = [(point[1], line) for line in point[2:] if (point[1], line) in reasons]
        yield ImpossiblePoint(point=point, reason=reasons[lines[0]], by="waived")


def _unreachable_plans(plans: Plans, reachability: Reachability) -> Iterator[ImpossiblePoint]:
    explored = reachability.exploration
    reason = f"none of the model's {explored.runs} runs executes it"
    for agent, labels in plans.items():
        for label in labels:
            if explored.status == "proven" and label not in (explored.plans or {}).get(agent, {}):
                yield ImpossiblePoint(point=("plan", agent, label), reason=reason, by="model")


def _impossible_bins(cross: Mapping[str, CrossProduct], reachability: Reachability) -> Iterator[ImpossiblePoint]:
    for name, product in cross.items():
        for excluded in reachability.products[name].impossible:
            if excluded.bin not in product.forbidden:
                yield ImpossiblePoint(point=("bin", name, *excluded.bin), reason=excluded.reason, by=excluded.by)


def _of_cross(cross: Mapping[str, CrossProduct], reachability: Reachability) -> Iterator[Point]:
    for name, product in cross.items():
        impossible = {excluded.bin for excluded in reachability.products[name].impossible}
        for bin_ in product.bins():
            if bin_ not in impossible and bin_ not in product.forbidden:
                yield ("bin", name, *bin_)


STEPS = 10
"""Progress messages of a loop where no terminal can rewrite a line."""


def list_open(archive: Archive) -> str:
    """`12 statements, 3 branches`: what is open."""
    return ", ".join(count_texts(by_kind(archive.open))) or "nothing"


def progress_texts(done: int, runs: int, sim_s: float, open_counts: Mapping[str, int]) -> list[str]:
    """The progress of a loop, the fullest text first: for narrow terminals, each next one leaves out a less important
    part.

    First the simulated time, then one kind of open point after the other, of which the number stays.
    """
    start, named = f"hricdv: {done} of {runs} runs", count_texts(open_counts)
    if not named:
        return [f"{start}, {sim_s:.0f} s simulated, open: nothing", f"{start}, open: nothing", start]
    counts = list(open_counts.values())
    fewer = [", ".join([*named[:shown], f"{sum(counts[shown:])} more"]) for shown in range(len(named) - 1, 0, -1)]
    whole = ", ".join(named)
    opened = [f"{start}, open: {text}" for text in (whole, *fewer, str(sum(counts)))]
    return [f"{start}, {sim_s:.0f} s simulated, open: {whole}", *opened, start]


def count_texts(counts: Mapping[str, int]) -> list[str]:
    """`12 statements`, `1 branch`: the numbers of points by kind."""
    return [f"{count} {kind if count == 1 else _PLURAL.get(kind, f'{kind}s')}" for kind, count in counts.items()]


_PLURAL = {"branch": "branches"}


class ClosingProgress:
    """Tells how far the loop is."""

    def __init__(self, collection: Collection, runs: int) -> None:
        self._collection = collection
        self._runs = runs
        self._told = 0

    def show(self, archive: Archive) -> None:
        """Show the progress after a generation."""
        done = sum(entry.strategy != GIVEN for entry in archive.entries)
        texts = progress_texts(done, self._runs, archive.sim_s, by_kind(archive.open))
        if not self._collection.rewrite(texts) and done * STEPS // self._runs > self._told:
            self._told = done * STEPS // self._runs
            self._collection.say(texts[0])

    def end(self, archive: Archive, ended: ClosingEnd, faults: Sequence[str], tests: int, *, goes_on: bool) -> None:
        """End the display. `goes_on`: its tests run now."""
        done = sum(entry.strategy != GIVEN for entry in archive.entries)
        self._collection.say(
            f"hricdv: closing ended ({ended}) after {done} runs, {archive.sim_s:.0f} s simulated; "
            f"open: {list_open(archive)}; {tests} tests"
        )
        for fault in faults:
            self._collection.say(f"hricdv: {fault}")
        if ended == "interrupted" and goes_on:
            self._collection.say("hricdv: what was reached until Ctrl-C is kept and runs now; Ctrl-C again ends all")
