"""Failures as GitHub's workflow commands: what stands beside the test in a pull request.

Format: GitHub Actions, "Workflow commands", `::error file=...,line=...,title=...::text`. GitHub shows ten of a kind per
step, so there is one for each requirement, not one for each test.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from pytest_hricdv.report.explanation import violation
from pytest_hricdv.report.figure import natural, plural
from pytest_hricdv.report.line import visible
from pytest_hricdv.report.rerun import again

MOST = 10

Place = tuple[str, int]
"""A file, relative to the repository's root, and a line from 1."""


def commands(report: Mapping[str, Any], places: Mapping[str, Place]) -> tuple[str, ...]:
    """One line for each requirement that was violated and each gate that failed, ten at most.

    Args:
        report: of the session.
        places: node id -> where its test function stands.
    """
    made = [*_violations(report, places), *_errors(report, places), *_gates(report)]
    if len(made) > MOST:
        rest = len(made) - MOST + 1
        made[MOST - 1 :] = [_command("", f"and {plural(rest, 'more failure')}", "see the report", None)]
    return tuple(made)


def _violations(report: Mapping[str, Any], places: Mapping[str, Place]) -> Iterator[str]:
    for name in sorted(report.get("requirements", {}), key=natural):
        failed = [test for test in report["tests"] if test["outcome"] == "failed" and _verdict(test, name) == "Failed"]
        if not failed or (name in report.get("known_violations", {}) and not report.get("strict")):
            continue
        worst = min(failed, key=lambda test: (_margin(test, name), test["id"]))
        title = report["requirements"][name].get("title", "")
        found = [violation(each, report.get("units", {})) for each in worst["requirements"][name]["violations"][:1]]
        lines = [title, f"worst is {worst['id']}", *found, *again(report, worst)]
        yield _command(worst["nodeid"], f"{name} failed in {plural(len(failed), 'test')}", "\n".join(lines), places)


def _errors(report: Mapping[str, Any], places: Mapping[str, Place]) -> Iterator[str]:
    errors = [test for test in report["tests"] if test["outcome"] == "error"]
    if errors:
        first = errors[0]
        last = str(first.get("failure", "")).strip().splitlines()[:1]
        lines = [f"first is {first['id']}", *last, *again(report, first)]
        yield _command(first["nodeid"], f"{plural(len(errors), 'test')} in error", "\n".join(lines), places)


def _gates(report: Mapping[str, Any]) -> Iterator[str]:
    for text in report.get("gates", {}).get("failed", ()):
        yield _command("", "gate failed", text, None)


def _verdict(test: Mapping[str, Any], requirement: str) -> str:
    return str(test["requirements"].get(requirement, {}).get("verdict", ""))


def _margin(test: Mapping[str, Any], requirement: str) -> float:
    margin = test["requirements"][requirement]["margin"]
    return 0.0 if margin is None else float(margin)


def _command(nodeid: str, title: str, text: str, places: Mapping[str, Place] | None) -> str:
    place = (places or {}).get(nodeid)
    given = {"title": f"hri: {title}"}
    if place is not None:
        given = {"file": place[0], "line": str(place[1])} | given
    properties = ",".join(f"{key}={_property(value)}" for key, value in given.items())
    return f"::error {properties}::{_data(text)}"


def _data(text: str) -> str:
    return visible(text, keep="\n").replace("%", "%25").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
