"""How right drafts are: what is found in code, beside what hand-written testbenches of the same code declare.

    python -m studies.drafts            # what is found (seconds), written into docs/draft.md
    python -m studies.drafts --green    # and the time to the first green run (minutes)

The code of the tutorials is taken from their pages, without world, model, requirements and testbench.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.findings import Findings
from pytest_hricdv.extra.draft.running import with_transitions
from studies.page import replace_figures, table

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "draft.md"
COMMAND = "python -m studies.drafts"
KINDS = ("messages", "states", "transitions", "values")
HEAD = ("code", *(f"{kind}: found, right, declared" for kind in KINDS))

Names = dict[str, frozenset[str]]
"""Kind -> names."""


@dataclass(frozen=True)
class CodeBase:
    """Code to draft for: its name, its folder, what is asked for, and what its own testbench declares."""

    name: str
    folder: Path
    package: str
    declared: Names


def code_bases(folder: Path) -> Iterator[CodeBase]:
    """The code bases; those of the tutorials are written into a folder."""
    nothing: frozenset[str] = frozenset()
    for page, files, values in (
        ("tutorial.md", ("barista.py", "pouring.py"), nothing),
        ("vacuum.md", ("vacuum.py",), frozenset({"pressed.button=start", "pressed.button=stop"})),
    ):
        blocks = dict(re.findall(r"^```python (\S+)\n(.*?)^```$", (ROOT / "docs" / page).read_text(), re.M | re.S))
        target = folder / page.removesuffix(".md")
        target.mkdir()
        for name in files:
            (target / name).write_text(blocks[name], encoding="utf-8")
        declared = {"messages": _messages_of(blocks["conftest.py"]), "states": nothing, "transitions": nothing}
        yield CodeBase(f"[{page.removesuffix('.md')}]({page})", target, files[0][:-3], {**declared, "values": values})
    yield _home_care()


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
        from carebot.messages import HEARD, SAID  # type: ignore[import-not-found]  # of the example's folder
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
    return CodeBase("[home care](home-care.md)", folder, "carebot", declared)


def names_found(findings: Findings, fields: frozenset[str]) -> Names:
    """What a draft has found; values only of fields whose values a person has declared."""
    machine = next((machine for machine in findings.machines if machine.told), None)
    values = {
        f"{message.topic}.{part.name}={value.text}"
        for message in findings.messages
        for part in message.fields
        for value in part.values
        if f"{message.topic}.{part.name}" in fields
    }
    return {
        "messages": frozenset(message.name for message in findings.messages),
        "states": frozenset(state.name for state in machine.states) if machine else frozenset(),
        "transitions": frozenset(f"{m.source}>{m.target}" for m in machine.transitions) if machine else frozenset(),
        "values": frozenset(values),
    }


def figures(folder: Path) -> str:
    """The table: of each kind, how many were found, how many of these are right, and how many are declared."""
    rows = []
    for code in code_bases(folder):
        fields = frozenset(name.partition("=")[0] for name in code.declared["values"])
        found = names_found(with_transitions(analyse(code.package, code.folder)), fields)
        cells = [
            f"{len(found[kind])}, {len(found[kind] & code.declared[kind])}, {len(code.declared[kind])}"
            for kind in KINDS
        ]
        rows.append([code.name, *cells])
    return table(HEAD, rows)


def green(folder: Path) -> Iterator[str]:
    """The seconds to a draft, and from there to its first run, of each code base; a line each."""
    for code in code_bases(folder):
        target = folder / f"draft-of-{code.package}"
        begin_s = time.monotonic()
        init = [sys.executable, "-m", "pytest_hricdv", "init", str(target), "--from", code.package]
        subprocess.run(init, cwd=code.folder, check=True, capture_output=True)
        drafted_s = time.monotonic() - begin_s
        done = subprocess.run([sys.executable, "-m", "pytest", "-q"], cwd=target, capture_output=True, text=True)
        total_s = time.monotonic() - begin_s
        tests = re.findall(r"^tests: .*$", done.stdout, re.MULTILINE)
        yield f"{code.package}: draft {drafted_s:.0f} s, with first run {total_s:.0f} s: {' '.join(tests)}"


def main() -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--green", action="store_true", help="measure the time to the first green run as well")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        measured = figures(Path(name))
    replace_figures(PAGE, COMMAND, measured)
    print(measured)
    if options.green:
        with tempfile.TemporaryDirectory() as name:
            for line in green(Path(name)):
                print(line, flush=True)


if __name__ == "__main__":
    main()
