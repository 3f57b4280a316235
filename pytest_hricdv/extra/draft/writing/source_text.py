"""Pieces of drafted source text: imports, classes of messages, tuples of texts."""

from __future__ import annotations

import json
from collections.abc import Iterable

from pytest_hricdv.extra.draft.found.findings import Message
from pytest_hricdv.extra.draft.writing.drafted import Draft

OWN = ("ports", "world")
"""Modules of the draft."""


WIDTH = 88
"""Longer imports are one name a line, as ruff has them where nothing else is configured."""


def import_lines(draft: Draft, needs: Iterable[tuple[str, str]]) -> list[str]:
    """Imports, sorted; those of the draft apart where the code is in another folder."""
    by_module: dict[str, list[str]] = {}
    for module, name in needs:
        if name not in by_module.setdefault(module, []):
            by_module[module].append(name)
    lines = {module: _import(module, sorted(by_module[module])) for module in sorted(by_module)}
    is_apart = draft.findings.root != str(draft.folder)
    groups = [[module for module in lines if (module in OWN) == is_own] for is_own in (False, True)]
    if not is_apart or not all(groups):
        return list(lines.values())
    return [*(lines[module] for module in groups[0]), "", *(lines[module] for module in groups[1])]


def _import(module: str, names: list[str]) -> str:
    line = f"    from {module} import {', '.join(names)}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"    from {module} import (", *(f"        {name}," for name in names), "    )"])


def message_classes(messages: Iterable[Message]) -> list[tuple[str, str]]:
    """Module and name of each class."""
    return [(message.module or "ports", message.name) for message in messages]


def tuple_text(names: Iterable[str]) -> str:
    """Source text of a tuple of texts."""
    listed = [json.dumps(name, ensure_ascii=False) for name in names]
    return "(" + ", ".join(listed) + ("," if len(listed) == 1 else "") + ")"
