"""`suite_figures`: a suite's coverage, and how it was generated, as labels and texts for `terminal` and `html`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.coverage.cross_product import CrossCoverage
from pytest_hricdv.coverage.records import CodeCoverage
from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import Style, percent, plural, seconds, share
from pytest_hricdv.results.model import Report, SuiteResult
from pytest_hricdv.results.origin import Diversity, GenerationResult


@dataclass(frozen=True)
class SuiteFigure:
    """A figure with its label; `style` is "dim" for those on the generation of the suite."""

    label: str
    text: str
    style: Style = "plain"


def suite_figures(report: Report, suite: SuiteResult) -> Iterator[SuiteFigure]:
    """The figures of a suite in the order in which they are shown."""
    yield _code("statements", suite.code.statements, report)
    yield _code("branches", suite.code.branches, report)
    for agent in sorted(suite.plans):
        covered, total = len(suite.plans[agent].covered), suite.plans[agent].total
        yield SuiteFigure(f"plans of {agent}", f"{percent(share(covered, total))} ({covered} of {total})")
    if suite.cross.bins:
        yield SuiteFigure("cross product", _cross(suite.cross))
    generation = suite.generation
    yield SuiteFigure("Q-learning" if generation.iterations else "generation", _effort(generation), "dim")
    yield SuiteFigure("diversity", _diversity(generation.diagnosis), "dim")
    for note in generation.notes:
        yield SuiteFigure("note", note, "warn")


def _code(kind: str, coverage: CodeCoverage | None, report: Report) -> SuiteFigure:
    if coverage is None:
        return SuiteFigure(kind, f"unmeasured: {totals.explain_no_coverage(report)}", "warn")
    of_total = f"{percent(coverage.percent)} ({coverage.covered} of {coverage.total})"
    waived = len(totals.waivers(report)) if kind == "statements" else 0
    if coverage.reachable == coverage.total:
        return SuiteFigure(kind, of_total)
    reachable = f"{coverage.reachable} reachable" + (f", {waived} waived" if waived else "")
    return SuiteFigure(kind, f"{of_total}, {percent(coverage.percent_reachable)} of {reachable}")


def _cross(cross: CrossCoverage) -> str:
    text = f"{percent(totals.bins_covered(cross))} ({cross.hit} of {plural(cross.possible, 'bin')})"
    return f"{text}, {cross.impossible} impossible" if cross.impossible else text


def _effort(generation: GenerationResult) -> str:
    """`converged after 115 of 119 iterations (2140 model runs, 130 distinct tests), 3.1 s`."""
    counts = [plural(generation.bdi_runs, "model run")] if generation.bdi_runs else []
    counts += [plural(generation.distinct_texts, "distinct test")] if generation.distinct_texts else []
    time = "cached" if generation.cached else seconds(generation.wall_s)
    if not generation.iterations:
        return ", ".join([*counts, time])
    at, iterations = generation.converged_at, plural(generation.iterations, "iteration")
    learning = f"not converged after {iterations}" if at is None else f"converged after {at} of {iterations}"
    return f"{learning} ({', '.join(counts)}), {time}"


def _diversity(diversity: Diversity) -> str:
    """`entropy 5.05/5.21 bits over 134 belief sets; last new plan at iteration 94, test 23`."""
    last = diversity.last_new_plan
    ends = [f"{name} {number}" for name, number in (("iteration", last.iteration), ("test", last.test)) if number]
    plans = f"last new plan at {', '.join(ends)}" if ends else "no plans of a model"
    if not diversity.distinct_subsets:
        return plans
    bits, max_bits = diversity.belief_entropy_bits, diversity.belief_entropy_most_bits
    return f"entropy {bits:.2f}/{max_bits:.2f} bits over {plural(diversity.distinct_subsets, 'belief set')}; {plans}"
