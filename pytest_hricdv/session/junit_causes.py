"""Causes in the JUnit file: of each failing test, in its message, which CI services show, and as a property.

pytest makes a test's element when the test has ended, and writes all of them at the end of the session; what tests fail
for is known in between.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from typing import Any

from pytest_hricdv._base.message import visible
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.results.model import Report

ID = "hri.id"
"""The property by which an element is known to be of a generated test."""


def tell_causes(report: Report, reporters: Iterable[Any]) -> None:
    """Add causes to the elements of failing tests.

    Args:
        report: of the session.
        reporters: of pytest's plugin `junitxml`: each has the element of a test that has ended.
    """
    failing = FailingTests.of(report)
    labels = failing.labels()
    by_id = {test.id: labels[nodeid] for nodeid, test in failing.tests.items() if nodeid in labels}
    for reporter in reporters if by_id else ():
        element = reporter.to_xml()
        properties = element.find("properties")
        of_test = {} if properties is None else {entry.get("name"): entry.get("value") for entry in properties}
        label = by_id.get(str(of_test.get(ID, "")))
        if label is not None and properties is not None:
            ET.SubElement(properties, "property", name="hri.cause", value=visible(label))
            for failure in element.iter("failure"):
                _label(failure, visible(label))


def _label(failure: ET.Element, label: str) -> None:
    """Name the cause at the end of the first line, in the message and in the text."""
    first = failure.get("message", "")
    if first and "\n" not in first:
        failure.set("message", f"{first} ({label})")
        text = failure.text or ""
        failure.text = f"{first} ({label}){text.removeprefix(first)}" if text.startswith(first) else text
