"""The registry of optional features: each is a folder of `pytest_hricdv.extra`, and only this list names them.

A feature offers names to the core. Each is in the module of its role, or in `feature.py` if the feature has no such
module:

- `feature`: `FEATURE`, what it does in a session (`session.feature.Feature`);
- `execution`: `EXECUTION`, what it adds to runs (`execution.execution_feature.ExecutionFeature`);
- `records`: `SECTIONS` and `TEST_SECTIONS`, its keys of `report.json`, and `SHARES`, its percentages for thresholds
  (`results.section`); `further_engines(test)`, other physics engines that a test ran on;
- `merging`: `merge(reports, merged)` for its keys of a merged report, `rebuilt(report, kept)` for those of a report
  that is rebuilt from a journal, and `associate(report, is_of_all_runs=...)` for those of a campaign;
- `view`: `VIEW`, what it shows in the terminal and on the page (`report.view.View`);
- `commands`: `COMMANDS`, its commands of `hricdv report` (`report.view.ReportCommand`);
- `live`: `look(path, scratch)`, how far a campaign is, as the fields of `extra.answers.live_server.LiveState`;
- `command`: `INIT`, what `hricdv init` does with code, and `add_command(commands)` for a
  command of its own;
- `remote`: `REMOTE`, workers on other machines (`session.remote.Remote`);
- `bag_writer`: `write_bag(path, record)`, which writes the messages of a run as a bag and returns whether it has any;
- `drafting`: `ROS_TOOLS`, the packages and console scripts of ROS 2 that drafts need.

Nothing below `extra` imports a feature, and no feature imports another one: a feature is removed by deleting its
folder, its line here, and its tests.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any

FEATURES = MappingProxyType(
    {
        "mutation": ("feature", "records", "view"),
        "suggestion": ("feature", "command", "records"),
        "engines": ("feature", "view"),
        "draft": ("feature", "command"),
        "closing": ("feature", "records", "view"),
        "campaign": ("records", "view", "live"),
        "verification_plan": ("feature",),
        "cluster": ("feature",),
        "diagnosis": ("feature", "records", "merging", "view"),
        "audit": ("feature", "records"),  # before what follows failures up: some are none
        "unused": ("feature",),
        "search": ("feature", "records", "view"),
        "schedules": ("feature", "execution", "command", "records", "view"),
        "patch": ("feature", "records", "view"),
        "trend": ("feature",),
        "film": ("feature", "records"),
        "traces": ("feature", "records"),
        "evidence": ("command",),
        "logs": ("feature", "command"),
        "answers": ("commands",),
        "qualification": ("command",),
        "oracle": ("execution",),
        "ros2": ("execution", "feature", "drafting", "bag_writer"),
    }
)
"""Feature -> its modules by role, in the order in which sections follow each other in the terminal and on the page."""


@cache
def offers(role: str, name: str) -> tuple[Any, ...]:
    """The objects that features offer under a name, in the order of the list; a feature without that name offers
    nothing.

    Args:
        role: one of the modules above, which has the name where the feature has such a module; otherwise its module
            `feature` may have it.
        name: the name of an attribute of that module.
    """
    found = []
    for feature, roles in FEATURES.items():
        module = role if role in roles else "feature"
        if module in roles:
            found.append(import_module(f"pytest_hricdv.extra.{feature}.{module}"))
    return tuple(getattr(module, name) for module in found if hasattr(module, name))
