"""Sessions whose further runs take place on a cluster: the same comes of them as without."""

from __future__ import annotations

from typing import Any

import pytest

from tests.plugin import project

ON_TWO = "--hri-cluster=local:2"
SEARCH = ("--hri-suite=bdi-random", "--hri-tests=4", "--hri-search=10", "-p", "no:xdist")
CLOSURE = ("--hri-suite=closure", "--hri-close-runs=24", "-p", "no:xdist", "-p", "no:cacheprovider")


def timeless(value: Any) -> Any:
    """A report without times."""
    if isinstance(value, dict):
        return {name: timeless(each) for name, each in value.items() if name not in ("wall_s", "cached", "workers")}
    return [timeless(each) for each in value] if isinstance(value, list) else value


@pytest.mark.slow
def test_a_search(lamps: pytest.Pytester) -> None:
    lamps.runpytest_subprocess(*SEARCH)
    here = project.report(lamps.path)
    result = lamps.runpytest_subprocess(*SEARCH, ON_TWO)
    result.stdout.fnmatch_lines(["hricdv: searching for violations of 3 requirements on local:2 ..."])
    assert timeless(project.report(lamps.path)["search"]) == timeless(here["search"])
    assert here["search"]["R1"]["runs"] == 10


@pytest.mark.slow
def test_a_closing_loop(lamps: pytest.Pytester) -> None:
    lamps.runpytest_subprocess(*CLOSURE)
    here = project.report(lamps.path)
    lamps.runpytest_subprocess(*CLOSURE, ON_TWO, "--hri-send-code")
    there = project.report(lamps.path)
    assert timeless(there["tests"]) == timeless(here["tests"])
    assert timeless(there["closing"]) == timeless(here["closing"])


@pytest.mark.slow
def test_a_cluster_that_is_not_there(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_subprocess(*CLOSURE, "--hri-cluster=somewhere")
    result.stderr.fnmatch_lines(
        ["ERROR: --hri-cluster: 'somewhere': expected local, local:WORKERS or a scheduler's tcp://HOST:PORT"]
    )
    result = lamps.runpytest_subprocess(*SEARCH, "--hri-cluster=somewhere")
    result.stdout.fnmatch_lines(["FAILED --hri-search: --hri-cluster: 'somewhere': expected local*"])
    assert result.ret == pytest.ExitCode.TESTS_FAILED
