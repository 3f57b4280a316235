"""How right drafts are: what is found in code, beside what hand-written testbenches of the same code declare.

    python -m studies.drafts            # what is found (seconds), written into docs/draft.md
    python -m studies.drafts --green    # and the time to the first green run (minutes)

The code of the tutorials is taken from their pages, without world, model, requirements and testbench; the porter's is
in studies/code_bases/, and needs the library `transitions` to be run.
"""

from __future__ import annotations

import argparse
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.findings import Findings
from pytest_hricdv.extra.draft.running import with_transitions
from studies.code_bases import KINDS, ROOT, Names, code_bases
from studies.page import replace_figures, table

PAGE = ROOT / "docs" / "draft.md"
COMMAND = "python -m studies.drafts"
HEAD = ("code", *(f"{kind}: found, right, declared" for kind in KINDS))


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
        found = names_found(with_transitions(analyse(code.asked[1], code.folder)), fields)
        cells = [
            f"{len(found[kind])}, {len(found[kind] & code.declared[kind])}, {len(code.declared[kind])}"
            for kind in KINDS
        ]
        rows.append([code.name, *cells])
    return table(HEAD, rows)


def green(folder: Path) -> Iterator[str]:
    """The processor time (s) to a draft, and from there to its first runs, of each code base; a line each."""
    for code in code_bases(folder):
        target = folder / f"draft-of-{code.key}"
        begin_s = _processor_s()
        init = [sys.executable, "-m", "pytest_hricdv", "init", str(target), *code.asked]
        subprocess.run(init, cwd=code.folder, check=True, capture_output=True)
        drafted_s = _processor_s() - begin_s
        ends = []
        for suite in ("rl", "closure"):
            command = [sys.executable, "-m", "pytest", "-q", f"--hri-suite={suite}"]
            done = subprocess.run(command, cwd=target, capture_output=True, text=True)
            total_s = _processor_s() - begin_s
            tests = re.findall(r"^tests: .*$", done.stdout, re.MULTILINE)
            ends.append(f"{suite} after {total_s:.0f} s, exit status {done.returncode}: {' '.join(tests)}")
        yield f"{code.key}: draft {drafted_s:.0f} s; {'; '.join(ends)}"


def _processor_s() -> float:
    """Processor time of all processes that have ended: the machine's other work does not count."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


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
