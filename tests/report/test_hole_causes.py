"""What no test covers, by what it has in common."""

from __future__ import annotations

from typing import Any

from pytest_hricdv.report.holes import HoleCause, hole_causes
from tests.report import sample


def _gap(kind: str, place: str, *items: str, reason: str = "so", reach: str = "", test: str = "") -> dict[str, Any]:
    return {
        "kind": kind,
        "location": place,
        "items": list(items),
        "reason": reason,
        "suggestion": reach,
        "test": test,
        "beliefs": [],
    }


def _causes(*gaps: dict[str, Any], **changed: Any) -> dict[str, HoleCause]:
    report = sample.data(tests=3) | changed
    report["closure"]["gaps"] = list(gaps)
    return {f"{cause.kind} | {cause.title}": cause for cause in hole_causes(sample.typed(report))}


def test_a_function_is_one_cause_with_its_statements_and_branches_and_the_test_to_vary() -> None:
    report = sample.data(tests=3)
    near = report["tests"][1]["id"]
    place = "controller/states.py Robot.move"
    found = _causes(
        _gap("statements", place, "15", "16", reach=f"vary {near}: line 14 has to go on", test=near),
        _gap("branches", place, "20->22", reach="turn line 20"),
        _gap("statements", "controller/states.py", "7", reason="waived as unreachable: so"),
        tests=report["tests"],
        suites=report["suites"],
        rerun_options={"suite": "rl", "options": ["--hri-strict"]},
    )
    [(title, cause)] = found.items()
    assert title == f"2 statements and 1 branch | {place}"
    assert (cause.count, cause.reach) == (3, f"vary {near}: line 14 has to go on")
    assert cause.points[1] == ("20->22", "turn line 20")
    assert cause.test is not None
    assert cause.command == f'pytest "{cause.test.nodeid}" --hri-suite=rl --hri-seed=0 --hri-strict'


def test_bins_that_share_values_are_one_cause_and_each_bin_is_in_one() -> None:
    report = sample.data(tests=3)
    hit = {hits["bin"][0] for suite in report["suites"] for hits in suite["cross"]["products"]["handover"]["hits"]}
    missing = [tuple(bin_) for suite in report["suites"] for bin_ in suite["cross"]["products"]["handover"]["missing"]]
    found = _causes(*(_gap("bins", "handover", " x ".join(bin_)) for bin_ in missing), suites=report["suites"])
    points = [point for cause in found.values() for point, _ in cause.points]
    assert sorted(points) == sorted(" x ".join(bin_) for bin_ in missing)
    assert len(points) == len(set(points))
    assert len(found) < len(missing)
    whole = next(gpl for gpl, _ in missing if gpl not in hit)
    cause = next(cause for title, cause in found.items() if title.endswith(f"every bin with gpl {whole}"))
    assert {point.split(" x ")[0] for point, _ in cause.points} == {whole}
    counts = [cause.count for cause in found.values()]
    assert counts == sorted(counts, reverse=True)
