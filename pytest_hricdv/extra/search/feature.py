"""`SearchFeature`: shrinking and searching in a session: their options, and what they do after the last test.

`PostSession` does the work; `merge` merges the results of several reports.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_hricdv.extra.search.records import BUDGET, SEARCH, SearchOptions, SearchResult
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import Flag, OptionReader, Value

if TYPE_CHECKING:
    from pytest_hricdv.extra.search.post_session import PostSession
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with, for each requirement, the search that came nearest to violating it."""
    results: dict[str, list[SearchResult]] = {}
    for report in reports:
        for requirement, result in SEARCH.of(report).items():
            results.setdefault(requirement, []).append(result)
    return SEARCH.put(merged, {requirement: min(searches, key=_nearness) for requirement, searches in results.items()})


def _nearness(result: SearchResult) -> tuple[float, str]:
    from pytest_hricdv.results.codec import canonical

    return (math.inf if result.margin is None else result.margin, canonical(result))


class SearchFeature(Feature[SearchOptions]):
    """Shrinks the shortest failing tests, and searches for violations near the smallest margins."""

    name = "search"
    options = (
        Flag(
            "shrink",
            "after all tests, shrink the shortest failing test of each requirement: drop actions, simplify parameters, "
            "as long as it fails for the same reason",
        ),
        Value("shrink-runs", "N", f"maximum number of runs to shrink one test (default {BUDGET})"),
        Value("shrink-seconds", "S", f"maximum number of seconds to shrink one test (default {BUDGET})"),
        Value(
            "search",
            "N",
            "after all tests, search for violations: vary the parameters of the tests with the smallest margins, "
            "in at most N runs for each requirement",
        ),
    )

    def read(self, reader: OptionReader) -> SearchOptions:
        """The options of shrinking and searching."""
        return SearchOptions(
            shrink=reader.flag("shrink"),
            shrink_runs=reader.integer("shrink_runs", BUDGET, minimum=1),
            shrink_seconds=reader.integer("shrink_seconds", BUDGET, minimum=1),
            search=reader.integer("search", 0, minimum=1),
        )

    def follow_up(self, context: RunContext) -> str:
        """Which of the two are requested."""
        settings = self.settings(context.options)
        asked = {"shrunk tests (--hri-shrink)": settings.shrink, "the search (--hri-search)": settings.search}
        return " and ".join(name for name, is_asked in asked.items() if is_asked)

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """Shrink and search, if requested."""
        settings = self.settings(session.options)
        if session.interrupted or not (settings.shrink or settings.search):
            return results
        from pytest_hricdv.extra.search.post_session import PostSession
        from pytest_hricdv.extra.search.records import SEARCH

        after = PostSession(session.rerunner, session.options, settings, session.aggregation.chosen, session.say)
        if settings.shrink:
            results = after.shrink(results)
        if settings.search and not stopped:
            session.sections[SEARCH.name] = _search(session, after, results)
        session.interrupted = after.interrupted
        session.done.update(() if stopped or after.interrupted else [self.name])
        session.problems += after.problems
        return results


def _search(session: FeatureSession, after: PostSession, results: list[TestResult]) -> Mapping[str, SearchResult]:
    """Search, on a cluster if one is named."""
    from pytest_hricdv.extra.search.post_session import remote_runs
    from pytest_hricdv.session.remote import ClusterError

    try:
        with (
            session.signals.let_through(),
            remote_runs(session.context, lambda text: session.say(f"hricdv: {text}")) as after.remote,
            session.signals.defer(),
        ):
            return after.search(results)
    except KeyboardInterrupt:  # while the connection was being made or closed
        after.interrupted = True
        return after.searched
    except ClusterError as error:
        session.problems.append(f"--hri-search: --hri-cluster: {error}")
        return {}


FEATURE = SearchFeature()
