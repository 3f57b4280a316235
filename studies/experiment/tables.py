"""The tables of the experiment's page."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from studies.experiment.comparison import Method, RequestStatistics
from studies.original.published import LEARNING_S
from studies.page import duration, interval, percent, table

REQUIREMENTS = ("R1", "R2", "R3", "R4")
AS_PRINTED = "R3 by-hand"
"""Marked with a star: the published figures do not add up to the number of tests."""

Methods = Mapping[str, Method]


def tables(methods: Methods, workers: int) -> dict[str, str]:
    """All tables by name."""
    return {
        "verdicts": verdicts(methods),
        "holds": holds(methods),
        "coverage": coverage(methods),
        "closure": closure(methods),
        "time": time(methods, workers),
        "requests": requests(methods),
    }


def verdicts(methods: Methods) -> str:
    """Passed, failed, not checked: published and here."""
    head = ["", *(f"{m.published.title}, {who}" for m in methods.values() for who in ("published", "here"))]
    counts = [f"{n}" for m in methods.values() for n in (m.published.tests, m.suite["tests"])]
    rows = [
        [name, *(cell for m in methods.values() for cell in (_published(m, name), _slashed(m.verdicts[name])))]
        for name in REQUIREMENTS
    ]
    return table(head, [["tests", *counts], *rows])


def _published(method: Method, requirement: str) -> str:
    star = " \\*" if f"{requirement} {method.name}" == AS_PRINTED else ""
    return _slashed(method.published.verdicts[requirement]) + star


def _slashed(counts: tuple[int, int, int]) -> str:
    return " / ".join(map(str, counts))


def holds(methods: Methods) -> str:
    """The claims about the learned suite and the baseline, and whether they hold here."""
    rl, hand, base = methods["rl"], methods["by-hand"], methods["pseudorandom"]
    checked = {name: sum(rl.verdicts[name][:2]) for name in REQUIREMENTS}
    counts = ", ".join(f"{name} in {count}" for name, count in checked.items())
    means = f"{percent(base.mean.value)} against {percent(rl.mean.value)} and {percent(hand.mean.value)}"
    rows = [
        (
            "BDI RL reaches the highest coverage per test of BDI by hand",
            f"{percent(rl.most, 2)} against {percent(hand.most, 2)}",
            rl.most >= hand.most,
        ),
        ("BDI RL checks all of R1 to R4", f"{counts} of {rl.suite['tests']} tests", all(checked.values())),
        (
            "pseudorandom is below both in mean coverage per test",
            means,
            base.mean.high < min(rl.mean.low, hand.mean.low),
        ),
        (
            "pseudorandom is below both in highest coverage of a test",
            f"{percent(base.most, 2)}",
            base.most < min(rl.most, hand.most),
        ),
    ]
    return table(["", "here", "holds"], [(claim, how, "yes" if so else "**no**") for claim, how, so in rows])


def coverage(methods: Methods) -> str:
    """Statements and branches."""

    def whole(kind: str) -> Callable[[Method], str]:
        return lambda m: percent(m.suite["code"][kind]["percent_reachable"])

    return _by_method(
        methods,
        {
            "statements per test, mean, published": lambda m: percent(m.published.mean, 0),
            "statements per test, mean, here (95 % interval)": lambda m: f"{interval(m.mean, 1)} %",
            "statements per test, highest, published": lambda m: percent(m.published.most, 0),
            "statements per test, highest, here": lambda m: percent(m.most),
            "statements of the whole suite, of what can be reached": whole("statements"),
            "branches of the whole suite, of what can be reached": whole("branches"),
        },
    )


def closure(methods: Methods) -> str:
    """Plans, cross products, and the number of distinct tests."""

    def plans(agent: str) -> Callable[[Method], str]:
        def shown(method: Method) -> str:
            plans = method.suite["plans"].get(agent)
            return f"{len(plans['covered'])} of {plans['total']}" if plans else "no model"

        return shown

    def bins(name: str) -> Callable[[Method], str]:
        def shown(method: Method) -> str:
            product = method.suite["cross"]["products"][name]
            return f"{product['hit']} of {product['bins'] - product['impossible'] - product['illegal']}"

        return shown

    products = next(iter(methods.values())).suite["cross"]["products"]
    return _by_method(
        methods,
        {
            "plans of the human": plans("human"),
            "plans of the robot's code": plans("robot_code"),
            **{f"bins of the cross product `{name}`": bins(name) for name in products},
            "distinct texts": lambda m: f"{m.suite['generation']['distinct_texts']} of {m.suite['tests']}",
        },
    )


def _by_method(methods: Methods, rows: Mapping[str, Callable[[Method], str]]) -> str:
    titles = [m.published.title for m in methods.values()]
    return table(["", *titles], [[name, *(shown(m) for m in methods.values())] for name, shown in rows.items()])


def time(methods: Methods, workers: int) -> str:
    """Learning and running, published and here."""
    learning_s = methods["rl"].suite["generation"]["wall_s"]
    faster = f"{LEARNING_S / learning_s:,.0f}" if learning_s else "-"
    rows = [["learning (BDI RL)", duration(LEARNING_S), duration(learning_s), faster]]
    for m in methods.values():
        (least_s, most_s), took_s = m.running_s, m.busy_s / workers
        rows.append(
            [
                f"running {m.published.title}",
                f"{duration(least_s)} to {duration(most_s)}",
                duration(took_s),
                f"{least_s / took_s:,.0f} to {most_s / took_s:,.0f}",
            ]
        )
    return table(["phase", "published", "here", "times faster"], rows)


def requests(methods: Methods) -> str:
    """What tests ask for and the results: the original's recorded tests, and here."""

    def optional(value: float | None) -> str:
        return percent(value) if value is not None else "-"

    rows: Mapping[str, Callable[[RequestStatistics], object]] = {
        "tests": lambda a: a.tests,
        "never ask for a leg": lambda a: a.no_request,
        "let the robot read its sensors when not all are ready": lambda a: a.not_ready,
        "... of these, checked R2": lambda a: a.not_ready_checked,
        "ask for a leg with all three sensors ready": lambda a: a.all_ready,
        "... of these, checked R1": lambda a: a.all_ready_checked,
        "turns of the robot": lambda a: a.turns if a.turns is not None else "not given",
        "failed R3": lambda a: a.failed,
        "coverage of tests with a release, mean": lambda a: optional(a.releasing),
        "coverage of the other tests, mean": lambda a: optional(a.others),
    }
    head = ["", *(f"{m.published.title}, {who}" for m in methods.values() for who in ("original", "here"))]
    return table(
        head,
        [[name, *(shown(a) for m in methods.values() for a in (m.original, m.ours))] for name, shown in rows.items()],
    )
