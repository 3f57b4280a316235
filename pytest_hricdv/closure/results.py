"""From runs to the report model: one entry a test, made where it ran; one report, made where all entries meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv.case import CaseResult, HriCase
from pytest_hricdv.closure.closing import SCHEMA, Entry, close
from pytest_hricdv.closure.selected import Selected
from pytest_hricdv.closure.timeline import timeline
from pytest_hricdv.cover.assertions import COUNTS
from pytest_hricdv.cover.closure import percent
from pytest_hricdv.cover.listing import list_bits, list_code
from pytest_hricdv.cover.source import CodeMap
from pytest_hricdv.generate.suite import Suite, diagnose
from pytest_hricdv.monitor import Requirement, Verdict
from pytest_hricdv.testbench import Testbench


def describe(case: HriCase, nodeid: str) -> Entry:
    """What is known of a test before it runs."""
    test = case.abstract
    actions = [{"command": a.command, "parameters": dict(a.parameters)} for a in case.concrete.actions]
    return {
        "nodeid": nodeid,
        "suite": case.suite,
        "id": test.id,
        "aim": test.target,
        "name": test.name,
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
            "bits": list_bits(bits),
        }
    return {
        "requirements": {verdict.requirement: _verdict(verdict) for verdict in result.verdicts},
        "acted_s": [round(time_s, 3) for time_s in result.acted_s],
        "legs": list(result.outcome.outcomes),
        "sim_s": result.sim_s,
        "frozen_s": result.outcome.skipped_s,
        "fidelity": result.outcome.fidelity,
        "ended": result.outcome.ended,
        "record_sha256": result.record.sha256,
        "cross": {name: [list(hit) for hit in hits] for name, hits in result.cross.items()},
        "code": share,
        "timeline": timeline(result.record, result.verdicts, result.sim_s),
    }


def _verdict(verdict: Verdict | None) -> Entry:
    if verdict is None:
        none = dict.fromkeys(COUNTS, 0)
        return {"verdict": "NC", **none, "violations": [], "margin": None}
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
    until: Mapping[str, str]
    strict: bool
    version: str
    wall_s: float
    workers: int
    rerun: Rerun
    models: Entry
    products: Entry
    exploration: Entry
    sizes: Mapping[str, int]
    """Suite -> tests that there are of it, selected or not."""
    shard: str = ""


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
    lost = sorted(chosen.keys() - {entry["nodeid"] for entry in entries})
    unrun = [_not_run(session, nodeid, chosen[nodeid], reasons.get(nodeid, "")) for nodeid in lost]
    report = {
        "schema": SCHEMA,
        "version": session.version,
        "testbench": session.testbench.name,
        "wall_s": round(session.wall_s, 3),
        "workers": session.workers,
        "known_violations": dict(session.known),
        "known_until": dict(session.until),
        "strict": session.strict,
        **({"shard": session.shard} if session.shard else {}),
        "rerun": {"suite": session.rerun.suite, "options": list(session.rerun.options)},
        "requirements": {r.id: {"title": r.title, "source": r.source, "text": r.text} for r in session.requirements},
        "units": dict(session.testbench.units),
        "state": session.testbench.film.state if session.testbench.film else "",
        "code_under_test": {"packages": list(session.testbench.code), **list_code(session.code)},
        "models": session.models,
        "cross_products": session.products,
        "exploration": session.exploration,
        "suites": [_suite(each, session.sizes[each.suite.name], session.models) for each in session.selected],
        "tests": [*entries, *unrun],
    }
    return close(report, session.unmeasured)


def _not_run(session: Session, nodeid: str, case: HriCase, reason: str) -> Entry:
    outcome = {"outcome": "not-run", "wall_s": 0.0, "failure": reason, "unmeasured": ""}
    return describe(case, nodeid) | outcome | measured(None, None, session.requirements)


def _diagnosis(suite: Suite) -> Entry:
    found = diagnose(suite)
    return {
        "distinct_subsets": found.distinct_subsets,
        "belief_entropy_bits": found.belief_entropy_bits,
        "belief_entropy_most_bits": found.belief_entropy_most_bits,
        "plans_executed": {agent: len(labels) for agent, labels in found.plans.items()},
        "last_new_plan": {"iteration": suite.generation.last_new_plan_at, "test": found.last_new_plan_at},
    }


def _suite(selected: Selected, size: int, models: Entry) -> Entry:
    generation = selected.suite.generation
    return {
        "name": selected.suite.name,
        "seed": selected.suite.seed,
        "size": size,
        "generation": {
            "wall_s": round(selected.wall_s, 3),
            "cached": selected.cached,
            "bdi_runs": generation.bdi_runs,
            "iterations": generation.iterations,
            "converged_at": generation.converged_at,
            "q_delta": list(generation.q_delta),
            "distinct_texts": generation.distinct_texts,
            "reward": generation.reward,
            "diagnosis": _diagnosis(selected.suite),
            "notes": list(generation.notes),
        },
        "plans": {agent: {"declared": list(labels)} for agent, labels in _declared(selected.suite, models).items()},
    }


def _declared(suite: Suite, models: Entry) -> Mapping[str, Sequence[str]]:
    """The plans to cover. Tests that a model made and a file brought are still held against that model."""
    if suite.generation.declared_plans or not any(test.plans for test in suite.tests):
        return suite.generation.declared_plans
    return {agent: list(model["plans"]) for agent, model in models.items()}
