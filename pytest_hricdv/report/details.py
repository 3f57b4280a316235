"""What the page shows of a single test, packed: fetched only when its page is opened."""

import base64
import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pytest_hricdv.report import explanation, rerun
from pytest_hricdv.report.figure import natural, quantity, seconds

TESTS_A_PACK = 50


def packs(report: Mapping[str, Any]) -> Iterator[str]:
    """Every so many tests' details as base64 of deflated JSON: a list of objects, in the order of the tests."""
    tests = report["tests"]
    for start in range(0, len(tests), TESTS_A_PACK):
        text = json.dumps(
            [detail(report, test) for test in tests[start : start + TESTS_A_PACK]],
            separators=(",", ":"),
            sort_keys=True,
        )
        yield base64.b64encode(zlib.compress(text.encode("ascii"))).decode("ascii")


def detail(report: Mapping[str, Any], test: Mapping[str, Any]) -> dict[str, Any]:
    """One test, every figure of it as text."""
    concrete = test["concrete"] or {}
    facts = {
        "Ended": test.get("ended") or "",
        "Simulated": seconds(test["sim_s"]),
        "of it frozen": seconds(test["frozen_s"]),
        "Simulation": test.get("fidelity") or "",
        "Wall clock": seconds(test["wall_s"]),
        "Own seed": "" if test["seed"] is None else str(test["seed"]),
        "Record SHA-256": test.get("record_sha256") or "",
        "Code": test.get("unmeasured") and f"unmeasured: {test['unmeasured']}",
    }
    return {
        "nodeid": test["nodeid"],
        "beliefs": test["beliefs"],
        "plans": {agent: sorted(labels, key=natural) for agent, labels in test.get("plans", {}).items()},
        "aim": test.get("name") or test.get("aim") or "",
        "abstract": test["abstract"],
        "acted": [round(time_s, 3) for time_s in test.get("acted_s", ())],
        "actions": [_action(each) for each in concrete.get("actions", ())],
        "run": {key: _values(value) for key, value in concrete.items() if key != "actions"},
        "verdicts": [
            _verdict(name, test["requirements"][name], report.get("units", {}))
            for name in sorted(test["requirements"], key=natural)
        ],
        "failure": test.get("failure") or "",
        "again": "\n".join(_again(report, test)),
        "facts": {name: value for name, value in facts.items() if value},
        "film": test.get("film"),
        "shrunk": [_shrunk(name, each, report) for name, each in sorted(test.get("shrunk", {}).items())],
        "repeats": len(test.get("repeats", ())),
        "replayed": _replayed(test.get("replayed")),
        "timeline": test.get("timeline"),
    }


def _action(action: Any) -> list[str]:
    """The command, and its parameters in a line."""
    if not isinstance(action, Mapping):
        return [str(action), ""]
    return [str(action.get("command", "")), _values(action.get("parameters", {}))]


def _values(values: Any) -> str:
    if not isinstance(values, Mapping):
        return quantity(values)
    return ", ".join(f"{name} {quantity(values[name])}" for name in sorted(values))


def _verdict(name: str, verdict: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, Any]:
    margin = verdict["margin"]
    at_s = verdict.get("margin_time_s")
    miss = verdict.get("nearest_miss")
    return {
        "name": name,
        "verdict": verdict["verdict"],
        "counts": explanation.counts(verdict),
        "margin": "" if margin is None else quantity(margin) + ("" if at_s is None else f" at {seconds(at_s)}"),
        "miss": explanation.nearest_miss(miss) if miss else "",
        "violations": [explanation.violation(each, units) for each in verdict["violations"]],
        "times": [each["time_s"] for each in verdict["violations"] if each.get("time_s") is not None],
    }


def _again(report: Mapping[str, Any], test: Mapping[str, Any]) -> list[str]:
    """The commands that run a test again, with the options of the run as far as the report has them."""
    seeds = {suite["name"]: suite["seed"] for suite in report["suites"]}
    again = report.get("rerun", {})
    seed, options, file = seeds.get(test["suite"], 0), again.get("options", ()), test.get("replay")
    return [line.strip() for line in rerun.told(test, again.get("suite"), seed, options, file)[1:]]


def _shrunk(requirement: str, shrunk: Mapping[str, Any], report: Mapping[str, Any]) -> dict[str, Any]:
    options: Sequence[str] = report.get("rerun", {}).get("options", ())
    return {
        "requirement": requirement,
        "from": shrunk["actions_before"],
        "abstract": shrunk["abstract"],
        "note": shrunk["note"],
        "again": rerun.replay(shrunk["replay"], options) if shrunk["replay"] else "",
    }


def _replayed(replayed: Mapping[str, Any] | None) -> str:
    if not replayed:
        return ""
    if replayed["same"]:
        return f"Replay of {replayed['file']}: the same run, to the bit."
    why = ", ".join(replayed["changed"]) or "nobody knows what"
    return f"Replay of {replayed['file']}: another run than the file is of; changed: {why}."
