"""Results as JUnit properties, of tests and of the whole, for whatever reads JUnit XML and nothing else."""

from collections.abc import Iterator, Mapping
from typing import Any

from pytest_hricdv.report import totals
from pytest_hricdv.report.figure import natural, share


def properties(test: Mapping[str, Any], outcome_label: str = "outcomes") -> tuple[tuple[str, str], ...]:
    """Name and value pairs for `item.user_properties`: suite, id, seed, verdicts, coverage, fidelity, outcomes.

    Args:
        test: its entry in the report.
        outcome_label: what the testbench calls the outcomes of a run's turns.

    What a test does not have, such as the coverage of unmeasured code or an outcome while it still runs, has no
    property: an empty one would read as zero somewhere.
    """
    pairs: list[tuple[str, object]] = [
        ("hri.suite", test["suite"]),
        ("hri.id", test["id"]),
        ("hri.seed", test["seed"]),
        ("hri.outcome", test.get("outcome")),
    ]
    pairs += [
        (f"hri.{name}", test["requirements"][name]["verdict"]) for name in sorted(test["requirements"], key=natural)
    ]
    code = test["code"] or {}
    pairs.append(("hri.statements_percent", _tenths(code.get("percent"))))
    pairs.append(("hri.simulated_s", _tenths(test["sim_s"])))
    pairs.append(("hri.fidelity", test.get("fidelity") or None))
    pairs.append((f"hri.{outcome_label}", " ".join(test["legs"])))
    pairs.append(("hri.record_sha256", test.get("record_sha256") or None))
    return tuple((name, str(value)) for name, value in pairs if value is not None)


def _tenths(value: float | None) -> str | None:
    return None if value is None else f"{value:.1f}"


def suite_properties(report: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Name and value pairs for the XML's `testsuite`: what was run, and per suite verdicts and coverage in per cent."""
    code = report.get("code_under_test", {})
    pairs: list[tuple[str, object]] = [
        ("hri.testbench", report["testbench"]),
        ("hri.version", report["version"]),
        ("hri.expected", report["selected"]),
        ("hri.reported", report["reported"]),
        ("hri.code_sha256", code.get("sha256") or None),
    ]
    for suite in report["suites"]:
        pairs += [(f"hri.{suite['name']}.{name}", value) for name, value in _figures(suite)]
    pairs += [("hri.failed_gate", text) for text in report.get("gates", {}).get("failed", ())]
    return tuple((name, str(value)) for name, value in pairs if value is not None)


def _figures(suite: Mapping[str, Any]) -> Iterator[tuple[str, object]]:
    yield "seed", suite["seed"]
    yield "tests", suite.get("tests")
    for name in sorted(suite["requirements"], key=natural):
        tally = suite["requirements"][name]
        yield name, f"{tally['passed']} passed, {tally['failed']} failed, {tally['nc']} NC"
    for kind in ("statements", "branches"):
        figures = suite["code"][kind]
        yield f"{kind}_percent", None if figures is None else _tenths(totals.percent_reachable(figures))
    for agent, plans in sorted(suite["plans"].items()):
        yield f"plans_of_{agent}_percent", _tenths(share(len(plans["covered"]), plans["total"]))
    cross = suite["cross"]
    possible = cross["bins"] - cross["impossible"] - cross.get("illegal", 0)
    yield "cross_percent", _tenths(share(cross["hit"], possible))
