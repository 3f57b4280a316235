"""A test's results as JUnit properties, for whatever reads JUnit XML and nothing else."""

from collections.abc import Mapping
from typing import Any

from pytest_hricdv.report.figure import natural


def properties(test: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Name and value pairs for `item.user_properties`: suite, id, seed, verdicts, coverage, fidelity, legs.

    What a test does not have, such as the coverage of unmeasured code or an outcome while it still runs, has no
    property: an empty one would read as zero somewhere.
    """
    pairs: list[tuple[str, object]] = [
        ("hri.suite", test["suite"]),
        ("hri.id", test["id"]),
        ("hri.seed", test["seed"]),
        ("hri.outcome", test.get("outcome")),
    ]
    pairs += [
        (f"hri.{name}", test["requirements"][name]["verdict"]) for name in sorted(test["requirements"], key=natural)
    ]
    code = test["code"] or {}
    pairs.append(("hri.statements_percent", _tenths(code.get("percent"))))
    pairs.append(("hri.simulated_s", _tenths(test["sim_s"])))
    pairs.append(("hri.fidelity", test.get("fidelity") or None))
    pairs.append(("hri.legs", " ".join(test["legs"])))
    pairs.append(("hri.record_sha256", test.get("record_sha256") or None))
    return tuple((name, str(value)) for name, value in pairs if value is not None)


def _tenths(value: float | None) -> str | None:
    return None if value is None else f"{value:.1f}"
