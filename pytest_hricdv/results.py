"""From runs to the report model: one entry a test, made where it ran; one report, made where all entries meet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.case import CaseResult, HriCase
from pytest_hricdv.cover.closure import TestCover, code_closure, curve, files, percent, plan_closure, union
from pytest_hricdv.cover.source import Bits, CodeMap
from pytest_hricdv.monitor import Requirement, Verdict
from pytest_hricdv.suites import Selected
from pytest_hricdv.testbench import Testbench
from pytest_hricdv.timeline import timeline

SCHEMA = "hricdv-report/1"
Entry = dict[str, Any]


def describe(case: HriCase, nodeid: str) -> Entry:
    """What is known of a test before it runs."""
    test = case.abstract
    actions = [{"command": a.command, "parameters": dict(a.parameters)} for a in case.concrete.actions]
    return {
        "nodeid": nodeid,
        "suite": case.suite,
        "id": test.id,
        "beliefs": list(test.beliefs),
        "abstract": list(test.lines),
        "concrete": {"actions": actions, "run": dict(case.concrete.run)},
        "seed": test.seed,
        "plans": {agent: list(labels) for agent, labels in test.plans.items()},
    }


def measured(result: CaseResult | None, code: CodeMap | None, requirements: Sequence[Requirement]) -> Entry:
    """What a run adds; a run that never came to an end has checked and covered nothing."""
    if result is None:
        unchecked = {requirement.id: _verdict(None) for requirement in requirements}
        figures = {"sim_s": 0.0, "frozen_s": 0.0, "ended": "", "fidelity": "", "code": None, "timeline": None}
        return {"requirements": unchecked, "legs": [], "plans": {}} | figures
    bits = result.code
    share = None
    if bits is not None and code is not None:
        count = bits.statements.bit_count()
        share = {
            "statements": count,
            "percent": percent(count, code.statements),
            "bits": [hex(bits.statements), None if bits.branches is None else hex(bits.branches)],
        }
    return {
        "requirements": {verdict.requirement: _verdict(verdict) for verdict in result.verdicts},
        "legs": list(result.outcome.legs),
        "sim_s": result.sim_s,
        "frozen_s": result.outcome.frozen_s,
        "fidelity": result.outcome.fidelity,
        "ended": result.outcome.ended,
        "record_sha256": result.record.sha256,
        "cross": [list(hit) for hit in result.outcome.cross],
        "code": share,
        "timeline": timeline(result.record, result.verdicts, result.sim_s),
    }


def _verdict(verdict: Verdict | None) -> Entry:
    if verdict is None:
        return {"verdict": "NC", "triggers": 0, "violations": [], "pending": 0, "margin": None}
    miss = verdict.nearest_miss
    return {
        "verdict": verdict.verdict,
        "triggers": verdict.attempts,
        "passes": verdict.passes,
        "failures": verdict.failures,
        "vacuous": verdict.vacuous,
        "pending": verdict.pending,
        "margin": verdict.margin,
        "margin_time_s": verdict.margin_time_s,
        "nearest_miss": miss and {"time_s": miss.time_s, "missing": list(miss.missing), "distance": miss.distance},
        "violations": [
            {"trigger_s": v.trigger_s, "time_s": v.time_s, "values": dict(v.values), "margin": v.margin}
            for v in verdict.violations
        ],
    }


@dataclass(frozen=True)
class Rerun:
    """What `--hri-suite` was given, and the other options that a test needs to be run again."""

    suite: str
    options: tuple[str, ...]


@dataclass(frozen=True)
class Session:
    """What a report is made of, beside the entries of the tests."""

    testbench: Testbench
    requirements: tuple[Requirement, ...]
    selected: tuple[Selected, ...]
    code: CodeMap | None
    unmeasured: str
    known: Mapping[str, str]
    strict: bool
    version: str
    wall_s: float
    workers: int
    rerun: Rerun


def build_report(
    session: Session, entries: Sequence[Entry], chosen: Mapping[str, HriCase], reasons: Mapping[str, str]
) -> Entry:
    """The report model.

    Args:
        session: what was run, on what, how.
        entries: of the tests that were reported.
        chosen: node id -> test, of all that were selected: the ones without an entry were not run.
        reasons: node id -> why it has no entry, where that is known.

    Raises:
        CoverError: a waived statement ran.
    """
    reported = {entry["nodeid"] for entry in entries}
    lost = sorted(set(chosen) - reported)
    entries = [*entries, *(_not_run(session, name, chosen[name], reasons.get(name, "")) for name in lost)]
    entries.sort(key=_order)
    total = union(cover_of(entry) for entry in entries) if session.code else None
    return {
        "schema": SCHEMA,
        "version": session.version,
        "testbench": session.testbench.name,
        "selected": len(chosen),
        "reported": len(reported),
        "not_run": len(lost),
        "not_run_tests": lost,
        "wall_s": round(session.wall_s, 3),
        "workers": session.workers,
        "known_violations": dict(session.known),
        "strict": session.strict,
        "rerun": {"suite": session.rerun.suite, "options": list(session.rerun.options)},
        "requirements": {r.id: {"title": r.title, "source": r.source, "text": r.text} for r in session.requirements},
        "code_under_test": _code_under_test(session, total),
        "state": session.testbench.film.state if session.testbench.film else "",
        "suites": [_suite(session, selected, entries) for selected in session.selected],
        "tests": entries,
    }


def _order(entry: Entry) -> tuple[str, str, str]:
    return entry["suite"], entry["id"], entry["nodeid"]


def _not_run(session: Session, nodeid: str, case: HriCase, reason: str) -> Entry:
    outcome = {"outcome": "not-run", "wall_s": 0.0, "failure": reason, "unmeasured": ""}
    return describe(case, nodeid) | outcome | measured(None, None, session.requirements)


def cover_of(entry: Entry) -> TestCover:
    """What an entry covered, as bits again."""
    code = None
    if entry["code"] is not None:
        statements, branches = entry["code"]["bits"]
        code = Bits(int(statements, 16), None if branches is None else int(branches, 16))
    plans = {agent: frozenset(labels) for agent, labels in entry["plans"].items()}
    return TestCover(entry["id"], code, plans)


def _code_under_test(session: Session, total: Bits | None) -> Entry:
    code = session.code
    return {
        "packages": list(session.testbench.code),
        "sha256": code.sha256 if code else "",
        "measured": total is not None,
        "reason": session.unmeasured if total is None or total.branches is None else "",
        "waivers": [{"file": w.file, "line": w.line, "reason": w.reason} for w in code.waivers] if code else [],
        "files": files(code, total) if code else [],
    }


def _suite(session: Session, selected: Selected, entries: Iterable[Entry]) -> Entry:
    suite = selected.suite
    mine = [entry for entry in entries if entry["suite"] == suite.name]
    covers = [cover_of(entry) for entry in mine]
    bits = union(covers)
    generation = suite.generation
    return {
        "name": suite.name,
        "seed": suite.seed,
        "tests": len(mine),
        "fidelity": " and ".join(sorted({entry["fidelity"] for entry in mine} - {""})),
        "generation": {
            "wall_s": round(selected.wall_s, 3),
            "cached": selected.cached,
            "bdi_runs": generation.bdi_runs,
            "iterations": generation.iterations,
            "converged_at": generation.converged_at,
            "q_delta": list(generation.q_delta),
            "distinct_texts": generation.distinct_texts,
            "notes": list(generation.notes),
        },
        "requirements": {r.id: _tally(r.id, mine) for r in session.requirements},
        "code": code_closure(session.code, bits) if session.code else {"statements": None, "branches": None},
        "plans": plan_closure(covers, generation.declared_plans),
        "cross": _cross(session.testbench, mine),
        "curve": curve(covers),
    }


def _tally(requirement: str, entries: Iterable[Entry]) -> Entry:
    verdicts = [entry["requirements"][requirement] for entry in entries]
    count = Counter(verdict["verdict"] for verdict in verdicts)
    triggers = sum(verdict["triggers"] for verdict in verdicts)
    return {"passed": count["Passed"], "failed": count["Failed"], "nc": count["NC"], "triggers": triggers}


def _cross(testbench: Testbench, entries: Iterable[Entry]) -> Entry:
    if testbench.cross is None:
        return {"bins": 0, "hit": 0, "impossible": 0, "missing": []}
    hits = set(testbench.cross.check(tuple(hit) for entry in entries for hit in entry.get("cross", ())))
    possible = [each for each in testbench.cross.bins() if each not in testbench.cross.impossible]
    return {
        "bins": len(testbench.cross.bins()),
        "hit": len(hits),
        "impossible": len(testbench.cross.impossible),
        "missing": [" x ".join(each) for each in possible if each not in hits],
    }


def reached(report: Entry, kind: str) -> list[tuple[str, float | None]]:
    """Per suite, the percentage that a gate of this kind is held against; None where nothing was measured.

    Statements and branches: of what is reachable. Assertions: requirements that were checked. Cross: of what is
    possible.
    """
    return [(suite["name"], _reached(suite, kind)) for suite in report["suites"]]


def _reached(suite: Entry, kind: str) -> float | None:
    if kind in ("statements", "branches"):
        closure = suite["code"][kind]
        return None if closure is None else float(closure["percent_reachable"])
    if kind == "plans":
        plans = suite["plans"].values()
        return percent(sum(len(each["covered"]) for each in plans), sum(each["total"] for each in plans))
    if kind == "assertions":
        tallies = suite["requirements"].values()
        return percent(sum(tally["passed"] + tally["failed"] > 0 for tally in tallies), len(tallies))
    cross = suite["cross"]
    return percent(cross["hit"], cross["bins"] - cross["impossible"])
