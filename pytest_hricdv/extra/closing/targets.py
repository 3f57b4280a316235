"""The targets, the points that are to be hit: of the code, the model, the cross products and the requirements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.coverage.reachability import Reachability
from pytest_hricdv.extra.closing.observation import code_points
from pytest_hricdv.extra.closing.records import ImpossiblePoint
from pytest_hricdv.generate.abstract import Plans
from pytest_hricdv.monitor import Criterion, Requirement
from pytest_hricdv.monitor.analysis import conjuncts


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
        code: under test; None where it is not measured.
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
        *(_waived(code) if code is not None else ()),
        *_unreachable_plans(plans, reachability),
        *_impossible_bins(cross, reachability),
    )


def by_kind(points: Iterable[Point]) -> Counter[str]:
    """How many points there are of each kind."""
    return Counter(point[0] for point in points)


def _of_code(code: CodeMap) -> Iterator[Point]:
    waived = code.waived()
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


def _waived(code: CodeMap) -> Iterator[ImpossiblePoint]:
    reasons = {(waiver.file, str(waiver.line)): waiver.reason for waiver in code.waivers}
    for point in code_points(code, code.waived()):
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
