"""The page's index: one short row a test, from which its tables, plots and searches are made in the browser."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any

from pytest_hricdv.report.figure import natural

LETTERS = {"Passed": "P", "Failed": "F", "NC": "N"}


def index(report: Mapping[str, Any]) -> dict[str, Any]:
    """The rows, and the names that they refer to by number.

    Returns:
        `requirements`, `suites`, `plans` ([agent, label] each): names. `rows`: a list a test, see `_row`; in the order
        of the report's tests.
    """
    requirements = requirement_names(report)
    suites = [suite["name"] for suite in report["suites"]]
    suites += sorted({test["suite"] for test in report["tests"]} - set(suites))
    plans = plan_names(report)
    numbers = {plan: number for number, plan in enumerate(plans)}
    rows = [_row(test, requirements, suites.index(test["suite"]), numbers) for test in report["tests"]]
    return {"requirements": requirements, "suites": suites, "plans": plans, "rows": rows}


def requirement_names(report: Mapping[str, Any]) -> list[str]:
    """Every requirement that a test or the report names, R2 before R10."""
    names = {name for test in report["tests"] for name in test["requirements"]}
    return sorted(names | set(report.get("requirements", {})), key=natural)


def plan_names(report: Mapping[str, Any]) -> list[tuple[str, str]]:
    """All coverage plans of all suites, as (agent, label)."""
    found: dict[tuple[str, str], None] = {}
    for suite in report["suites"]:
        for agent in sorted(suite["plans"]):
            labels = [*suite["plans"][agent]["covered"], *suite["plans"][agent].get("missing", ())]
            found.update(dict.fromkeys((agent, label) for label in sorted(labels, key=natural)))
    return list(found)


def code_bits(test: Mapping[str, Any]) -> tuple[int, int]:
    """The statements and branches that a test covered, bit n for the n-th of the sources; none where unmeasured."""
    bits = (test["code"] or {}).get("bits") or (None, None)
    return tuple(int(each, 16) if each else 0 for each in bits)  # type: ignore[return-value]


def plan_bits(test: Mapping[str, Any], numbers: Mapping[tuple[str, str], int]) -> int:
    """The coverage plans that a test's beliefs triggered, as a bit set."""
    labels = ((agent, label) for agent, plans in test.get("plans", {}).items() for label in plans)
    return sum(1 << numbers[plan] for plan in set(labels) if plan in numbers)


def anchor(nodeid: str) -> str:
    """What links call a test: from the node id, which may hold characters that an address may not."""
    return sha256(nodeid.encode("utf-8", "backslashreplace")).hexdigest()[:10]


def _row(
    test: Mapping[str, Any], requirements: Sequence[str], suite: int, plans: Mapping[tuple[str, str], int]
) -> list[Any]:
    """[anchor, id, suite, outcome, verdict letters, triggers, margins, legs, per cent, sim_s, beliefs, bits, plans]."""
    verdicts = [test["requirements"].get(name) for name in requirements]
    return [
        anchor(test["nodeid"]),
        test["id"],
        suite,
        test["outcome"],
        "".join(LETTERS[each["verdict"]] if each else "-" for each in verdicts),
        [each["triggers"] if each else 0 for each in verdicts],
        [_short(each["margin"]) if each else None for each in verdicts],
        list(test["legs"]),
        _short(test["code"]["percent"]) if test["code"] else None,
        _short(test["sim_s"]),
        " ".join(test["beliefs"]),
        f"{code_bits(test)[0]:x}",
        f"{plan_bits(test, plans):x}",
    ]


def _short(value: float | None) -> float | None:
    """Five digits are more than any table or plot shows."""
    return None if value is None else float(f"{value:.5g}")
