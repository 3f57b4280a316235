"""The optional parts: each is a folder of `pytest_hricdv.extra`, and this list is the only place that names them.

A part shows the core up to six faces, each a module of its folder that the core loads by name, when it needs it:

- `part`: what it does in a session: options, checks, work on each result and after the tests (`session.part.Part`);
- `execution`: what it adds to runs: criteria, a middleware (`execution.execution_part.ExecutionPart`);
- `records`: the keys that it adds to `report.json` (`results.section.Section`);
- `merging`: its keys of a merged report, where they are not just absent (`merge(reports, merged)`), of one that is
  rebuilt of a journal (`rebuilt(report, kept)`), and of a campaign (`associated(report, is_of_all_runs=...)`);
- `view`: what it shows of them: lines for the terminal, a section of the page (`report.view.View`);
- `commands`: what it does with reports: commands of `python -m pytest_hricdv.report` (`report.command.Command`).

So nothing below `extra` imports it, and a part is deleted with its folder, its line here, and its tests.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any

PARTS = MappingProxyType(
    {
        "mutation": ("part", "records", "view"),
        "suggestion": ("part", "records", "view"),
        "engines": ("part", "records", "view"),
        "draft": (),  # commands of `python -m pytest_hricdv` only
        "recordings": (),  # read for drafts
        "drift": ("part",),
        "closing": ("part", "records", "merging", "view"),
        "campaign": ("records", "view"),
        "verification_plan": ("part", "records", "merging", "view"),
        "cluster": ("part",),
        "diagnosis": ("part", "records", "merging", "view", "commands"),
        "audit": ("part", "records", "view"),  # before what follows failures up: some are none
        "search": ("part", "records", "merging", "view"),
        "trend": ("part", "records", "view"),
        "film": ("part", "records", "view"),
        "traces": ("part", "records", "view"),
        "oracle": ("execution",),
        "ros2": ("execution", "part", "records", "view"),
    }
)
"""Part -> its faces; in the order in which sections follow each other in the terminal and on the page."""


@cache
def faces(face: str, name: str) -> tuple[Any, ...]:
    """What parts offer under a name in their modules of one face, in the order of the list.

    Args:
        face: `part`, `execution`, `records`, `merging`, `view` or `commands`.
        name: of an attribute of that module; a part whose module has none offers nothing.
    """
    modules = (import_module(f"pytest_hricdv.extra.{part}.{face}") for part, has in PARTS.items() if face in has)
    return tuple(getattr(module, name) for module in modules if hasattr(module, name))
