"""Code for which the study of drafts makes testbenches, with what people declare of it by hand."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
KINDS = ("messages", "states", "transitions", "values")

Names = dict[str, frozenset[str]]
"""Kind -> names."""


@dataclass(frozen=True)
class CodeBase:
    """Code to draft for.

    Args:
        key: a word.
        name: as the page calls it.
        folder: from which the draft is asked for.
        asked: arguments of `init FOLDER`.
        declared: what its own testbench declares.
        switches: published faults of the code: values of the environment variable `switch`.
        switch: the variable that switches them on; empty where there are none.
    """

    key: str
    name: str
    folder: Path
    asked: tuple[str, ...]
    declared: Names
    switches: tuple[str, ...] = ()
    switch: str = ""


def code_bases(folder: Path) -> Iterator[CodeBase]:
    """The code bases of this project; those of the tutorials are written into a folder."""
    nothing: frozenset[str] = frozenset()
    for page, files, values in (
        ("tutorial.md", ("barista.py", "pouring.py"), nothing),
        ("vacuum.md", ("vacuum.py",), frozenset({"pressed.button=start", "pressed.button=stop"})),
    ):
        blocks = dict(re.findall(r"^```python (\S+)\n(.*?)^```$", (ROOT / "docs" / page).read_text(), re.M | re.S))
        key = page.removesuffix(".md")
        target = folder / key
        target.mkdir()
        for name in files:
            (target / name).write_text(blocks[name], encoding="utf-8")
        declared = {"messages": _messages_of(blocks["conftest.py"]), "states": nothing, "transitions": nothing}
        asked = ("--from", files[0].removesuffix(".py"))
        yield CodeBase(key, f"[{key}](../{page})", target, asked, {**declared, "values": values})
    yield _home_care()
    yield _porter()


def _messages_of(testbench: str) -> frozenset[str]:
    """The messages that a hand-written testbench declares."""
    for node in ast.walk(ast.parse(testbench)):
        if isinstance(node, ast.keyword) and node.arg == "messages":
            return frozenset(name.id for name in ast.walk(node.value) if isinstance(name, ast.Name))
    return frozenset()


def _home_care() -> CodeBase:
    """The home-care robot: what `examples/home_care/conftest.py` declares of the robot's own code."""
    folder = ROOT / "examples" / "home_care"
    sys.path.insert(0, str(folder))
    try:
        from carebot.config import SWITCHES  # type: ignore[import-not-found]  # of the example's folder
        from carebot.messages import HEARD, SAID  # type: ignore[import-not-found]
        from carebot.tasks import ENDED, STATES, TASKS, transitions  # type: ignore[import-not-found]
    finally:
        sys.path.remove(str(folder))
    values = {f"state.name={state}" for state in STATES} | {f"order.kind={kind}" for kind in (*TASKS, ENDED)}
    declared = {
        "messages": frozenset(kind.__name__ for kind in (*HEARD, *SAID)),
        "states": frozenset(STATES),
        "transitions": frozenset(f"{source}>{target}" for source, target in transitions()),
        "values": frozenset(values),
    }
    name = "[home care](../../examples/home_care/README.md)"
    return CodeBase("home-care", name, folder, ("--from", "carebot"), declared, tuple(SWITCHES), "CAREBOT_FAULTS")


def _porter() -> CodeBase:
    """The asyncio controller with `transitions`."""
    from studies.code_bases import porter_declared as by_hand

    declared = {
        "messages": frozenset(by_hand.MESSAGES),
        "states": frozenset(by_hand.STATES),
        "transitions": frozenset(f"{source}>{target}" for source, target in by_hand.TRANSITIONS),
        "values": frozenset(f"{field}={text}" for field, texts in by_hand.VALUES.items() for text in texts),
    }
    return CodeBase("porter", "porter (asyncio, `transitions`)", ROOT / "studies" / "code_bases",
                    ("--from", "porter"), declared)  # fmt: skip
