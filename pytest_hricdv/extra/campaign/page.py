"""The page of a campaign: tables in Markdown, for a repository's documentation."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from textwrap import fill

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.campaign.plan import CampaignPlan
from pytest_hricdv.extra.campaign.records import CAMPAIGN, CampaignRequirement, CampaignResult
from pytest_hricdv.extra.campaign.view import share_text
from pytest_hricdv.report.formatting import by_requirement, line_ranges, percent, plural, quantity
from pytest_hricdv.report.markdown import escape_markdown
from pytest_hricdv.results.model import Report

_MAX_LISTED = 20
_WIDTH = 120
_SHOWN_VERSIONS = ("python", "machine", "pytest_hricdv", "pybullet", "mujoco_core", "numpy", "coverage")


def text(report: Report, plan: CampaignPlan) -> str:
    """The page; the same runs give the same bytes."""
    result = CAMPAIGN.of(report)
    assert result is not None, "it is a campaign's"
    parts = [
        f"# A campaign: {result.stored:,} runs",
        _what(result, plan),
        "## Verdicts",
        "Intervals are 95 % (Wilson).",
        _verdicts(result),
        _spread(result),
        "## Coverage",
        _coverage(report),
        f"## How {escape_markdown(report.outcome_label)} ended",
        _endings(result),
        *_failures(report, result),
        "## Repeated runs",
        _repeated(result),
        "## What was run",
        _versions(plan),
    ]
    return "\n\n".join(parts) + "\n"


def _what(result: CampaignResult, plan: CampaignPlan) -> str:
    command = shlex.join(plan.planned.arguments)
    # In an example to copy, of a campaign that somebody else made: no option of pytest, such as --basetemp=DIR.
    own = shlex.join(argument for argument in plan.planned.arguments if argument.startswith("--hri-"))
    last = plan.run((0, plan.concretizations - 1)).test.id
    introduction = (
        f"{plural(len(result.tests), 'abstract test')} of `pytest {_code(command)}`, each concretized with "
        f"{plural(result.concretizations, 'seed')}, and run: {result.stored:,} of {result.expected:,} runs, "
        f"{result.sim_s:,.0f} s simulated. Concretization number k of a test is the one that `--hri-concretizations` "
        "numbers so, and its id ends in `-k` and that number. Written by `python -m pytest_hricdv.campaign report "
        "--page=FILE`. To run one of them as an ordinary test:"
    )
    example = f"    pytest {visible(own)} --hri-concretizations={result.concretizations} -k {last}"
    return f"{fill(introduction, _WIDTH, break_long_words=False, break_on_hyphens=False)}\n\n{example}"


def _verdicts(result: CampaignResult) -> str:
    rows = (
        [
            escape_markdown(name),
            f"{judged.passed:,}",
            f"{judged.failed:,}",
            f"{judged.nc:,}",
            f"{judged.triggers:,}",
            share_text(judged.share),
            f"{quantity(judged.least.margin)} in `{_code(judged.least.run)}`" if judged.least else "-",
        ]
        for name, judged in _ordered(result)
    )
    head = ["", "Passed", "Failed", "NC", "checks", "failed, of the runs that checked it", "least margin"]
    return _table(head, rows)


def _spread(result: CampaignResult) -> str:
    rows = (
        [escape_markdown(name), judged.ever, judged.always, judged.unsettled]
        for name, judged in _ordered(result)
        if judged.unsettled
    )
    return _table(["", "abstract tests that failed with some seed", "with each", "whose verdict depends on it"], rows)


def _ordered(result: CampaignResult) -> Iterator[tuple[str, CampaignRequirement]]:
    for name in sorted(result.requirements, key=by_requirement):
        yield name, result.requirements[name]


def _coverage(report: Report) -> str:
    rows: list[Sequence[object]] = []
    for suite in report.suites:
        for measure, covered in (("statements", suite.code.statements), ("branches", suite.code.branches)):
            if covered is not None:
                reached = f"{percent(covered.percent_reachable)} ({covered.covered} of {covered.reachable} reachable)"
                rows.append([f"{measure}, suite {suite.name}", reached])
        if suite.cross.bins:
            hit = f"{suite.cross.hit} of {suite.cross.possible} possible"
            rows.append([f"bins of cross products, suite {suite.name}", hit])
    waived = {(waiver.file, waiver.line) for waiver in report.code_under_test.waivers}
    for file in report.code_under_test.files:
        lines = [line for line in file.missing_lines if (file.file, line) not in waived]
        if lines:
            rows.append([f"not reached: {escape_markdown(file.file)}", ", ".join(line_ranges(lines))])
    return _table(["by all runs together", ""], rows)


def _endings(result: CampaignResult) -> str:
    total = sum(result.endings.values())
    rows = (
        [escape_markdown(name), f"{count:,}", percent(100.0 * count / total)] for name, count in result.endings.items()
    )
    return _table(["", "", "share"], rows)


def _failures(report: Report, result: CampaignResult) -> Iterator[str]:
    """Runs that failed, and those that were lost."""
    items = [f"- `{_code(run.id)}` was lost: {escape_markdown(run.reason)}" for run in result.lost]
    for test in report.tests:
        if test.fails:
            names = [name for name, judged in test.requirements.items() if judged.verdict == "Failed"]
            violated = " and ".join(sorted(names, key=by_requirement)) or test.outcome
            items.append(f"- `{_code(test.id)}`: {escape_markdown(violated)}")
    if not items:
        return
    more = [f"- and {len(items) - _MAX_LISTED:,} more"] if len(items) > _MAX_LISTED else []
    yield "## Failures of what is not known to fail"
    yield "\n".join([*items[:_MAX_LISTED], *more])


def _repeated(result: CampaignResult) -> str:
    differing = "\n".join(f"- `{_code(run.id)}`: {escape_markdown(run.parting)}" for run in result.differing)
    again = f"{result.repeated:,} runs were done again, on another worker where there is one"
    summary = f"{again}; {len(result.differing):,} gave another record."
    return f"{summary}\n\n{differing}".strip()


def _versions(plan: CampaignPlan) -> str:
    versions = plan.planned.versions
    named = [f"{name} {escape_markdown(versions[name])}" for name in _SHOWN_VERSIONS if name in versions]
    return f"{', '.join(named)}; {len(plan.planned.project)} files of the project, whose hashes the campaign has."


def _code(text: str) -> str:
    """For between backquotes, where nothing else has a meaning."""
    return visible(text).replace("`", "'").replace("|", "/")


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)
