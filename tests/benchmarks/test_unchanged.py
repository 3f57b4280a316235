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
    2,
    outcomes=["released"],
    faults=["it fell"],
    concrete={"actions": [{"parameters": {"faults": 1.0}}]},
    requirements={"R1": {"vacuous": 1, "nearest_miss": None}},
)
NEW = report(
    3,
    outcomes=["released"],
    errors=["it fell"],
    concrete={"actions": [{"parameters": {"faults": 1.0}}]},
    requirements={"R1": {"untriggered": 1, "near_miss": None}},
)


def stored(folder: Path, data: dict[str, Any]) -> dict[str, Any]:
    """What is read of a report that was stored."""
    file = folder / "before.gz"
    file.write_bytes(gzip.compress(json.dumps({"rl seed 0": data}).encode()))
    return read(file)["rl seed 0"]


def test_only_real_differences_show_against_a_store_of_schema_2(tmp_path: Path) -> None:
    now = stored(tmp_path, NEW)
    assert list(differences(stored(tmp_path, OLD), now)) == []
    now["tests"][0]["outcomes"] = ["discarded"]
    assert list(differences(stored(tmp_path, OLD), now)) == [".tests[0].outcomes[0]: released became discarded"]
