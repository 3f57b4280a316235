"""The baseline: what a run reached once, so that a later one is told where it fell behind."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest_hricdv.closure.closing import reached
from pytest_hricdv.gates.bound import KINDS
from pytest_hricdv.report.contract import faults
from pytest_hricdv.report.files import write_text
from pytest_hricdv.results.codec import ReportError

SCHEMA = "hricdv-baseline/1"
_NAMES: dict[str, Any] = {"type": "array", "items": {"type": "string"}}
_CONTRACT: dict[str, Any] = {
    "type": "object",
    "required": ["schema", "testbench", "suites"],
    "properties": {
        "schema": {"const": SCHEMA},
        "testbench": {"type": "string"},
        "suites": {
            "type": "object",
            "additionalProperties": {
                "type": "object",
                "required": ["violations", "broken", "triggers", "percent", "plans", "bins"],
                "properties": {
                    "violations": {"type": "object", "additionalProperties": _NAMES},
                    "broken": _NAMES,
                    "triggers": {"type": "object", "additionalProperties": {"type": "integer", "minimum": 0}},
                    "percent": {"type": "object", "additionalProperties": {"type": ["number", "null"]}},
                    "plans": {"type": "object", "additionalProperties": _NAMES},
                    "bins": {"type": "object", "additionalProperties": {"type": "array", "items": _NAMES}},
                },
            },
        },
    },
}


class BaselineError(Exception):
    """A baseline cannot be read, written or compared with; the text says which file, why, and what to do."""


@dataclass(frozen=True)
class Comparison:
    """A run against a baseline: what got worse, and what got better, a sentence each."""

    worse: tuple[str, ...] = ()
    better: tuple[str, ...] = ()


def baseline_of(report: Mapping[str, Any], old: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What to keep of a report. Suites that the old baseline has and the report has not are kept as they are."""
    suites = dict(old["suites"]) if old else {}
    percents = {kind: dict(reached(dict(report), kind)) for kind in KINDS}
    for suite in report["suites"]:
        name = suite["name"]
        tests = [test for test in report["tests"] if test["suite"] == name]
        suites[name] = {
            "violations": {requirement: _violating(tests, requirement) for requirement in suite["requirements"]},
            "broken": sorted(test["id"] for test in tests if test["outcome"] == "error"),
            "triggers": {requirement: tally["triggers"] for requirement, tally in suite["requirements"].items()},
            "percent": {kind: percents[kind][name] for kind in KINDS},
            "plans": {agent: sorted(plans["covered"]) for agent, plans in suite["plans"].items()},
            "bins": {
                product: sorted(hit["bin"] for hit in each["hits"])
                for product, each in suite["cross"].get("products", {}).items()
            },
        }
    return {"schema": SCHEMA, "testbench": report["testbench"], "suites": suites}


def read(path: Path, testbench: str) -> dict[str, Any]:
    """Read a baseline.

    Raises:
        BaselineError: it is missing, cut off, no baseline, or one of another testbench.
    """
    try:
        baseline = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BaselineError(f"{path}: no such baseline; write it with --hri-update-baseline") from None
    except json.JSONDecodeError as error:
        raise BaselineError(f"{path}:{error.lineno}:{error.colno}: not JSON, perhaps cut off ({error.msg})") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BaselineError(f"{path}: cannot be read: {error}") from None
    broken = faults(baseline, _CONTRACT, "baseline")
    if broken:
        raise BaselineError(f"{path}: {broken[0]}")
    if baseline["testbench"] != testbench:
        raise BaselineError(f"{path}: of the testbench {baseline['testbench']!r}; expected {testbench!r}")
    loaded: dict[str, Any] = baseline
    return loaded


def write(baseline: Mapping[str, Any], path: Path) -> None:
    """Write a baseline, a line for each value: it is kept under version control, and people read what changed in it.

    Aside and then renamed. Raises BaselineError where the folder cannot be written.
    """
    text = json.dumps(baseline, sort_keys=True, indent=1, allow_nan=False)
    try:
        write_text(path, text + "\n")
    except ReportError as error:
        raise BaselineError(str(error)) from None


def compare(report: Mapping[str, Any], baseline: Mapping[str, Any], *, whole: bool) -> Comparison:
    """A report against a baseline.

    A violation is new where the test did not violate that requirement before, known or not. Code is compared by
    percentage, for its lines move; plans, bins and triggers by name. Of a part of the tests nothing but failures is
    compared.

    Args:
        whole: all tests of the suites were selected.
    """
    now = baseline_of(report)["suites"]
    worse: list[str] = []
    better: list[str] = []
    for name in now:
        if name not in baseline["suites"]:
            better.append(f"suite {name} is not in the baseline: --hri-update-baseline adds it")
            continue
        before, after = baseline["suites"][name], now[name]
        worse += [f"suite {name}: {text}" for text in _new_failures(before, after)]
        if whole:
            worse += [f"suite {name}: {text}" for text in _lost(before, after)]
            better += [f"suite {name}: {text}" for text in _gained(before, after)]
    return Comparison(tuple(worse), tuple(better))


def _violating(tests: list[Mapping[str, Any]], requirement: str) -> list[str]:
    return sorted(test["id"] for test in tests if test["requirements"][requirement]["verdict"] == "Failed")


def _new_failures(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    for requirement, tests in after["violations"].items():
        new = sorted(set(tests) - set(before["violations"].get(requirement, ())))
        if new:
            yield f"{requirement} is newly violated by {_shown(new)}"
    new = sorted(set(after["broken"]) - set(before["broken"]))
    if new:
        yield f"newly in error: {_shown(new)}"


def _lost(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    for requirement, triggers in before["triggers"].items():
        if triggers and not after["triggers"].get(requirement):
            yield f"{requirement} is no longer triggered; {triggers} times in the baseline"
    for kind, percent in before["percent"].items():
        reached_now = after["percent"].get(kind)
        if kind in ("statements", "branches") and percent is not None:
            if reached_now is None:
                yield f"{kind} unmeasured; {percent:.2f} % in the baseline"
            elif reached_now < percent:
                yield f"{kind} {reached_now:.2f} %; {percent:.2f} % in the baseline"
    yield from (f"lost {text}" for text in _more(before, after))


def _gained(before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    for requirement, tests in before["violations"].items():
        mended = sorted(set(tests) - set(after["violations"].get(requirement, ())))
        if mended:
            yield f"{requirement} is no longer violated by {_shown(mended)}"
    for requirement, triggers in after["triggers"].items():
        if triggers and not before["triggers"].get(requirement):
            yield f"{requirement} is triggered now, {triggers} times"
    for kind in ("statements", "branches"):
        old, new = before["percent"].get(kind), after["percent"].get(kind)
        if new is not None and (old is None or new > old):
            yield f"{kind} {new:.2f} %; {'unmeasured' if old is None else f'{old:.2f} %'} in the baseline"
    yield from (f"gained {text}" for text in _more(after, before))


def _more(some: Mapping[str, Any], others: Mapping[str, Any]) -> Iterator[str]:
    """The plans and bins that some have and others have not."""
    for agent, plans in some["plans"].items():
        missing = sorted(set(plans) - set(others["plans"].get(agent, ())))
        if missing:
            yield f"plans of {agent}: {_shown(missing)}"
    for product, bins in some["bins"].items():
        missing = sorted({" x ".join(each) for each in bins} - {" x ".join(e) for e in others["bins"].get(product, ())})
        if missing:
            yield f"bins of {product}: {_shown(missing)}"


def _shown(names: list[str], most: int = 3) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
