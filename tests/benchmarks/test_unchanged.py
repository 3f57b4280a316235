"""A store of another version is compared by what it says, not by how its keys were called."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

from benchmarks.unchanged import differences, read


def report(schema: int, **test: Any) -> dict[str, Any]:
    """A report with one test."""
    return {"schema": f"hricdv-report/{schema}", "wall_s": float(schema), "tests": [test]}


OLD = report(
    1,
    legs=["released"],
    frozen_s=2.5,
    timeline={"end_s": 9.0, "attempts": {"R1": "1-2!"}},
    failure="R1 Failed\nturns:   released",
)
NEW = report(
    2,
    outcomes=["released"],
    skipped_s=2.5,
    timeline={"end_s": 9.0, "triggers": {"R1": "1-2!"}},
    failure="R1 Failed\noutcome: released",
)


def stored(folder: Path, data: dict[str, Any]) -> dict[str, Any]:
    """What is read of a report that was stored."""
    file = folder / "before.gz"
    file.write_bytes(gzip.compress(json.dumps({"rl seed 0": data}).encode()))
    return read(file)["rl seed 0"]


def test_only_real_differences_show_against_a_store_of_schema_1(tmp_path: Path) -> None:
    now = stored(tmp_path, NEW)
    assert list(differences(stored(tmp_path, OLD), now)) == []
    now["tests"][0]["outcomes"] = ["discarded"]
    assert list(differences(stored(tmp_path, OLD), now)) == [".tests[0].outcomes[0]: released became discarded"]
