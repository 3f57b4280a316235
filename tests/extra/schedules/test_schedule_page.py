"""The lanes of threads on the page of a test."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import pytest

from tests.report import sample
from tests.report.watched import Watched


@pytest.mark.slow
def test_lanes_show_when_threads_go_on_and_are_no_difference_from_a_run_without_them(
    watched: Watched, tmp_path: Path
) -> None:
    report = sample.data(tests=60)
    test = next(test for test in report["tests"] if test["requirements"]["R3"]["verdict"] == "Failed")
    test |= {
        "outcome": "failed",
        "lanes": [{"node": "arm", "switches": [[0.25, "a.py:13"]], "held": [[1, 2, "a.py:17"]]}],
    }
    timeline = deepcopy(test["timeline"])
    timeline["messages"][3] = '3\trobot\tstate\t{"name":"Give up"}'
    passing = {"timeline": timeline, "abstract": test["abstract"], "begun": []}
    pair = {"words": "without the wait", "kind": "schedule", "test": test["id"], "runs": 3, "neighbour": passing}
    report["causes"] = [{"id": "0a", "requirements": ["R3"], "tests": [test["id"]], "minimal_pair": pair}]
    page = watched.open(report, tmp_path, "tests")
    page.get_by_role("link", name=test["id"]).click()
    page.wait_for_selector("#test .timeline svg")
    if page.locator("#test .more").is_visible():
        page.locator("#test .more").click()
    own, other = (page.locator("#test .timeline svg[aria-label^=Messages]").nth(n).text_content() for n in (0, 1))
    assert "arm" in (own or "")
    assert "arm" not in (other or "")
    assert "there state Give up (3.00 s)" in page.locator("#test .other").inner_text()
    watched.assert_quiet()
