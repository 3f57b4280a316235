"""How right drafts are: what they find in code, compared with what hand-written testbenches of the same code declare.

The results are written into docs/studies/drafts.md.

    python -m studies.drafts                               # what is found (seconds)
    python -m studies.drafts --ros2-packages FOLDER        # of public packages of ROS 2 as well, cloned into a folder
    python -m studies.drafts --own [--only porter,dance]   # and a requirement of one's own (a minute or two)
    python -m studies.drafts --green [--only porter,dance] # and the time to the first green run (many minutes)

The code of the tutorials is taken from their pages, without world, model, requirements and testbench; the porter's is
in studies/code_bases/, and needs the library `transitions` to be run. Nodes need `rclpy` to be run, not to be read.
What is not measured keeps the figures that it had.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.node_analysis import analyse_node
from pytest_hricdv.extra.draft.ros.executable import find_executable
from pytest_hricdv.extra.draft.ros.interfaces import is_installed
from studies.code_bases import KINDS, CodeBase, Names, code_bases, ros2
from studies.draft_table import note, write_page
from studies.own_requirement import checked, edited, own_requirement


def chosen(folder: Path, packages: Path | None, only: Sequence[str]) -> Iterator[CodeBase]:
    """The code bases of these keys, or all; those of ROS 2 where there is a folder for their packages."""
    every = [*code_bases(folder), *(ros2.nodes(packages) if packages is not None else ())]
    yield from (code for code in every if not only or code.key in only)


def names_found(code: CodeBase) -> Names:
    """What a draft finds in code; values only of fields whose values a person has declared."""
    fields = frozenset(name.partition("=")[0] for name in code.declared["values"])
    if code.asked[0] != "--ros2":
        return _names(analyse(code.asked[1], code.folder), fields)
    model, start = analyse_node(find_executable(code.asked[1], code.folder))
    declared = frozenset(f"{endpoint.kind} {endpoint.name} {endpoint.type}" for endpoint in start.declared)
    return {**_names(model, fields), "messages": declared}


def _names(model: CodeModel, fields: frozenset[str]) -> Names:
    machine = model.machine
    values = {
        f"{message.topic}.{part.name}={value.text}"
        for message in model.messages
        for part in message.fields
        for value in part.values
        if f"{message.topic}.{part.name}" in fields
    }
    return {
        "messages": frozenset(message.name for message in model.messages),
        "states": frozenset(state.name for state in machine.states) if machine else frozenset(),
        "transitions": frozenset(f"{m.source}>{m.target}" for m in machine.transitions) if machine else frozenset(),
        "values": frozenset(values),
    }


def found(code: CodeBase) -> dict[str, str]:
    """Of each kind, how many names were found, how many of these are right, and how many are declared."""
    names = names_found(code)
    return {
        kind: f"{len(names[kind])}, {len(names[kind] & code.declared[kind])}, {len(code.declared[kind])}"
        for kind in KINDS
    }


def draft(code: CodeBase, target: Path, *options: str) -> None:
    """Have a draft made in a folder."""
    init = [sys.executable, "-m", "pytest_hricdv", "init", str(target), *code.asked, *options]
    subprocess.run(init, cwd=code.folder, check=True, capture_output=True)


def own(code: CodeBase, target: Path) -> dict[str, object]:
    """How many lines a requirement of one's own takes, and its verdict, in a draft without first runs: it needs none.

    Raises:
        EditError: the draft has not what an edit replaces.
    """
    draft(code, target, "--no-run")
    asked = own_requirement(code.key)
    return {"edited_lines": edited(asked, target), "own": checked(asked, target)}


def green(code: CodeBase, target: Path) -> dict[str, int]:
    """The processor time (s) to a draft, and to the end of its first green run.

    Raises:
        RuntimeError: the run is not green.
    """
    begin_s = _processor_s()
    draft(code, target)
    draft_s = _processor_s() - begin_s
    done = subprocess.run([sys.executable, "-m", "pytest", "-q"], cwd=target, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{code.key}: the draft is not green:\n{done.stdout[-3000:]}")
    return {"draft_s": round(draft_s), "green_s": round(_processor_s() - begin_s)}


def _processor_s() -> float:
    """Processor time of all processes that have ended: the machine's other work does not count."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--green", action="store_true", help="measure the time to the first green run as well")
    parser.add_argument("--own", action="store_true", help="check a requirement of one's own in each")
    parser.add_argument("--ros2-packages", type=Path, metavar="FOLDER", help="of repositories, cloned where missing")
    parser.add_argument("--only", default="", metavar="KEYS", help="of some code bases, such as porter,dance")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        for code in chosen(Path(name), options.ros2_packages, list(filter(None, options.only.split(",")))):
            note(code, {"found": found(code)})
            is_runnable = code.asked[0] != "--ros2" or is_installed("rclpy")
            if options.own and is_runnable:
                note(code, own(code, Path(name) / f"own-in-{code.key}"))
            if options.green and is_runnable:
                note(code, green(code, Path(name) / f"draft-of-{code.key}"))
            if (options.own or options.green) and not is_runnable:
                print(f"{code.key}: not run: rclpy is not installed, see docs/ros2.md")
    if options.ros2_packages is None:
        print("nodes of ROS 2 were not read: --ros2-packages FOLDER names a folder for their repositories")
    print(write_page())


if __name__ == "__main__":
    main()
