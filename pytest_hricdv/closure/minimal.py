"""The smallest suite with the coverage of a report, as abstract tests again."""

from __future__ import annotations

from pytest_hricdv.closure.closing import Entry
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.results.codec import ReportError


def enough(report: Entry) -> list[AbstractTest]:
    """The tests of the report's `closure.minimal`, in the order of their ids, each once.

    Raises:
        ReportError: a test of the report is none that could be written.
    """
    wanted = {step["nodeid"] for step in report["closure"]["minimal"]}
    chosen = {test["id"]: test for test in report["tests"] if test["nodeid"] in wanted}
    try:
        return [_abstract(chosen[name]) for name in sorted(chosen)]
    except GenerateError as error:
        raise ReportError(f"the report's tests cannot be written: {error}") from None


def _abstract(test: Entry) -> AbstractTest:
    return AbstractTest(
        id=test["id"],
        suite=test["suite"],
        target=test.get("aim") or "minimal",
        beliefs=tuple(test["beliefs"]),
        lines=tuple(test["abstract"]),
        plans={agent: tuple(labels) for agent, labels in test["plans"].items()},
        seed=test["seed"],
        name=test.get("name", ""),
    )
