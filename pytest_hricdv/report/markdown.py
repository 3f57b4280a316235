"""The report as markdown for a CI job's summary: verdicts, coverage, what failed and how to run it again."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pytest_hricdv.report import totals
from pytest_hricdv.report.explanation import violation
from pytest_hricdv.report.figure import natural, percent, plural, seconds, share
from pytest_hricdv.report.line import fit, visible
from pytest_hricdv.report.rerun import again

_MAX_FAILURES = 10
_MAX_GAP_COLUMNS = 200
_SPECIAL = {
    "\\": "\\\\",
    "&": "&amp;",
    "<": "&lt;",
    ">": "&gt;",
    "|": "\\|",
    "`": "\\`",
    "*": "\\*",
    "_": "\\_",
    "[": "\\[",
    "#": "\\#",
}


def markdown(report: Mapping[str, Any]) -> str:
    """The summary's text; names in it cannot break its tables, and it stays far below GitHub's limit of 1 MiB."""
    lines: list[str] = []
    for part in (_head(report), _requirements(report), _coverage(report), _failures(report), _gaps(report)):
        section = list(part)
        if section:
            lines += [*section, ""]
    return "\n".join(lines)


def _head(report: Mapping[str, Any]) -> Iterator[str]:
    counts, time = totals.outcomes(report), totals.time(report)
    failed = report.get("gates", {}).get("failed", ())
    bad = counts["failed"] or counts["error"] or failed or totals.loss(report)
    yield f"## Human-robot interaction: {_plain(report['testbench'])}, {'failed' if bad else 'passed'}"
    yield ""
    words = {"passed": "passed", "failed": "failed", "known-violation": "known to fail", "error": "in error"}
    told = ", ".join(f"{counts[name]} {word}" for name, word in words.items() if counts[name]) or "nothing run"
    loss = totals.loss(report)
    lost = f" **{loss}.**" if loss else ""
    yield f"Tests: {told}. Expected {report['selected']}, reported {report['reported']}.{lost} "
    yield f"Simulated {seconds(time.simulated_s)} in {seconds(time.wall_s)}."
    for text in failed:
        yield f"\n**FAILED** {_plain(text)}"
    for text in report.get("gates", {}).get("improved", ()):
        yield f"\nBetter: {_plain(text)}"


def _requirements(report: Mapping[str, Any]) -> Iterator[str]:
    for suite in report["suites"]:
        rows = totals.tallies(report, suite)
        yield f"### Suite {_plain(suite['name'])}, seed {suite['seed']}: {plural(suite.get('tests', 0), 'test')}"
        yield ""
        yield "| requirement | passed | failed | NC | triggers | least margin |"
        yield "|---|---:|---:|---:|---:|---:|"
        for row in rows:
            failed = f"**{row.failed}**" if row.failed and not row.known else str(row.failed)
            known = f" known: {_plain(row.known)}" if row.failed and row.known else ""
            margin = "" if row.margin is None else f"{row.margin:.3g}"
            name = _plain(f"{row.name} {row.title}")
            yield f"| {name} | {row.passed} | {failed}{known} | {row.nc} | {row.triggers} | {margin} |"
        yield ""
    if report["suites"]:
        yield "NC: not checked, because nothing in the run triggered the requirement."


def _coverage(report: Mapping[str, Any]) -> Iterator[str]:
    suites = report["suites"]
    if not suites:
        return
    yield f"| coverage | {' | '.join(_plain(suite['name']) for suite in suites)} |"
    yield f"|---|{'---:|' * len(suites)}"
    for kind in ("statements", "branches"):
        yield f"| {kind}, of the reachable | {' | '.join(_code(suite['code'][kind]) for suite in suites)} |"
    for agent in sorted({agent for suite in suites for agent in suite["plans"]}):
        yield f"| plans of {_plain(agent)} | {' | '.join(_plans(suite['plans'].get(agent)) for suite in suites)} |"
    if any(suite["cross"]["bins"] for suite in suites):
        yield f"| cross products, of the possible | {' | '.join(_cross(suite['cross']) for suite in suites)} |"
    if any(suite["code"]["statements"] is None for suite in suites):
        yield f"\nThe code was not measured: {_plain(totals.unmeasured(report))}."


def _code(figures: Mapping[str, Any] | None) -> str:
    return (
        "unmeasured" if figures is None else f"{percent(totals.percent_reachable(figures))} of {figures['reachable']}"
    )


def _plans(figures: Mapping[str, Any] | None) -> str:
    if figures is None:
        return ""
    return f"{percent(share(len(figures['covered']), figures['total']))} of {figures['total']}"


def _cross(cross: Mapping[str, Any]) -> str:
    possible = cross["bins"] - cross["impossible"] - cross.get("illegal", 0)
    return f"{percent(share(cross['hit'], possible))} of {possible}" if possible else ""


def _failures(report: Mapping[str, Any]) -> Iterator[str]:
    failed = [test for test in report["tests"] if test["outcome"] in ("failed", "error")]
    if not failed:
        return
    yield f"### {plural(len(failed), 'failure')}"
    yield ""
    for test in failed[:_MAX_FAILURES]:
        yield from _failure(report, test)
    if len(failed) > _MAX_FAILURES:
        yield f"... and {len(failed) - _MAX_FAILURES} more: see the report."


def _failure(report: Mapping[str, Any], test: Mapping[str, Any]) -> Iterator[str]:
    names = sorted((n for n, v in test["requirements"].items() if v["verdict"] == "Failed"), key=natural)
    what = ", ".join(names) if names else "in error"
    yield f"<details><summary><b>{_plain(test['id'])}</b>: {_plain(what)}</summary>"
    yield ""
    for name in names:
        for found in test["requirements"][name]["violations"][:1]:
            yield f"- {_plain(name)} {_plain(violation(found, report.get('units', {})))}"
    if not names:
        yield from (f"- {_plain(line)}" for line in str(test.get("failure", "")).strip().splitlines()[:1])
    yield ""
    yield from _fenced(again(report, test))
    yield "</details>"
    yield ""


def _gaps(report: Mapping[str, Any]) -> Iterator[str]:
    gaps = totals.gaps(report)
    if not gaps:
        return
    yield "<details><summary>Not covered</summary>"
    yield ""
    for gap in gaps:
        yield f"- {_plain(gap.place)} {gap.kind}: {_plain(fit(', '.join(gap.items), _MAX_GAP_COLUMNS))}"
    yield ""
    yield "</details>"


def _fenced(lines: Sequence[str]) -> Iterator[str]:
    """Lines as they are, whatever is in them: the fence is longer than any row of backquotes inside."""
    text = [visible(line) for line in lines]
    longest = max((len(part) for line in text for part in _backquotes(line)), default=0)
    fence = "`" * max(3, longest + 1)
    yield f"{fence}text"
    yield from text
    yield fence


def _backquotes(line: str) -> list[str]:
    return "".join(char if char == "`" else " " for char in line).split()


def _plain(text: object) -> str:
    """Text in which markdown and HTML find nothing of theirs."""
    return "".join(_SPECIAL.get(char, char) for char in visible(str(text)))
