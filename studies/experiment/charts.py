"""The experiment's pictures: coverage per test, change of Q, growth of coverage, and time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from studies.experiment.comparison import Method
from studies.original.published import HOUR_S, LEARNING_S, METHODS, TOLERANCE
from studies.original.runs import load_runs, method_of
from studies.plots import GREY, STYLES, Points, curves, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEAST_CHANGE = 1e-6
"""Changes of Q below this are drawn at it: what is less is rounding, and zero has no place on a logarithmic axis."""


def coverage(methods: Mapping[str, Method]) -> Figure:
    """Coverage per test in ascending order, ours and the original's."""
    made, (ours, theirs) = figure(panels=2)
    curves(
        ours,
        {method.published.title: _ascending(method.percents) for method in methods.values()},
        x="tests in ascending order of coverage (% of the suite's tests)",
        y="statements covered by the test (%)",
        drawn="steps-post",
    )
    recorded: dict[str, list[float]] = {name: [] for name in METHODS}
    for run in load_runs():
        recorded[method_of(run.suite)].append(run.coverage)
    curves(
        theirs,
        {METHODS[name].title: _ascending(sorted(values)) for name, values in recorded.items()},
        x="tests in ascending order of coverage (% of the suite's tests)",
        y="",
        drawn="steps-post",
    )
    for axes, title in ((ours, "here"), (theirs, "the original, as far as given")):
        axes.set_title(title)
        axes.set_ylim(20, 100)
        axes.set_xlim(0, 100)
        axes.legend(loc="lower right")
    return made


def _ascending(percents: tuple[float, ...] | list[float]) -> Points:
    """Points of a step curve: each value from its share of the tests to the next one's."""
    steps = [(100.0 * place / len(percents), value) for place, value in enumerate(percents)]
    return [*steps, (100.0, percents[-1])]


def learning(rl: Method) -> Figure:
    """The largest change of a cell of Q in each iteration."""
    made, (axes,) = figure()
    generation = rl.suite["generation"]
    changes = [(float(n), max(value, LEAST_CHANGE)) for n, value in enumerate(generation["q_delta"], 1)]
    curves(axes, {"": changes}, x="iteration", y="largest change of a cell of Q (reward units)", marker=".", ms=3)
    axes.set_yscale("log")
    axes.axhline(TOLERANCE, color=GREY, linewidth=1, linestyle=":")
    axes.annotate("stop: no cell changes by more", (1, TOLERANCE), (0, 4), textcoords="offset points", color=GREY)
    converged = generation["converged_at"]
    if converged is not None:
        axes.axvline(converged, color=GREY, linewidth=1, linestyle=":")
        axes.annotate(
            f"converged at {converged}",
            (converged, changes[0][1]),
            (-4, 0),
            textcoords="offset points",
            color=GREY,
            ha="right",
        )
    return made


def growth(methods: Mapping[str, Method]) -> Figure:
    """Plans and branches that so many tests cover together."""
    made, (branches, plans) = figure(panels=2)
    _growth(branches, methods, "branches", "branches of the code under test covered (number)")
    modelled = {name: method for name, method in methods.items() if method.suite["plans"]}
    _growth(plans, modelled, "plans", "plans of human and robot_code covered (number)")
    branches.set_title(f"{_of(methods, 'branches')} branches can be reached")
    totals = [sum(agent["total"] for agent in method.suite["plans"].values()) for method in modelled.values()]
    plans.set_title(f"{max(totals)} plans in the models")
    return made


def _of(methods: Mapping[str, Method], kind: str) -> int:
    (reachable,) = {method.suite["code"][kind]["reachable"] for method in methods.values()}
    return int(reachable)


def _growth(axes: Axes, methods: Mapping[str, Method], kind: str, y: str) -> None:
    lines = {
        method.published.title: [(point["tests"], point[kind]) for point in method.suite["curve"]]
        for method in methods.values()
    }
    curves(axes, lines, x="tests, in the order of their ids (number)", y=y, drawn="steps-post")
    axes.set_xscale("log")
    axes.set_ylim(bottom=0)
    axes.legend(loc="lower right")


def time(methods: Mapping[str, Method], workers: int) -> Figure:
    """How long learning and running took, here and originally."""
    made, (axes,) = figure()
    names = ["learning (BDI RL)", *(f"running {method.published.title}" for method in methods.values())]
    ours = [methods["rl"].suite["generation"]["wall_s"], *(method.busy_s / workers for method in methods.values())]
    theirs = [(LEARNING_S, LEARNING_S), *(method.running_s for method in methods.values())]
    rows = range(len(names))
    (here, _, dot), (then, _, square) = STYLES[0], STYLES[1]
    axes.plot(ours, rows, dot, color=here, label="here")
    axes.hlines(rows, [low for low, _ in theirs], [high for _, high in theirs], color=then, linewidth=2)
    axes.plot([(low * high) ** 0.5 for low, high in theirs], rows, square, color=then, label="published")
    axes.set_yticks(rows, names)
    axes.invert_yaxis()
    axes.set_xscale("log")
    marks = {1: "1 s", 10: "10 s", 60: "1 min", 600: "10 min", HOUR_S: "1 h", 10 * HOUR_S: "10 h"}
    axes.set_xticks(list(marks), list(marks.values()))
    axes.minorticks_off()
    axes.set_xlim(min(0.5, min(ours) / 1.5), 15 * HOUR_S)
    axes.set_xlabel("wall time (logarithmic)")
    axes.legend(loc="upper center")
    return made
