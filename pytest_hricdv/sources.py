"""The texts that coverage is shown in: the code under test, and the agents of the model."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv.cover.source import CodeMap
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.model import Model

_NO_PLAN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
_LABEL = re.compile(r"@([a-z]\w*)")


def code_texts(code: CodeMap) -> list[dict[str, Any]]:
    """The files under test, in the order in which the tests' coverage bits count their statements and branches."""
    return [
        {
            "file": file.name,
            "text": file.text,
            "statements": list(file.statements),
            "branches": [list(arc) for arc in file.branches],
        }
        for file in code.files
    ]


def model_texts(model: Model, plans: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    """The agents' sources, with the line of each coverage plan; nothing of a model that cannot be read.

    Args:
        model: of the testbench; files are named relative to the folder above its own.
        plans: agent -> labels of the plans that are to be covered.
    """
    if not plans:
        return []
    from pytest_hricdv.bdi.project import read_project  # tests that are in files need no BDI engine

    try:
        texts = {path: path.read_text(encoding="utf-8") for path in model.files() if path.suffix == ".asl"}
        own = {entry.name: entry.source for entry in read_project(model.path).agents}
    except (GenerateError, ValueError, OSError):
        return []
    found = []
    for agent, labels in plans.items():
        missing = set(labels)
        for path in _with_includes(own.get(agent), texts):
            lines = {label: line for label, line in _labels(texts[path]) if label in missing}
            if lines:
                missing -= lines.keys()
                name = os.path.relpath(path, model.path.parent.parent)
                found.append({"agent": agent, "file": name, "text": texts[path], "plans": lines})
    return found


def _with_includes(own: Path | None, texts: Mapping[Path, str]) -> list[Path]:
    """An agent's own file, then those it speaks of: it may include them."""
    if own is None or own not in texts:
        return []
    return [own, *(path for path in sorted(texts) if path != own and f'"{path.name}"' in texts[own])]


def _labels(text: str) -> Iterable[tuple[str, int]]:
    """Labels of plans with their lines; comments and strings have none."""
    bare = _NO_PLAN.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    return [(match[1], bare.count("\n", 0, match.start()) + 1) for match in _LABEL.finditer(bare)]
