"""The tables of docs/studies/adequacy.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from pytest_hricdv.extra.mutation.records import MUTATION, MutantResult, MutantStatus, MutationResult
from pytest_hricdv.results import proportion
from pytest_hricdv.results.model import Report
from studies import page, session


@dataclass(frozen=True)
class Done:
    """A session that was run."""

    suite: str
    seed: int
    report: Report

    @property
    def mutation(self) -> MutationResult:
        """What became of its mutants."""
        result = MUTATION.of(self.report)
        assert result is not None, "it was checked when the report was read"
        return result


def context(done: Sequence[Done]) -> dict[str, Any]:
    """What the page's template is filled with."""
    first = done[0].mutation
    suites = list(dict.fromkeys(entry.suite for entry in done))
    by_suite = {name: [entry for entry in done if entry.suite == name] for name in suites}
    alive = never_killed([entry.mutation for entry in done])
    return {
        "count": len(done),
        "made": first.generated,
        "drawn": len(first.mutants),
        "tests_per_mutant": first.tests_per_mutant,
        "code_sha256": done[0].report.code_under_test.sha256,
        "version": done[0].report.version,
        "machine": session.machine(),
        "suites": scores(by_suite),
        "together": together(done),
        "survived": _mutants(mutant for mutant in alive if mutant.status == "survived"),
        "excluded_tests": {f"{entry.suite} at seed {entry.seed}": entry.mutation.excluded_tests for entry in done},
    }


def scores(by_suite: Mapping[str, Sequence[Done]]) -> str:
    """A row for each suite: the share that it kills, and of those that show at all, with 95 % intervals.

    What varies is which mutants there are: each counts once, with the share of seeds at which it was killed.
    """
    rows = []
    for name, done in by_suite.items():
        tried = _share_killed(done, ("killed", "survived", "unchanged", "no coverage"))
        changed = _share_killed(done, ("killed", "survived"))
        rows.append(
            [
                name,
                len(done),
                len(tried),
                *(page.interval(proportion.share(sum(shares), len(shares))) for shares in (tried, changed)),
            ]
        )
    head = ["suite", "seeds", "mutants", "killed, %", "killed, of those that changed a record, %"]
    return page.table(head, rows)


def _share_killed(done: Iterable[Done], counted: Sequence[MutantStatus]) -> list[float]:
    """Of each mutant: the share of sessions that killed it, of those in which its status is one of these."""
    killed: dict[str, list[bool]] = {}
    for mutant in (mutant for entry in done for mutant in entry.mutation.mutants if mutant.status in counted):
        killed.setdefault(mutant.id, []).append(mutant.status == "killed")
    return [fmean(sessions_killed) for sessions_killed in killed.values()]


def together(done: Iterable[Done]) -> str:
    """A row for each seed: what its suites kill together, and what only one of them kills."""
    by_seed: dict[int, list[Done]] = {}
    for entry in done:
        by_seed.setdefault(entry.seed, []).append(entry)
    rows = []
    for seed, sessions_of_seed in by_seed.items():
        killed = {entry.suite: _killed(entry.mutation) for entry in sessions_of_seed}
        union = set().union(*killed.values())
        total = len(sessions_of_seed[0].mutation.mutants)
        alone = {
            name: len(mine - set().union(*(other for key, other in killed.items() if key != name)))
            for name, mine in killed.items()
        }
        only = ", ".join(f"{name} {count}" for name, count in alone.items())
        rows.append([seed, page.percent(100.0 * len(union) / total), len(union), only])
    return page.table(["seed", "killed by any of its suites", "mutants", "killed by one suite only"], rows)


def never_killed(results: Sequence[MutationResult]) -> list[MutantResult]:
    """The mutants that no session killed, each once: as of a session in which it changed a record, if there is one."""
    killed = set().union(*map(_killed, results))
    alive: dict[str, MutantResult] = {}
    for mutant in (mutant for result in results for mutant in result.mutants if mutant.id not in killed):
        if mutant.id not in alive or (mutant.status == "survived" != alive[mutant.id].status):
            alive[mutant.id] = mutant
    return sorted(alive.values(), key=lambda mutant: (mutant.file, mutant.line, mutant.operator, mutant.id))


def _killed(result: MutationResult) -> set[str]:
    return {mutant.id for mutant in result.mutants if mutant.status == "killed"}


def _mutants(mutants: Iterable[MutantResult]) -> str:
    rows = [
        [
            f"{mutant.file}:{mutant.line}",
            mutant.operator,
            _code(mutant.before),
            _code(mutant.after),
            mutant.difference or mutant.status,
        ]
        for mutant in mutants
    ]
    return page.table(["where", "fault", "before", "after", "what changed"], rows)


def _code(text: str, most: int = 3) -> str:
    """Lines as code in a cell; a bar would end it."""
    lines = [f"`{line}`".replace("|", "\\|") for line in text.splitlines() if line]
    return "<br>".join(lines[:most] + (["..."] if len(lines) > most else []))
