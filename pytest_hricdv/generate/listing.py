"""The model as plain data for a report: each covered agent's source, and the lines of its plans."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from .error import GenerateError
from .model import Model


def list_model(model: Model, root: Path) -> dict[str, Any]:
    """Covered agent -> its `file` (relative to `root`), `source`, and `plans`: label -> line.

    Raises:
        GenerateError: a source cannot be read, or there is no such agent.
    """
    from pytest_hricdv.bdi import BdiError
    from pytest_hricdv.bdi.language.parser import read_program
    from pytest_hricdv.bdi.language.project_reader import read_project

    try:
        project = read_project(model.path)
        sources = {entry.name: entry.source for entry in project.agents}
        listed = {}
        for agent in model.covered:
            path = sources[agent]
            plans = read_program(path).plans
            listed[agent] = {
                "file": Path(os.path.relpath(path, root)).as_posix(),
                "source": path.read_text(encoding="utf-8"),
                "plans": {plan.label: plan.location.line for plan in plans if plan.has_label},
            }
    except (BdiError, OSError, UnicodeDecodeError) as error:
        raise GenerateError(f"BDI model {model.path}: {error}") from error
    except KeyError as error:
        raise GenerateError(f"{model.path}: no agent {error} in this model") from None
    return listed
