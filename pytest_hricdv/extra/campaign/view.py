"""`CampaignView` shows a campaign in a report: lines for the terminal, and a section of its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.campaign.records import CAMPAIGN, CampaignResult, CampaignTest, FailedShare, LeastMargin
from pytest_hricdv.report.formatting import Line, by_requirement, pad, plural, seconds, width
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report

_MAX_LISTED = 10


class CampaignView(View):
    """The sums over all runs, and each abstract test with the requirements that its runs violated."""

    name = "campaign"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The sums over all runs; none if the report is not of a campaign."""
        result = CAMPAIGN.of(report)
        if result is None:
            return
        yield Line(headline(result), "title")
        names = max([8, *(width(visible(name)) for name in result.requirements)])
        yield Line(f"  {pad('', names)}{'passed':>9}{'failed':>9}{'NC':>9}  failed, of those that checked it", "dim")
        for name in sorted(result.requirements, key=by_requirement):
            judged = result.requirements[name]
            counts = f"{judged.passed:>9,}{judged.failed:>9,}{judged.nc:>9,}"
            text = f"  {pad(visible(name), names)}{counts}  {share_text(judged.share)}"
            yield Line(text, "warn" if judged.failed else "plain")
        for text in notes(result):
            yield Line(visible(f"  {text}"), "bad" if result.lost or result.differing or result.not_run else "plain")

    def section(self, report: Report) -> PageSection | None:
        """All abstract tests."""
        result = CAMPAIGN.of(report)
        if result is None:
            return None
        names = sorted(result.requirements, key=lambda name: (-_failure_rate(result, name), by_requirement(name)))
        values = {
            "result": result,
            "meaning": meaning(result),
            "headline": headline(result),
            "notes": list(notes(result)),
            "requirements": {name: result.requirements[name] for name in names},
            "share": share_text,
            "tests": sorted(result.tests, key=lambda test: -count_failures(test.outcomes)),
            "failing": count_failures,
            "short": short,
            "worst": worst,
            "margins": margins,
            "anchors": {test.id: anchor(test.nodeid) for test in report.tests},
        }
        remark = "" if result.is_listed else "The tests below are the runs to keep."
        template = "campaign/campaign.html.jinja"
        return PageSection("campaign", "Campaign", template, values, headline=headline(result), remark=remark)

    def total_simulated_s(self, report: Report) -> float | None:
        """The simulated time of all runs of the campaign."""
        result = CAMPAIGN.of(report)
        return None if result is None else result.sim_s

    def test_noun(self, report: Report) -> str:
        """The runs to keep, where there are too many to list all."""
        result = CAMPAIGN.of(report)
        return "" if result is None or result.is_listed else "runs to keep"


VIEW = CampaignView()


def headline(result: CampaignResult) -> str:
    """`campaign: 6,560 of 6,560 runs: 160 abstract tests, 41 seeds of each, 1024311 s simulated`."""
    tests = f"{plural(len(result.tests), 'abstract test')}, {plural(result.concretizations, 'seed')} of each"
    runs = f"{result.stored:,} of {result.expected:,} runs"
    return f"campaign: {runs}: {tests}, {seconds(result.sim_s)} simulated"


def meaning(result: CampaignResult) -> str:
    """`1 of 6 runs failed; most often R1, in 1 of the 3 runs that checked it.`."""
    failed, runs = count_failures(result.outcomes), f"{result.stored:,} {'run' if result.stored == 1 else 'runs'}"
    text = f"{failed:,} of {runs} failed" if failed else f"None of {runs} failed"
    name = max(result.requirements, key=lambda name: _failure_rate(result, name), default="")
    if not name or not _failure_rate(result, name):
        return f"{text}."
    share = result.requirements[name].share
    where = "the one run" if share.checked == 1 else f"{share.failed:,} of the {share.checked:,} runs"
    return f"{text}; most often {name}, in {where} that checked it."


def count_failures(outcomes: Mapping[str, int]) -> int:
    """Runs that failed, did not end, or were lost."""
    return sum(outcomes.get(outcome, 0) for outcome in ("failed", "error", "lost"))


def short(test: CampaignTest, run: str) -> str:
    """A run of a test by its number: `k2`; `k0` of the first, which has the name of the test."""
    return run.removeprefix(f"{test.id}-") if run != test.id else "k0"


def _failure_rate(result: CampaignResult, name: str) -> float:
    share = result.requirements[name].share
    return share.failed / share.checked if share.checked else 0.0


def notes(result: CampaignResult) -> Iterator[str]:
    """Notes on its runs, a sentence each."""
    outcomes = ", ".join(f"{count:,} {name.replace('-', ' ')}" for name, count in result.outcomes.items())
    if outcomes:
        yield f"outcomes: {outcomes}"
    if result.not_run:
        yield f"{result.not_run:,} runs have no outcome yet: the figures are of the others"
    for run in result.lost[:_MAX_LISTED]:
        yield f"lost: {run.id}: {run.reason}"
    if result.repeated:
        again = f"{result.repeated:,} runs were repeated, on another worker where there is one"
        yield f"{again}: {len(result.differing):,} differ"
    for different in result.differing[:_MAX_LISTED]:
        where = f" (versions: {different.versions})" if different.versions else ""
        yield f"differs: {different.id}: {different.parting}{where}"
    if not result.is_listed:
        yield "only the runs worth keeping are listed as tests; figures of suites and requirements below are of these"


def share_text(share: FailedShare) -> str:
    """`9.53 % (8.84 to 10.26)`, or `-` where no run checked the requirement."""
    if not share.checked:
        return "-"
    value = 100.0 * share.failed / share.checked
    return f"{value:.2f} % ({share.low:.2f} to {share.high:.2f})"


def worst(test: CampaignTest) -> list[tuple[str, FailedShare]]:
    """The requirements that runs of a test violated, those that most violated first."""
    return sorted(test.failed.items(), key=lambda item: (-item[1].failed, by_requirement(item[0])))


def margins(result: CampaignResult, test: CampaignTest) -> list[tuple[str, LeastMargin]]:
    """The least margins of the requirements that a test violated, and those that are the least of all tests."""
    least = {name: judged.least for name, judged in result.requirements.items()}
    shown = (name for name, margin in test.least.items() if name in test.failed or margin == least[name])
    return [(name, test.least[name]) for name in sorted(shown, key=by_requirement)]
