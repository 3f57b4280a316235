"""`write_parquet` exports the runs of a campaign as a Parquet file, with a row for each, for the command `export`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from pytest_hricdv._base.atomic_file import replace_file
from pytest_hricdv.extra.campaign.database import Row
from pytest_hricdv.extra.campaign.plan import CampaignError, CampaignPlan
from pytest_hricdv.extra.campaign.store import Store

BATCH = 10_000  # maximum number of rows in memory, about 20 MB


def write_parquet(store: Store, plan: CampaignPlan, path: Path) -> int:
    """Write all runs; returns how many.

    Columns: run, test, suite, k, outcome, note, sim_s (s), sha256 of the record, statements and branches covered,
    worker, host; and for each requirement NAME its verdict NAME, NAME_triggers and NAME_margin (null: there is none).

    Raises:
        CampaignError: pyarrow is not installed, or the file cannot be written.
    """
    try:
        import pyarrow as arrow
        from pyarrow import parquet
    except ImportError:
        raise CampaignError(
            "export --parquet: pyarrow is not installed: pip install 'pytest-hricdv[cluster]'"
        ) from None
    names = sorted(plan.initial_report.requirements)
    schema = arrow.schema(_columns(arrow, names))
    count, rows = 0, _records(store, plan, names)
    try:
        with replace_file(path) as part, parquet.ParquetWriter(part, schema) as writer:
            while batch := list(islice(rows, BATCH)):
                writer.write_table(arrow.Table.from_pylist(batch, schema=schema))
                count += len(batch)
    except OSError as error:
        raise CampaignError(f"export --parquet={path}: {error.strerror or error}") from None
    return count


def _columns(arrow: Any, names: list[str]) -> list[tuple[str, Any]]:
    texts = ["run", "test", "suite", "outcome", "note", "sha256", "worker", "host"]
    columns = [(name, arrow.string()) for name in texts]
    columns += [(name, arrow.int64()) for name in ("k", "statements", "branches")]
    columns.append(("sim_s", arrow.float64()))
    for name in names:
        columns += [(name, arrow.string()), (f"{name}_triggers", arrow.int64()), (f"{name}_margin", arrow.float64())]
    return columns


def _records(store: Store, plan: CampaignPlan, names: list[str]) -> Iterator[dict[str, object]]:
    workers = store.workers()
    for row in store.rows():
        test, worker = plan.planned.tests[row.key[0]], workers.get(row.worker)
        yield {
            "run": plan.name(row.key),
            "test": plan.tests[row.key[0]].id,
            "suite": test.suite,
            "k": row.key[1],
            "outcome": row.outcome,
            "note": row.summary.note,
            "sha256": row.sha256,
            "worker": worker.address if worker else "",
            "host": worker.host if worker else "",
            "statements": int(row.summary.statements, 16).bit_count(),
            "branches": int(row.summary.branches, 16).bit_count(),
            "sim_s": row.sim_s,
            **_requirement_cells(row, names),
        }


def _requirement_cells(row: Row, names: list[str]) -> dict[str, object]:
    cells: dict[str, object] = {}
    for name, (verdict, triggers, margin) in zip(names, row.summary.judgements, strict=False):
        cells |= {name: verdict, f"{name}_triggers": triggers, f"{name}_margin": margin}
    return cells
